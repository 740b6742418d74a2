"""The signed fractional power of finite-time control."""

import numpy as np

from ftcfa.arrays import Traceable

SMALLEST = 1e-300
"""Least |x| in the logarithm of `sig`; the logarithm of 0 is no number."""


def sig(x: Traceable, a: float) -> Traceable:
    """Raise each component to a power a > 0 and keep its sign: sign(x) |x|^a.

    Every fractional power of a vector in the paper means this. The base is positive, so the power
    is computed as exp(a log |x|): for vectors less than half the cost of a general power, with a
    relative error of some 1e-14, and exactly zero at zero.
    """
    return np.sign(x) * np.exp(a * np.log(np.maximum(np.abs(x), SMALLEST)))
