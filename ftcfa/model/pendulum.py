"""The paper's double pendulum as a closed form: a plant that needs no URDF (Section V)."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import vector
from ftcfa.parts import Parameters, number_fields


@dataclass(frozen=True, eq=False)
class PaperPendulum:
    """Two point masses on massless rods under a ceiling; absolute angles from the vertical.

        M = [[(m1+m2) l1^2, m2 l1 l2 cos D], [m2 l1 l2 cos D, m2 l2^2]],      D = q2 - q1
        C = [[0, -m2 l1 l2 sin D v2], [m2 l1 l2 sin D v1, 0]]
        h = [(m1+m2) g l1 sin q1, m2 g l2 sin q2]

    ``as_printed`` takes C from the paper's text with its misprints: C21 has cos D instead of sin D,
    and C22 = 1, a friction of 1 N m s/rad between link 2 and the world. Its M' - 2 C is not skew.
    """

    m: tuple[float, float] = (0.6, 0.8)  # masses [kg]
    l: tuple[float, float] = (0.8, 1.2)  # lengths [m]  # noqa: E741 (the paper's letter)
    g: float = 9.8  # gravity [m/s^2]
    as_printed: bool = False  # whether C has the paper's misprints
    effort_limit: Traceable = field(default_factory=lambda: np.array([15.0, 15.0]))  # u* [N m]

    def __post_init__(self) -> None:
        limit = vector("PaperPendulum effort_limit", self.effort_limit, 2, field="effort_limit")
        object.__setattr__(self, "effort_limit", limit)

    varies: ClassVar[Parameters] = number_fields("m", "l", "g", "effort_limit")

    n = 2
    joint_names = ("shoulder", "elbow")
    joint_types = ("continuous", "continuous")

    @property
    def home(self) -> Array:
        """The posture that hangs straight down, shape (2,) [rad]."""
        return np.zeros(2)

    @property
    def _moment(self) -> Traceable:
        """Mass moments of the rods with all that they carry, shape (2,) [kg m]."""
        (m1, m2), (l1, l2) = self.m, self.l
        return np.array([(m1 + m2) * l1, m2 * l2])

    def mass_matrix(self, q: Traceable) -> Traceable:
        """M(q), shape (2, 2) [kg m^2]."""
        (m1, m2), (l1, l2) = self.m, self.l
        coupling = m2 * l1 * l2 * np.cos(q[1] - q[0])
        return np.stack([np.stack([(m1 + m2) * l1**2, coupling]), np.stack([coupling, m2 * l2**2])])

    def coriolis_matrix(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v), shape (2, 2) [N m s/rad]."""
        (_, m2), (l1, l2) = self.m, self.l
        sine, cosine = np.sin(q[1] - q[0]), np.cos(q[1] - q[0])
        c12 = -m2 * l1 * l2 * sine * v[1]
        c21 = m2 * l1 * l2 * (cosine if self.as_printed else sine) * v[0]
        c22 = 1.0 if self.as_printed else 0.0
        return np.stack([np.stack([0.0, c12]), np.stack([c21, c22])])

    def potential_force(self, q: Traceable) -> Traceable:
        """h(q), shape (2,) [N m]."""
        return self.g * self._moment * np.sin(q)

    def damping_matrix(self, v: Traceable) -> Traceable:
        """D(v) = 0: no friction, shape (2, 2)."""
        return np.zeros((2, 2))

    def bias_force(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) v + h(q), shape (2,) [N m]."""
        return self.coriolis_matrix(q, v) @ v + self.potential_force(q)

    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q) for a base that does not turn, shape (2, 6) [kg m].

        Only the columns of x and z are not zero: the printed model has no turning base.
        """
        x, z, zero = self._moment * np.cos(q), self._moment * np.sin(q), np.zeros(2)
        columns = [x, zero, z, zero, zero, zero]
        return np.stack(columns, axis=1)
