"""The stochastic plant (4) over one integration step, torque held.

    dq = v dt,   dv = M^-1 [tau - C v - h - f(v)] dt + M^-1 Lambda Sigma dW

Friction is taken implicitly: with f(v) = D(v) v and D at the start of the step,

    (M + h D)(v+ - v) = h (tau - C v - h_g - D v) + Lambda Sigma dW,

which keeps light joints with hard friction stable at any step and is Euler-Maruyama where D = 0.
The noise enters only v and Lambda depends only on q, so Ito and Stratonovich agree and the
strong order is 1.
"""

from collections.abc import Callable, Mapping
from typing import TypeAlias

from ftcfa.arrays import Array, solve_spd
from ftcfa.model.dynamics import Dynamics

Integrator: TypeAlias = Callable[[Dynamics, Array, Array, Array, Array, float], tuple[Array, Array]]


def velocity_change(
    arm: Dynamics, q: Array, v: Array, tau: Array, impulse: Array, step: float
) -> Array:
    """v+ - v over one step, shape (n,) [rad/s or m/s].

    Args:
        arm: The true robot.
        q: Position at the start of the step, shape (n,) [rad or m].
        v: Velocity at the start of the step, shape (n,) [rad/s or m/s].
        tau: Applied torque, held over the step, shape (n,) [N m or N].
        impulse: Impulse of the noise over the step, shape (n,) [N m s or N s].
        step: Its length [s].
    """
    A = arm.mass_matrix(q) + step * arm.damping_matrix(v)
    return solve_spd(A, step * (tau - arm.bias_force(q, v)) + impulse)


def euler_maruyama(
    arm: Dynamics, q: Array, v: Array, tau: Array, impulse: Array, step: float
) -> tuple[Array, Array]:
    """q+ = q + h v: the position moves with the old velocity."""
    return q + step * v, v + velocity_change(arm, q, v, tau, impulse, step)


def semi_implicit_euler(
    arm: Dynamics, q: Array, v: Array, tau: Array, impulse: Array, step: float
) -> tuple[Array, Array]:
    """q+ = q + h v+: the position moves with the new velocity (symplectic Euler)."""
    new = v + velocity_change(arm, q, v, tau, impulse, step)
    return q + step * new, new


INTEGRATORS: Mapping[str, Integrator] = {
    "euler-maruyama": euler_maruyama,
    "semi-implicit": semi_implicit_euler,
}
"""Integrators by name."""
