"""The signed fractional power of finite-time control."""

import numpy as np

from ftcfa.arrays import Traceable


def sig(x: Traceable, a: float) -> Traceable:
    """Raise each component to a power a > 0 and keep its sign: sign(x) |x|^a.

    Every fractional power of a vector in the paper means this.
    """
    return np.copysign(np.abs(x) ** a, x)
