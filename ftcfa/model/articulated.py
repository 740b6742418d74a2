"""Articulated bodies on symbols: what a body and all that hangs on it oppose to a motion.

Featherstone, Rigid Body Dynamics Algorithms (2008), section 7.3. Bodies may be regrouped: D below
are the pivots of M, whatever parameters give M.
"""

from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca

from ftcfa.model.rigid_body import Body, JointFrame, congruence, symmetric, turned_about_z

Wrench: TypeAlias = tuple[ca.SX, ca.SX]
"""Force and moment at the origin of a frame, (3,) each."""
Twist: TypeAlias = tuple[ca.SX, ca.SX]
"""Linear acceleration of the origin and angular acceleration, (3,) each."""


@dataclass(frozen=True, eq=False)
class ArticulatedBody:
    """Inertia of a body whose further joints move freely, at the origin of a frame.

    A twist (a, w) takes the force M a + H^T w and the moment H a + I w; all are (3, 3), and M and
    I are symmetric.
    """

    M: ca.SX
    H: ca.SX
    I: ca.SX  # noqa: E741 (the field's letter)

    @classmethod
    def of(cls, body: Body) -> "ArticulatedBody":
        """A rigid body."""
        return cls(body.m * ca.SX.eye(3), ca.skew(body.h), body.I)

    def __add__(self, other: "ArticulatedBody") -> "ArticulatedBody":
        return ArticulatedBody(self.M + other.M, self.H + other.H, self.I + other.I)

    def along(self, prismatic: bool) -> Wrench:
        """Wrench U of a unit twist along or about z."""
        return (self.M[:, 2], self.H[:, 2]) if prismatic else (self.H[2, :].T, self.I[:, 2])

    def freed(self, U: Wrench, D: ca.SX) -> "ArticulatedBody":
        """The body on a joint that moves freely: less U U^T / D, where D = U_z."""
        force, moment = U
        F, N = force / D, moment / D
        return ArticulatedBody(
            symmetric(lambda i, j: self.M[i, j] - F[i] * force[j]),
            self.H - N @ force.T,
            symmetric(lambda i, j: self.I[i, j] - N[i] * moment[j]),
        )

    def in_parent(self, frame: JointFrame) -> "ArticulatedBody":
        """The same body at the origin and in the axes of its joint's parent."""
        M = congruence(frame.R, turned_about_z(self.M, frame.c, frame.s))
        I = congruence(frame.R, turned_about_z(self.I, frame.c, frame.s))  # noqa: E741
        half = frame.columns_to_parent(self.H.T).T
        H, R = frame.columns_to_parent(half), ca.skew(frame.r)
        new, outer = H + R @ M, R @ H.T  # H' = H + R M,  I' = I + R H^T - H' R
        inner = new @ R
        return ArticulatedBody(M, new, symmetric(lambda i, j: I[i, j] + outer[i, j] - inner[i, j]))
