"""The array type of the package, its one linear solve, and checks of the numbers it is given."""

from numbers import Integral, Real
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ftcfa.errors import ParameterError, ShapeError

Array: TypeAlias = npt.NDArray[np.floating[Any]]
"""Floats of any shape; numbers only."""
Traceable: TypeAlias = npt.NDArray[np.floating[Any]]
"""Floats or, while a loop is traced, CasADi symbols that behave like them."""


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


def positive(subject: str, value: float, unit: str = "") -> None:
    """Raise ParameterError unless a value is a finite number above zero."""
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not (number and np.isfinite(value) and value > 0):
        raise ParameterError(subject, repr(value), f"a number > 0 {unit}".rstrip())


def counting(subject: str, value: int) -> None:
    """Raise ParameterError unless a value is an integer >= 1."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < 1:
        raise ParameterError(subject, repr(value), "an integer >= 1")


def vector(subject: str, values: npt.ArrayLike, n: int) -> Array:
    """A finite float vector of length n; a scalar is repeated.

    Raises:
        ShapeError: If ``values`` is not numeric, not finite, or of another shape.
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ShapeError(subject, repr(values), f"a number or {n} numbers") from error
    if array.shape not in ((), (n,)):
        raise ShapeError(subject, f"shape {array.shape}", f"a number or shape ({n},)")
    if not np.all(np.isfinite(array)):
        raise ShapeError(subject, repr(values), "finite numbers")
    return np.broadcast_to(array, (n,)).copy()
