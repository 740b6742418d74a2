"""The signed fractional power that finite-time control is built from."""

import numpy as np

from ftcfa.arrays import Array


def sig(x: Array, a: float) -> Array:
    """Raise each component to a power, keeping its sign: sign(x) |x|^a.

    Every fractional power of a vector in the paper means this.
    """
    return np.sign(x) * np.abs(x) ** a
