"""The stochastic plant (4) over one integration step, torque held.

    M(q) q'' + C(q, v) v + h(q) + f(v) = sat(u) + Lambda(q) xi                         (3)
    dq = v dt,   dv = M^-1 [sat(u) - C v - h - f] dt + M^-1 Lambda Sigma dW            (4)

(4) is the Ito form of (3) for white noise, xi dt = Sigma dW with Sigma Sigma^T = varpi; f is the
friction of the joints, which the paper leaves out, and sat clips u at the limits +-u*. The noise
enters v alone and Lambda depends on q alone, so that Ito's and Stratonovich's forms agree and
Euler's scheme has strong order 1.

Friction f(v) = D(v) v is implicit: over a step s from (q, v), with tau = sat(u) and all matrices
taken at (q, v),

    (M + s D) (v+ - v) = s (tau - C v - h - D v) + Lambda Y,   Y: integral of xi over the step

This is stable at any step, also for light joints with hard friction, and Euler-Maruyama if D = 0.
"""

from collections.abc import Callable, Mapping
from typing import TypeAlias

from ftcfa.arrays import Traceable
from ftcfa.model.dynamics import Dynamics, impulse_response

Integrator: TypeAlias = Callable[
    [Dynamics, Traceable, Traceable, Traceable, Traceable, float], tuple[Traceable, Traceable]
]
"""Function from arm, q, v, tau, impulse and step to q and v at the end of the step."""


def velocity_change(
    arm: Dynamics, q: Traceable, v: Traceable, tau: Traceable, impulse: Traceable, step: float
) -> Traceable:
    """v+ - v over one step, shape (n,) [rad/s or m/s].

    Args:
        arm: The true robot.
        q: Position at the start of the step, shape (n,) [rad or m].
        v: Velocity at the start of the step, shape (n,) [rad/s or m/s].
        tau: Applied torque, held over the step, shape (n,) [N m or N].
        impulse: Impulse of the noise over the step, shape (n,) [N m s or N s].
        step: Length of the step [s].
    """
    total = step * (tau - arm.bias_force(q, v)) + impulse
    return impulse_response(arm, q, v, total, step)


def euler_maruyama(
    arm: Dynamics, q: Traceable, v: Traceable, tau: Traceable, impulse: Traceable, step: float
) -> tuple[Traceable, Traceable]:
    """q+ = q + s v: the position moves with the old velocity."""
    return q + step * v, v + velocity_change(arm, q, v, tau, impulse, step)


def semi_implicit_euler(
    arm: Dynamics, q: Traceable, v: Traceable, tau: Traceable, impulse: Traceable, step: float
) -> tuple[Traceable, Traceable]:
    """q+ = q + s v+: the position moves with the new velocity (symplectic Euler)."""
    new = v + velocity_change(arm, q, v, tau, impulse, step)
    return q + step * new, new


INTEGRATORS: Mapping[str, Integrator] = {
    "euler-maruyama": euler_maruyama,
    "semi-implicit": semi_implicit_euler,
}
"""Integrators by name."""
