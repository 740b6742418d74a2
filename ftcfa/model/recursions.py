"""Rigid-body recursions on symbols: Newton-Euler and composite bodies over a tree of joints.

Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 and 6. Every joint frame is first
turned so that its axis is z, so that a joint's rotation costs four products.

Inertial parameters are regrouped (Khalil and Kleinfinger 1987): what of a body cannot be felt at
its joint belongs as well to the body before it. A mass on a revolute joint's axis, a first moment
along it and a rod's inertia about it move on; so do the rotational inertias of a prismatic
joint's body. What is left has few entries, and the arithmetic shrinks with them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm

ROUNDING = 1e-15
"""Entries of a constant rotation this close to -1, 0 or 1 are meant to be just that."""
ENTRIES = 10
"""Inertial parameters of a body: m, m c (3), Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin."""


@dataclass(frozen=True, eq=False)
class Body:
    """A body's inertia in a frame: mass, first moment (3) and inertia about the origin (3, 3)."""

    m: ca.SX
    h: ca.SX
    I: ca.SX  # noqa: E741 (the field's letter)

    def __add__(self, other: "Body") -> "Body":
        return Body(self.m + other.m, self.h + other.h, self.I + other.I)

    @classmethod
    def of(cls, row: ca.SX) -> "Body":
        """The body of ENTRIES inertial parameters."""
        m, hx, hy, hz, xx, xy, yy, xz, yz, zz = (row[k] for k in range(ENTRIES))
        upper = {(0, 0): xx, (0, 1): xy, (0, 2): xz, (1, 1): yy, (1, 2): yz, (2, 2): zz}
        return cls(m, ca.vertcat(hx, hy, hz), _symmetric(lambda i, j: upper[i, j]))

    def row(self) -> ca.SX:
        """Its ENTRIES inertial parameters."""
        I = self.I  # noqa: E741
        upper = (I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2])
        return ca.vertcat(self.m, self.h, *upper)

    def turned(self, A: Array) -> "Body":
        """The same body in axes turned by A: x = A x_new."""
        R = ca.DM(A.T)
        return Body(self.m, R @ self.h, _congruence(R, self.I))

    def split(self, prismatic: bool) -> "tuple[Body, Body]":
        """What the joint along z feels, and what belongs to the parent as well."""
        if prismatic:
            return Body(self.m, self.h, ca.SX(3, 3)), Body(ca.SX(0), ca.SX(3, 1), self.I)
        yy = self.I[1, 1]
        rod = Body(self.m, ca.vertcat(0, 0, self.h[2]), ca.diag(ca.vertcat(yy, yy, 0)))
        I = self.I - rod.I  # noqa: E741
        return Body(ca.SX(0), ca.vertcat(self.h[0], self.h[1], 0), I), rod


class Chain:
    """Recursions over the moving joints, each frame turned so that its joint's axis is z.

    A joint that stands still (its row of G is zero) is welded: its body joins the nearest moving
    body above it, and its children hang there.


    Attributes:
        parents: Index of each moving joint's parent, -1 for the base.
        frames: Index of the moving joint that carries each frame of the arm, and the frame's origin
            there, by name.
        regrouping: Linear map from the parameters of the arm's N bodies to those of the moving
            joints' regrouped bodies, shape (moving ENTRIES, N ENTRIES).
    """

    def __init__(self, arm: Arm) -> None:
        tree, N = arm.tree(), len(arm.g0)
        moving = [i for i in range(N) if arm.G[i].any()]
        self.gravity, self.prismatic = (
            ca.SX(ca.DM(tree.gravity)),
            [tree.prismatic[i] for i in moving],
        )
        self.G, self.g0 = ca.DM(arm.G[moving]), ca.DM(arm.g0[moving])
        turns = [_turn_to_z(axis) for axis in tree.axes]
        placements: list[tuple[int, Array, Array]] = []  # moving ancestor, rotation, translation
        for i, p in enumerate(tree.parents):
            R, r = tree.rotations[i] @ turns[i], tree.translations[i]
            if p >= 0:
                R, r = turns[p].T @ R, turns[p].T @ r
                if p not in moving:
                    p, R0, r0 = placements[p]
                    R, r = R0 @ R, r0 + R0 @ r
            if i not in moving and tree.prismatic[i]:
                r = r + R[:, 2] * arm.g0[i]
            elif i not in moving:
                R = R @ _about_z(arm.g0[i])
            placements.append((p, _clean(R), r))
        ancestors = [placements[i][0] for i in moving]
        self.parents = [moving.index(p) if p >= 0 else -1 for p in ancestors]
        self.placements = [placements[i][1:] for i in moving]
        self.frames: dict[str, tuple[int, Array]] = {}
        for name, frame in tree.frames.items():
            j, r = frame.joint, frame.translation
            if j >= 0:
                r = turns[j].T @ r
                if j not in moving:
                    j, R0, r0 = placements[j]
                    r = r0 + R0 @ r
            self.frames[name] = (moving.index(j) if j >= 0 else -1, r)

        parameters = ca.SX.sym("parameters", ENTRIES, N)
        bodies = [Body.of(parameters[:, i]).turned(turns[i]) for i in range(N)]
        for i in reversed(range(N)):
            p, R, r = placements[i]
            passed_on = bodies[i]
            if i in moving:
                bodies[i], passed_on = bodies[i].split(tree.prismatic[i])
            if p >= 0:
                bodies[p] += Frame(i, R, r).lift(passed_on)
        regrouped = ca.vertcat(*(bodies[i].row() for i in moving))
        jacobian = ca.Function("regrouping", [parameters], [ca.jacobian(regrouped, parameters)])
        self.regrouping = np.asarray(ca.DM(jacobian(0)))

    def joint_frames(self, q: ca.SX) -> "list[Frame]":
        """The joint frames at coordinates q of the moving joints."""
        return [Frame(i, R, r, q[i], self.prismatic[i]) for i, (R, r) in enumerate(self.placements)]

    def inverse_dynamics(
        self, q: ca.SX, v: ca.SX, bodies: list[Body], gravity: ca.SX, omega: ca.SX
    ) -> ca.SX:
        """Torque of zero joint acceleration, by Newton and Euler; C v + h where omega is zero.

        Args:
            q: Coordinates of the moving joints.
            v: Their velocities.
            bodies: Their regrouped bodies.
            gravity: Gravity field, shape (3,) [m/s^2].
            omega: Angular velocity of the base, shape (3,) [rad/s].
        """
        z = ca.DM([0, 0, 1])
        frames = self.joint_frames(q)
        base = (omega, ca.SX(3, 1), -gravity)
        motion: list[tuple[ca.SX, ca.SX, ca.SX]] = []
        wrenches = []
        for frame, p, body in zip(frames, self.parents, bodies, strict=True):
            w, dw, a = motion[p] if p >= 0 else base
            carried = a + ca.cross(dw, frame.r) + ca.cross(w, ca.cross(w, frame.r))
            w, dw, a = frame.down(w), frame.down(dw), frame.down(carried)
            rate = z * v[frame.i]
            if self.prismatic[frame.i]:
                a = a + 2 * ca.cross(w, rate)
            else:
                dw, w = dw + ca.cross(w, rate), w + rate
            motion.append((w, dw, a))
            force = body.m * a + ca.cross(dw, body.h) + ca.cross(w, ca.cross(w, body.h))
            moment = body.I @ dw + ca.cross(w, body.I @ w) + ca.cross(body.h, a)
            wrenches.append((force, moment))
        tau = [ca.SX(0)] * len(frames)
        for i in reversed(range(len(frames))):
            force, moment = wrenches[i]
            tau[i] = force[2] if self.prismatic[i] else moment[2]
            p = self.parents[i]
            if p >= 0:
                up_force, up_moment = frames[i].up(force, moment)
                wrenches[p] = (wrenches[p][0] + up_force, wrenches[p][1] + up_moment)
        return ca.vertcat(*tau)

    def composite_inertia(self, q: ca.SX, bodies: list[Body]) -> tuple[ca.SX, ca.SX]:
        """M and M_qb of the moving joints, by composite rigid bodies."""
        frames = self.joint_frames(q)
        composite = list(bodies)
        N = len(frames)
        M, coupling = ca.SX(N, N), ca.SX(N, 6)
        for i in reversed(range(len(frames))):
            body = composite[i]
            if self.parents[i] >= 0:
                composite[self.parents[i]] += frames[i].lift(body)
            force, moment = _unit_acceleration(body, self.prismatic[i])
            j = i
            while j >= 0:
                M[i, j] = M[j, i] = force[2] if self.prismatic[j] else moment[2]
                force, moment = frames[j].up(force, moment)
                j = self.parents[j]
            coupling[i, :] = ca.vertcat(force, moment).T
        return M, coupling

    def jacobian(self, q: ca.SX, frame: str) -> ca.SX:
        """Jacobian (6, N) of a frame's origin and turning, in the axes of the base."""
        frames, z = self.joint_frames(q), ca.SX(ca.DM([0, 0, 1]))
        i, point = self.frames[frame]
        x = ca.SX(ca.DM(point))
        columns: dict[int, tuple[ca.SX, ca.SX]] = {}  # in the axes of joint i
        while i >= 0:
            columns[i] = (z, ca.SX(3, 1)) if self.prismatic[i] else (ca.cross(z, x), z)
            up = frames[i].rotate
            columns = {j: (up(linear), up(angular)) for j, (linear, angular) in columns.items()}
            x = frames[i].r + up(x)
            i = self.parents[i]
        J = ca.SX(6, len(frames))
        for j, (linear, angular) in columns.items():
            J[:, j] = ca.vertcat(linear, angular)
        return J


class Frame:
    """Joint i at coordinate q (None: welded): child-to-parent rotation R Rz(q) and origin r."""

    def __init__(
        self, i: int, R: Array, r: Array, q: ca.SX | None = None, prismatic: bool = False
    ) -> None:
        self.i = i
        self.R, self.r = ca.DM(R), ca.SX(ca.DM(r))
        self.c, self.s = ca.SX(1), ca.SX(0)
        if q is not None and prismatic:
            self.r = self.r + self.R[:, 2] * q
        elif q is not None:
            self.c, self.s = ca.cos(q), ca.sin(q)

    def rotate(self, x: ca.SX) -> ca.SX:
        """A vector from child to parent axes."""
        return self.R @ ca.vertcat(
            self.c * x[0] - self.s * x[1], self.s * x[0] + self.c * x[1], x[2]
        )

    def down(self, x: ca.SX) -> ca.SX:
        """A vector from parent to child axes."""
        y = self.R.T @ x
        return ca.vertcat(self.c * y[0] + self.s * y[1], self.c * y[1] - self.s * y[0], y[2])

    def up(self, force: ca.SX, moment: ca.SX) -> tuple[ca.SX, ca.SX]:
        """A wrench from the child to the parent frame."""
        force = self.rotate(force)
        return force, self.rotate(moment) + ca.cross(self.r, force)

    def lift(self, body: Body) -> Body:
        """A body's inertia from the child to the parent frame."""
        g, r = self.rotate(body.h), self.r
        rg = ca.dot(r, g)
        shift = (body.m * ca.dot(r, r) + 2 * rg) * ca.DM.eye(3)
        I = _congruence(self.R, _turned_about_z(body.I, self.c, self.s))  # noqa: E741
        outer = _symmetric(lambda i, j: body.m * r[i] * r[j] + r[i] * g[j] + g[i] * r[j])
        return Body(body.m, g + body.m * r, I + shift - outer)


def _unit_acceleration(body: Body, prismatic: bool) -> tuple[ca.SX, ca.SX]:
    """Force and moment at the origin that accelerate a body along or about z by one."""
    h, I = body.h, body.I  # noqa: E741
    if prismatic:
        return ca.vertcat(0, 0, body.m), ca.vertcat(h[1], -h[0], 0)
    return ca.vertcat(-h[1], h[0], 0), I[:, 2]


def _symmetric(entry: Callable[[int, int], ca.SX]) -> ca.SX:
    """A symmetric (3, 3) matrix, each entry computed once."""
    A = ca.SX(3, 3)
    for i in range(3):
        for j in range(i, 3):
            A[i, j] = A[j, i] = entry(i, j)
    return A


def _turned_about_z(I: ca.SX, c: ca.SX, s: ca.SX) -> ca.SX:  # noqa: E741
    """Rz I Rz^T for a symmetric I."""
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
    return _symmetric(lambda i, j: turned[i, j])


def _congruence(R: ca.DM, I: ca.SX) -> ca.SX:  # noqa: E741
    """R I R^T for a symmetric I."""
    T = R @ I
    return _symmetric(lambda i, j: ca.dot(T[i, :], R[j, :]))


def _turn_to_z(axis: Array) -> Array:
    """A rotation A with A z = axis, made of axis permutations where that is enough."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return _clean(np.column_stack([x, np.cross(axis, x), axis]))


def _about_z(angle: float) -> Array:
    """Rz(angle), shape (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _clean(R: Array) -> Array:
    """A rotation with its exact zeros and ones restored, so that they fold away."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) < ROUNDING, nearest, R)
