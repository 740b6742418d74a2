"""What gravity asks of an arm's motors."""

from typing import NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import joint_box

SAMPLES = 256
"""Number of random postures beside home."""


class GravityLoad(NamedTuple):
    """Largest |h(q)| of each joint, shape (n,) [N m or N]."""

    home: Array
    worst: Array


def gravity_load(arm: Arm) -> GravityLoad:
    """Gravity's force on each joint at home, and at worst over random postures of the range."""
    box = np.random.default_rng(0).uniform(*joint_box(arm), (SAMPLES, arm.n))
    home = np.abs(arm.potential_force(arm.home))
    return GravityLoad(home, np.max([home, *(np.abs(arm.potential_force(q)) for q in box)], axis=0))
