"""Friction of the joints, for numbers and for symbols."""

import numpy as np

from ftcfa.arrays import Array, Traceable

FRICTION_VELOCITY = 1e-3
"""Velocity below which Coulomb friction turns linear [rad/s or m/s]."""


def damping_matrix(G: Array, damping: Traceable, friction: Traceable, v: Traceable) -> Traceable:
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
