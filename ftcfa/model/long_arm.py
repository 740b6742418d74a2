"""The twin of an arm of many joints: no matrix is formed where a force or a velocity is asked for.

M(q) a by inverse dynamics and M(q)^-1 b by articulated bodies take arithmetic in proportion to the
number of joints; the matrix takes its square, and its factors the cube.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from ftcfa.arrays import Traceable
from ftcfa.model.dynamics import LinearTime
from ftcfa.model.symbols import array, column
from ftcfa.model.traced import TracedArm


@dataclass(frozen=True, eq=False)
class LongArm(TracedArm, LinearTime):
    """The twin of an arm each of whose coordinates moves one joint."""

    def inertial_force(self, q: Traceable, a: Traceable) -> Traceable:
        """M(q) a, shape (n,): see `ftcfa.model.dynamics.inertial_force`."""
        force = array(self._inertial_force(column(q), column(a), self._parameters), 1)
        return force + self.G.T @ (self.armature * (self.G @ a))

    @cached_property
    def _inertial_force(self) -> ca.Function:
        """Function q, a -> M a of the bodies (n,)."""
        q, a, chain = ca.SX.sym("q", self.n), ca.SX.sym("a", self.n), self.chain
        force = chain.inverse_dynamics(q, ca.SX(self.n, 1), self._bodies, acceleration=a)
        return self._function("inertial_force", [q, a], [chain.G.T @ force])

    def impulse_response(
        self, q: Traceable, v: Traceable, impulse: Traceable, step: float
    ) -> Traceable:
        """(M(q) + s D(v))^-1 p, shape (n,): see `ftcfa.model.dynamics.impulse_response`."""
        added = column(self.armature + step * self.joint_damping(v))[self.chain.moving]
        return array(self._response(column(q), column(impulse), added, self._parameters), 1)

    @cached_property
    def _response(self) -> ca.Function:
        """Function q, p, d -> (M + G^T diag(d) G)^-1 p (n,), for G^T = G^-1."""
        q, p, d = (ca.SX.sym(name, self.n) for name in "qpd")
        G = self.chain.G
        change = self.chain.forward_dynamics(q, G @ p, self._bodies, d)
        return self._function("response", [q, p, d], [G.T @ change])

    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q), shape (n, 6)."""
        return array(self._coupling(column(q), self._parameters), 2)

    @cached_property
    def _coupling(self) -> ca.Function:
        """Function q -> M_qb (n, 6)."""
        q = ca.SX.sym("q", self.n)
        coupling = self.chain.base_coupling(q, self._bodies)
        return self._function("coupling", [q], [self.chain.G.T @ coupling])
