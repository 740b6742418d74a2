"""What a loop needs of a robot: `Arm` has it, so has any closed form that a user writes."""

from typing import Protocol

from ftcfa.arrays import Array


class Dynamics(Protocol):
    """M(q) q'' + C(q, v) v + h(q) + D(v) v = tau, for n single-axis joints on a fixed base.

    Shapes and units as in `ftcfa.model.arm.Arm`, the implementation for any URDF.
    """

    @property
    def n(self) -> int:
        """Number of coordinates."""
        ...

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        ...

    @property
    def joint_types(self) -> tuple[str, ...]:
        """revolute, continuous or prismatic, for each coordinate."""
        ...

    @property
    def effort_limit(self) -> Array:
        """The saturation u*, shape (n,) [N m or N]."""
        ...

    @property
    def home(self) -> Array:
        """A posture to start from, shape (n,) [rad or m]."""
        ...

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n, n)."""
        ...

    def potential_force(self, q: Array) -> Array:
        """h(q), shape (n,)."""
        ...

    def damping_matrix(self, v: Array) -> Array:
        """D(v), shape (n, n)."""
        ...

    def bias_force(self, q: Array, v: Array) -> Array:
        """C(q, v) v + h(q) + D(v) v, shape (n,)."""
        ...

    def base_coupling(self, q: Array) -> Array:
        """M_qb(q), shape (n, 6)."""
        ...
