"""What a law takes from the nominal arm beside its inertia."""

from typing import Any, Literal

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics

Compensation = Literal["none", "gravity", "bias"]


def check_nominal(subject: str, nominal: Any) -> None:
    """Raise ParameterError unless a law's nominal arm is an arm."""
    if not hasattr(nominal, "mass_matrix"):
        got = f"a {type(nominal).__name__}"
        raise ParameterError(subject, got, "an Arm, such as load_arm gives")


def compensation_force(
    nominal: Dynamics, choice: Compensation, q: Array, v: Array, wanted: Array
) -> Array:
    """Nominal force that a law adds to its torque, shape (n,) [N m or N].

    Args:
        nominal: The arm as the controller believes it to be.
        choice: ``"none"``, ``"gravity"`` h(q), or ``"bias"`` C v + h + f.
        q: Measured position, shape (n,) [rad or m].
        v: Measured velocity, shape (n,) [rad/s or m/s].
        wanted: Velocity that the law steers to, at which friction is taken, shape (n,): fed back
            at the measured one, that of a light joint changes sign or fades faster than the
            controller samples, and the loop creeps or diverges.
    """
    match choice:
        case "gravity":
            return nominal.potential_force(q)
        case "bias":
            friction = nominal.damping_matrix(wanted) @ wanted - nominal.damping_matrix(v) @ v
            return nominal.bias_force(q, v) + friction
        case _:
            return np.zeros_like(q)
