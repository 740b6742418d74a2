"""First-order low-pass of a sampled signal."""

from typing import Any

import numpy as np

from ftcfa.arrays import Traceable, is_off


def low_pass(y: Traceable, x: Traceable, bandwidth: Any, step: float) -> Traceable:
    """One step of y' = w (x - y), w = 2 pi bandwidth, exact for an x that is held.

    Args:
        y: Output at the start of the step.
        x: Input.
        bandwidth: Corner frequency, infinite for none [Hz].
        step: Length of the step [s].

    Returns:
        The output at its end.
    """
    if is_off(bandwidth, np.inf):
        return x
    kept = np.exp(-2.0 * np.pi * step * bandwidth)
    return kept * y + (1.0 - kept) * x
