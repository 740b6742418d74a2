"""What an arm as numbers and its twin as symbols have in common: joints, limits, friction."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.errors import ShapeError
from ftcfa.model.dynamics import impulse_response
from ftcfa.model.pose import Pose

FRICTION_VELOCITY = 1e-3
"""Velocity below which Coulomb friction turns linear [rad/s or m/s]."""


@dataclass(frozen=True, eq=False)
class AbstractArm(ABC):
    """The joints of an arm, for numbers and for symbols; `Arm` describes the fields."""

    name: str
    G: Array
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    lower: Array
    upper: Array
    velocity_limit: Array
    effort_limit: Traceable
    damping: Traceable
    friction: Traceable
    armature: Traceable
    home: Array
    tool: str

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.joint_names)

    @abstractmethod
    def mass_matrix(self, q: Traceable) -> Traceable:
        """M(q), symmetric positive definite, shape (n, n) [kg m^2 or kg]."""

    @abstractmethod
    def bias_force(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) v + h(q) + f(v), shape (n,) [N m or N]."""

    @abstractmethod
    def potential_force(self, q: Traceable) -> Traceable:
        """h(q), shape (n,) [N m or N]."""

    @abstractmethod
    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q), shape (n, 6): see `ftcfa.model.arm.Arm.base_coupling`."""

    @abstractmethod
    def pose(self, q: Traceable, frame: str | None = None) -> Pose:
        """Place of a frame, by default of the tool; see `Arm.pose`."""

    def damping_matrix(self, v: Traceable) -> Traceable:
        """D(v) of joint friction, symmetric positive semidefinite, shape (n, n).

        D = G^T diag(d) G,   d: `joint_damping`
        """
        return (self.G.T * self.joint_damping(v)) @ self.G

    @cached_property
    def rotor_matrix(self) -> Traceable:
        """What rotors add to M, G^T diag(armature) G, shape (n, n) [kg m^2 or kg]."""
        return (self.G.T * self.armature) @ self.G

    def joint_damping(self, v: Traceable) -> Traceable:
        """Damping d(v) of each joint of the URDF, shape (N,) [N m s/rad or N s/m].

            d = damping + friction / sqrt(v_j^2 + e^2),   v_j = G v

        Coulomb friction is smoothed with e = FRICTION_VELOCITY: a joint that should stick creeps
        at less than e.
        """
        v_joint = self._model_v(v)
        return self.damping + self.friction / np.sqrt(v_joint**2 + FRICTION_VELOCITY**2)

    def friction_force(self, v: Traceable) -> Traceable:
        """f(v) = D(v) v: viscous and Coulomb friction of the URDF, shape (n,) [N m or N]."""
        return self.damping_matrix(v) @ v

    def forward_dynamics(self, q: Traceable, v: Traceable, tau: Traceable) -> Traceable:
        """Acceleration M^-1 (tau - C v - h - f), shape (n,) [rad/s^2 or m/s^2]."""
        self._check_shape("tau", tau)
        return impulse_response(self, q, v, tau - self.bias_force(q, v), 0.0)

    def _model_v(self, v: Traceable) -> Traceable:
        self._check_shape("v", v)
        return self.G @ v

    def _check_shape(self, symbol: str, x: Traceable) -> None:
        shape = x.shape if hasattr(x, "shape") else np.shape(x)
        if shape != (self.n,):
            raise ShapeError(f"{symbol} of {self.name}", f"shape {shape}", f"shape ({self.n},)")
