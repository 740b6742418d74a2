"""The array types of the package and its one linear solve."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.floating[Any]]
"""Floats of any shape; numbers only."""
Traceable: TypeAlias = npt.NDArray[np.floating[Any]]
"""Floats or, while a loop is traced, CasADi symbols that behave like them."""

Joints: TypeAlias = float | Array
"""One number for all joints, or one for each, shape (n,); a part makes an array of a list."""


def solve_spd(A: Traceable, b: Traceable) -> Traceable:
    """Solve A x = b.

    Args:
        A: Symmetric positive definite matrix, shape (n, n).
        b: Right-hand side, shape (n,).

    Returns:
        x, shape (n,).
    """
    if isinstance(A, np.ndarray) and isinstance(b, np.ndarray):
        return np.linalg.solve(A, b)
    return _solve_ldl(A, b)


def _solve_ldl(A: Traceable, b: Traceable) -> Traceable:
    """Solve A x = b for symbols, entry by entry: A = L D L^T, then two substitutions."""
    n = b.shape[0]
    L: list[list[Any]] = [[None] * n for _ in range(n)]
    W: list[list[Any]] = [[None] * n for _ in range(n)]  # W = L D
    D: list[Any] = []
    for i in range(n):
        for j in range(i):
            W[i][j] = A[i, j] - sum(W[i][k] * L[j][k] for k in range(j))
            L[i][j] = W[i][j] / D[j]
        D.append(A[i, i] - sum(W[i][k] * L[i][k] for k in range(i)))
    x: list[Any] = []
    for i in range(n):
        x.append(b[i] - sum(L[i][k] * x[k] for k in range(i)))
    for i in reversed(range(n)):
        x[i] = x[i] / D[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))
    return np.stack(x)


def is_known(value: Any) -> bool:
    """Whether a parameter is a number or an array of numbers: not a symbol of traced code."""
    return isinstance(value, float | int | np.ndarray | np.generic | list | tuple)


def is_off(value: Any, off: float = 0.0) -> bool:
    """Whether a parameter is known to leave its block out; a symbol is not."""
    return is_known(value) and bool(np.all(np.asarray(value) == off))
