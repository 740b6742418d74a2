"""Friction of the joints, for numbers and for symbols."""

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError

FRICTION_VELOCITY = 1e-3
"""Velocity below which Coulomb friction turns linear [rad/s or m/s]."""


def damping_matrix(G: Array, damping: Array, friction: Array, v: Array) -> Array:
    """D(v) with f(v) = D(v) v, symmetric positive semidefinite, shape (n, n).

        D = G^T diag(damping + friction / sqrt(v_j^2 + e^2)) G,   v_j = G v,   e = FRICTION_VELOCITY

    Coulomb friction is smoothed: a joint that should stick creeps at less than e.

    Args:
        G: Linear map from the arm's velocities to those of the joints, shape (N, n).
        damping: Viscous friction of the joints, shape (N,) [N m s/rad or N s/m].
        friction: Coulomb friction of the joints, shape (N,) [N m or N].
        v: Velocity, shape (n,) [rad/s or m/s].
    """
    v_joint = G @ v
    coefficient = damping + friction / np.sqrt(v_joint**2 + FRICTION_VELOCITY**2)
    return (G.T * coefficient) @ G


def check_joint_friction(subject: str, coefficients: Array, joints: int) -> None:
    """Raise unless there is one coefficient >= 0 a joint.

    Raises:
        ShapeError: If their shape is not (joints,).
        ParameterError: If one is negative or not finite.
    """
    if np.shape(coefficients) != (joints,):
        raise ShapeError(subject, f"shape {np.shape(coefficients)}", f"({joints},)")
    if not np.all(np.isfinite(coefficients) & (coefficients >= 0)):
        raise ParameterError(subject, f"{coefficients.tolist()}", "numbers >= 0")
