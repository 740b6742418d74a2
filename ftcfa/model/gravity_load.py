"""What gravity asks of an arm's motors."""

from typing import NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import random_postures

SAMPLES = 256
"""Number of random postures beside home."""
ROUNDING = 1e-12
"""Forces below this share of the largest one are rounding errors."""


class GravityLoad(NamedTuple):
    """Largest |h(q)| of each joint, shape (n,) [N m or N]."""

    home: Array
    worst: Array


def gravity_load(arm: Arm) -> GravityLoad:
    """Gravity's force on each joint at home, and at worst over random postures of the range."""
    postures = (arm.home, *random_postures(arm, SAMPLES))
    loads = np.abs([arm.potential_force(q) for q in postures])
    loads = np.where(loads > ROUNDING * loads.max(), loads, 0.0)
    return GravityLoad(loads[0], loads.max(axis=0))
