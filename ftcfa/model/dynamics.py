"""The protocol of a robot in a loop: `Arm` follows it, and so can a closed form of the user."""

from abc import ABC, abstractmethod
from typing import Protocol

from ftcfa.arrays import Array, Traceable, solve_spd


class Dynamics(Protocol):
    """M(q) q'' + C(q, v) v + h(q) + D(v) v = tau, for n single-axis joints on a fixed base.

    Shapes and units are those of `ftcfa.model.arm.Arm`, the implementation for any URDF. A robot
    that also takes symbols runs compiled; one that takes numbers only runs interpreted.
    """

    @property
    def n(self) -> int:
        """Number of coordinates."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the coordinates."""

    @property
    def joint_types(self) -> tuple[str, ...]:
        """revolute, continuous or prismatic, for each coordinate."""

    @property
    def effort_limit(self) -> Traceable:
        """The saturation u*, shape (n,) [N m or N]."""

    @property
    def home(self) -> Array:
        """A posture to start from, shape (n,) [rad or m]."""

    def mass_matrix(self, q: Traceable) -> Traceable:
        """M(q), shape (n, n)."""

    def potential_force(self, q: Traceable) -> Traceable:
        """h(q), shape (n,)."""

    def damping_matrix(self, v: Traceable) -> Traceable:
        """D(v), shape (n, n)."""

    def bias_force(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) v + h(q) + D(v) v, shape (n,)."""

    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q), shape (n, 6)."""


class LinearTime(ABC):
    """A robot that computes forces and velocities without M, in time in proportion to n."""

    @abstractmethod
    def inertial_force(self, q: Traceable, a: Traceable) -> Traceable:
        """M(q) a, shape (n,)."""

    @abstractmethod
    def impulse_response(
        self, q: Traceable, v: Traceable, impulse: Traceable, step: float
    ) -> Traceable:
        """(M(q) + s D(v))^-1 p, shape (n,)."""


def inertial_force(arm: Dynamics, q: Traceable, a: Traceable) -> Traceable:
    """M(q) a: force that accelerates a robot at rest, free of gravity, shape (n,) [N m or N]."""
    if isinstance(arm, LinearTime):
        return arm.inertial_force(q, a)
    return arm.mass_matrix(q) @ a


def impulse_response(
    arm: Dynamics, q: Traceable, v: Traceable, impulse: Traceable, step: float
) -> Traceable:
    """(M(q) + s D(v))^-1 p: change of velocity by an impulse p, shape (n,) [rad/s or m/s].

    Friction acts over the step s [s] with the new velocity; s = 0 leaves it out.
    """
    if isinstance(arm, LinearTime):
        return arm.impulse_response(q, v, impulse, step)
    M = arm.mass_matrix(q)
    return solve_spd(M + step * arm.damping_matrix(v) if step else M, impulse)
