"""The signed fractional power that finite-time control is built from."""

import numpy as np

from ftcfa.arrays import Array

SMALLEST = 1e-300
"""Stands for |x| below it, where the logarithm would leave the numbers."""


def sig(x: Array, a: float) -> Array:
    """Raise each component to a power a > 0, keeping its sign: sign(x) |x|^a.

    Every fractional power of a vector in the paper means this. The base is positive, so the
    power is exp(a log |x|): on vectors less than half the cost of a general power, exact to
    some 1e-14 relative, and exactly zero at zero.
    """
    return np.sign(x) * np.exp(a * np.log(np.maximum(np.abs(x), SMALLEST)))
