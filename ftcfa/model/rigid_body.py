"""Rigid bodies and joint frames on symbols.

Every joint frame is turned so that its axis is z: the joint's rotation then costs four products.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from ftcfa.arrays import Array

ENTRIES = 10
"""Inertial parameters of a body: m, m c (3), Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin."""


@dataclass(frozen=True, eq=False)
class Body:
    """Inertia of a body in a frame: mass, first moment (3) and inertia about the origin (3, 3)."""

    m: ca.SX
    h: ca.SX
    I: ca.SX  # noqa: E741 (the field's letter)

    def __add__(self, other: "Body") -> "Body":
        return Body(self.m + other.m, self.h + other.h, self.I + other.I)

    @classmethod
    def of(cls, parameters: ca.SX) -> "Body":
        """The body of ENTRIES inertial parameters."""
        m, hx, hy, hz, xx, xy, yy, xz, yz, zz = (parameters[k] for k in range(ENTRIES))
        upper = {(0, 0): xx, (0, 1): xy, (0, 2): xz, (1, 1): yy, (1, 2): yz, (2, 2): zz}
        return cls(m, ca.vertcat(hx, hy, hz), symmetric(lambda i, j: upper[i, j]))

    def parameters(self) -> ca.SX:
        """The ENTRIES inertial parameters of the body."""
        I = self.I  # noqa: E741
        upper = (I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2])
        return ca.vertcat(self.m, self.h, *upper)

    def turned(self, A: Array) -> "Body":
        """The same body in axes turned by A: x = A x_new."""
        R = ca.DM(A.T)
        return Body(self.m, R @ self.h, congruence(R, self.I))

    def split(self, prismatic: bool) -> "tuple[Body, Body]":
        """The part that the joint along z feels, and the part that acts like the parent's own."""
        if prismatic:
            return Body(self.m, self.h, ca.SX(3, 3)), Body(ca.SX(0), ca.SX(3, 1), self.I)
        yy = self.I[1, 1]
        rod = Body(self.m, ca.vertcat(0, 0, self.h[2]), ca.diag(ca.vertcat(yy, yy, 0)))
        I = self.I - rod.I  # noqa: E741
        return Body(ca.SX(0), ca.vertcat(self.h[0], self.h[1], 0), I), rod


def bodies_of(parameters: ca.SX) -> list[Body]:
    """The bodies of inertial parameters, ENTRIES each, one body after the other."""
    columns = ca.reshape(parameters, ENTRIES, -1)
    return [Body.of(columns[:, i]) for i in range(columns.shape[1])]


class JointFrame:
    """Frame of a joint in its parent's: rotation R Rz(g + q) from child to parent, and origin r.

    ``zero`` holds the cosine and the sine of g. A welded joint has no coordinate q.
    """

    def __init__(
        self,
        R: Array,
        r: Array,
        q: ca.SX | None = None,
        prismatic: bool = False,
        zero: tuple[float, float] = (1.0, 0.0),
    ) -> None:
        self.R, self.r = ca.DM(R), ca.SX(ca.DM(r))
        self.c, self.s = ca.SX(1), ca.SX(0)
        if q is not None and prismatic:
            self.r = self.r + self.R[:, 2] * q
        elif q is not None:
            (c, s), (c0, s0) = (ca.cos(q), ca.sin(q)), zero
            self.c, self.s = c * c0 - s * s0, s * c0 + c * s0

    def vector_to_parent(self, x: ca.SX) -> ca.SX:
        """A vector in the axes of the parent, from those of the child."""
        c, s = self.c, self.s
        return self.R @ ca.vertcat(c * x[0] - s * x[1], s * x[0] + c * x[1], x[2])

    def columns_to_parent(self, A: ca.SX) -> ca.SX:
        """A matrix (3, k) of vectors in the axes of the parent, from those of the child."""
        return ca.horzcat(*map(self.vector_to_parent, ca.horzsplit(A)))

    def vector_to_child(self, x: ca.SX) -> ca.SX:
        """A vector in the axes of the child, from those of the parent."""
        y = self.R.T @ x
        return ca.vertcat(self.c * y[0] + self.s * y[1], self.c * y[1] - self.s * y[0], y[2])

    def rotated(self, A: ca.SX) -> ca.SX:
        """A R Rz(q), from the axes of the child to those of A, which maps from the parent."""
        B = A @ self.R
        return ca.horzcat(
            B[:, 0] * self.c + B[:, 1] * self.s, B[:, 1] * self.c - B[:, 0] * self.s, B[:, 2]
        )

    def wrench_to_parent(self, force: ca.SX, moment: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Force and moment in the parent's frame, from those in the child's."""
        force = self.vector_to_parent(force)
        return force, self.vector_to_parent(moment) + ca.cross(self.r, force)

    def body_to_parent(self, body: Body) -> Body:
        """A body's inertia in the parent's frame, from that in the child's."""
        g, r = self.vector_to_parent(body.h), self.r
        rg = ca.dot(r, g)
        shift = (body.m * ca.dot(r, r) + 2 * rg) * ca.DM.eye(3)
        I = congruence(self.R, turned_about_z(body.I, self.c, self.s))  # noqa: E741
        outer = symmetric(lambda i, j: body.m * r[i] * r[j] + r[i] * g[j] + g[i] * r[j])
        return Body(body.m, g + body.m * r, I + shift - outer)


def symmetric(entry: Callable[[int, int], ca.SX]) -> ca.SX:
    """Symmetric (3, 3) matrix, each entry computed once."""
    A = ca.SX(3, 3)
    for i in range(3):
        for j in range(i, 3):
            A[i, j] = A[j, i] = entry(i, j)
    return A


def turned_about_z(I: ca.SX, c: ca.SX, s: ca.SX) -> ca.SX:  # noqa: E741
    """Rz I Rz^T of a symmetric I, where Rz has the cosine c and the sine s."""
    cc, ss, cs = c * c, s * s, c * s
    xx = cc * I[0, 0] - 2 * cs * I[0, 1] + ss * I[1, 1]
    turned = {
        (0, 0): xx,
        (0, 1): cs * (I[0, 0] - I[1, 1]) + (cc - ss) * I[0, 1],
        (0, 2): c * I[0, 2] - s * I[1, 2],
        (1, 1): I[0, 0] + I[1, 1] - xx,
        (1, 2): s * I[0, 2] + c * I[1, 2],
        (2, 2): I[2, 2],
    }
    return symmetric(lambda i, j: turned[i, j])


def congruence(R: ca.DM, I: ca.SX) -> ca.SX:  # noqa: E741
    """R I R^T of a symmetric I."""
    T = R @ I
    return symmetric(lambda i, j: ca.dot(T[i, :], R[j, :]))
