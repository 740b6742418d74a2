"""The one integration step of every adaptive state: the decay implicit."""

from ftcfa.arrays import Array


def leaky_step(x: Array, rate: float, drive: Array, period: float) -> Array:
    """One step of x' = -rate x + drive, the decay implicit: stable for any rate >= 0."""
    return (x + period * drive) / (1.0 + period * rate)
