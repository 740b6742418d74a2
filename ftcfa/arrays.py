"""The array type of the package and the one linear solve that it needs."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ftcfa.errors import ShapeError

Array: TypeAlias = npt.NDArray[np.floating[Any]]
"""Numbers; while a loop is traced, CasADi symbols that behave like them."""


def solve_spd(A: Array, b: Array) -> Array:
    """Solve A x = b.

    Args:
        A: Symmetric positive definite matrix, shape (n, n).
        b: Right-hand side, shape (n,).

    Returns:
        x, shape (n,).
    """
    return np.linalg.solve(A, b)


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
