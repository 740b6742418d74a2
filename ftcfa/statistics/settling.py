"""Settling in mean square: practical finite-time stability (Definition 1) estimated from paths."""

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.errors import ParameterError, ShapeError


def practical_settling_time(
    time: npt.ArrayLike, mean_square_bound: npt.ArrayLike, epsilon: float
) -> float:
    """Earliest recorded time from which the bound stays below epsilon to the end [s].

        E|z1(t)|^2 < epsilon   for all recorded t >= T

    Only recorded times count; the result says nothing about the time after the last one. With the
    upper ends of two-sided intervals of confidence c, T has confidence (1 + c)/2 for all recorded
    times together: it is wrong only if the bound is below epsilon at the latest recorded time with
    E|z1|^2 >= epsilon, and that is one fixed time.

    Args:
        time: Rising times, shape (k,) [s].
        mean_square_bound: Upper confidence bound of E|z1|^2, shape (k,) [rad^2]; NaN where there
            is none (a path diverged), which counts as not below epsilon.
        epsilon: Bound of the mean square [rad^2].

    Returns:
        T, or NaN if the bound is not below epsilon at the end.

    Raises:
        ParameterError: If epsilon is not positive, or the times do not rise.
        ShapeError: If there are no times, or another number of bounds.
    """
    positive("epsilon", epsilon, "rad^2")
    t, bound = np.asarray(time, dtype=float), np.asarray(mean_square_bound, dtype=float)
    if t.ndim != 1 or t.size == 0:
        raise ShapeError("time", f"shape {t.shape}", "shape (k,), one or more")
    if bound.shape != t.shape:
        raise ShapeError("mean_square_bound", f"shape {bound.shape}", f"shape {t.shape}")
    if np.any(~(np.diff(t) > 0)):
        raise ParameterError("time", "times that do not rise", "rising times")
    return below_for_good(t, bound, epsilon)


def below_for_good(time: Array, values: Array, bound: float) -> float:
    """Earliest time from which values stay below a bound to the end; NaN if they do not.

    Times and values have the shape (k,); a value of NaN counts as not below.
    """
    outside = np.flatnonzero(~(values < bound))
    first = int(outside[-1]) + 1 if outside.size else 0
    return float(time[first]) if first < len(time) else float("nan")
