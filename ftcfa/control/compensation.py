"""Known forces of the nominal arm that a law adds to its torque."""

from typing import Literal

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.model.dynamics import Dynamics

Compensation = Literal["none", "gravity", "bias"]


def compensation_force(
    nominal: Dynamics, choice: Compensation, q: Traceable, v: Traceable, v_r: Traceable
) -> Traceable:
    """Nominal force that a law adds to its torque, shape (n,) [N m or N].

    Friction is taken at the velocity v_r. Taken at the measured velocity, the friction of a light
    joint would change its sign or its size within a period, and the loop would creep or diverge.

    Args:
        nominal: The arm as the controller knows it.
        choice: ``"none"``, ``"gravity"`` h(q), or ``"bias"`` C v + h + f.
        q: Measured position, shape (n,) [rad or m].
        v: Measured velocity, shape (n,) [rad/s or m/s].
        v_r: Velocity to which the law drives v, shape (n,) [rad/s or m/s].
    """
    match choice:
        case "gravity":
            return nominal.potential_force(q)
        case "bias":
            friction = nominal.damping_matrix(v_r) @ v_r - nominal.damping_matrix(v) @ v
            return nominal.bias_force(q, v) + friction
        case _:
            return np.zeros_like(q)
