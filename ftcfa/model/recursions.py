"""Rigid-body recursions on symbols: Newton-Euler and composite bodies over a tree of joints.

Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 and 6.

Inertial parameters are regrouped (Khalil and Kleinfinger 1987). The part of a body that its joint
cannot feel is counted with the parent body instead: for a revolute joint a mass on its axis, a
first moment along it and the inertia of a rod on it; for a prismatic joint the rotational inertia.
Most of the remaining parameters are zero, which saves arithmetic.
"""

import casadi as ca
import numpy as np

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm
from ftcfa.model.pinocchio_model import KinematicTree
from ftcfa.model.rigid_body import ENTRIES, Body, JointFrame, bodies_of
from ftcfa.portable import product, sin_cos

ZERO = ca.SX(3, 1)
"""No gravity, or a base that does not turn."""
ROUNDING = 1e-15
"""Entries of a constant rotation this close to -1, 0 or 1 are set to that number."""


class Chain:
    """Recursions over the moving joints, each frame turned so that its joint's axis is z.

    A joint that does not move (its row of G is zero) is welded: its body becomes part of the
    nearest moving body above it, and its children are placed relative to that body.
    """

    def __init__(self, arm: Arm) -> None:
        tree = arm.tree()
        moving = np.flatnonzero(arm.G.any(axis=1)).tolist()
        turns = [_turn_to_z(axis) for axis in tree.axes]
        placements = _placements(tree, moving, turns, arm.g0)
        index = {-1: -1} | {joint: i for i, joint in enumerate(moving)}
        self.G, self.g0 = ca.DM(arm.G[moving]), ca.DM(arm.g0[moving])  # (moving, n), (moving,)
        self.gravity = ca.SX(ca.DM(tree.gravity))
        self.prismatic = [tree.prismatic[i] for i in moving]
        self.parents = [index[placements[i][0]] for i in moving]
        self.placements = [placements[i][1:] for i in moving]  # R and r in the parent's frame
        self.frames: dict[str, tuple[int, Array]] = {}  # moving joint and origin there, by name
        for name, (j, R, r) in tree.frames.items():
            if j >= 0:
                j, R, r = _carried((j, R, r), moving, turns, placements)
            self.frames[name] = (index[j], r)
        self.regrouping = _regrouping(tree, moving, turns, placements)

    def joint_frames(self, q: ca.SX) -> list[JointFrame]:
        """Frames of the moving joints at the arm's coordinates q."""
        places = zip(self.placements, self.prismatic, strict=True)
        at = self.G @ q + self.g0
        return [JointFrame(*place, at[i], slides) for i, (place, slides) in enumerate(places)]

    def inverse_dynamics(
        self, q: ca.SX, v: ca.SX, bodies: list[Body], gravity: ca.SX = ZERO, omega: ca.SX = ZERO
    ) -> ca.SX:
        """Torque of the moving joints without joint acceleration, by Newton and Euler.

        It is C v + h for a base that does not turn. ``q`` and ``v`` are the arm's coordinates,
        ``bodies`` the regrouped ones, ``omega`` the angular velocity of the base [rad/s].
        """
        frames, rates, z = self.joint_frames(q), self.G @ v, ca.DM([0, 0, 1])
        base = (omega, ca.SX(3, 1), -gravity)
        motion: list[tuple[ca.SX, ca.SX, ca.SX]] = []  # w, w', acceleration of each origin
        wrenches = []
        for i, (frame, p, body) in enumerate(zip(frames, self.parents, bodies, strict=True)):
            w, dw, a = motion[p] if p >= 0 else base
            carried = a + ca.cross(dw, frame.r) + ca.cross(w, ca.cross(w, frame.r))
            w, dw, a = map(frame.vector_to_child, (w, dw, carried))
            rate = z * rates[i]
            if self.prismatic[i]:
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
                force, moment = frames[i].wrench_to_parent(force, moment)
                wrenches[p] = (wrenches[p][0] + force, wrenches[p][1] + moment)
        return ca.vertcat(*tau)

    def composite_inertia(self, q: ca.SX, bodies: list[Body]) -> tuple[ca.SX, ca.SX]:
        """M and M_qb of the moving joints, by composite rigid bodies."""
        frames, composite = self.joint_frames(q), list(bodies)
        N = len(frames)
        M, coupling = ca.SX(N, N), ca.SX(N, 6)
        for i in reversed(range(N)):
            body = composite[i]
            if self.parents[i] >= 0:
                composite[self.parents[i]] += frames[i].body_to_parent(body)
            force, moment = _unit_acceleration(body, self.prismatic[i])
            j = i
            while j >= 0:
                M[i, j] = M[j, i] = force[2] if self.prismatic[j] else moment[2]
                force, moment = frames[j].wrench_to_parent(force, moment)
                j = self.parents[j]
            coupling[i, :] = ca.vertcat(force, moment).T
        return M, coupling

    def jacobian(self, q: ca.SX, frame: str) -> ca.SX:
        """Jacobian (6, n) of a frame's origin and rotation, in the axes of the base."""
        frames, z = self.joint_frames(q), ca.SX(ca.DM([0, 0, 1]))
        i, point = self.frames[frame]
        x = ca.SX(ca.DM(point))
        columns: dict[int, tuple[ca.SX, ca.SX]] = {}  # in the axes of joint i
        while i >= 0:
            columns[i] = (z, ca.SX(3, 1)) if self.prismatic[i] else (ca.cross(z, x), z)
            up = frames[i].vector_to_parent
            columns = {j: (up(linear), up(angular)) for j, (linear, angular) in columns.items()}
            x = frames[i].r + up(x)
            i = self.parents[i]
        J = ca.SX(6, len(frames))
        for j, (linear, angular) in columns.items():
            J[:, j] = ca.vertcat(linear, angular)
        return J @ self.G


Placement = tuple[int, Array, Array]
"""Moving joint that carries a frame (-1: the base), and the frame's rotation and origin there."""


def _placements(
    tree: KinematicTree, moving: list[int], turns: list[Array], g0: Array
) -> list[Placement]:
    """Placement of every joint's turned frame; a joint that does not move has the value g0."""
    placements: list[Placement] = []
    for i, p in enumerate(tree.parents):
        R, r = product(tree.rotations[i], turns[i]), tree.translations[i]
        if p >= 0:
            p, R, r = _carried((p, R, r), moving, turns, placements)
        if i not in moving and tree.prismatic[i]:
            r = r + R[:, 2] * g0[i]
        elif i not in moving:
            R = product(R, _about_z(g0[i]))
        placements.append((p, _clean(R), r))
    return placements


def _turned(R: Array, r: Array) -> Array:
    """A vector in other axes."""
    return product(R, r[:, None])[:, 0]


def _carried(
    frame: Placement, moving: list[int], turns: list[Array], placements: list[Placement]
) -> Placement:
    """Placement of a frame that the tree places in any joint's frame, which is not yet turned."""
    p, R, r = frame
    R, r = product(turns[p].T, R), _turned(turns[p].T, r)
    if p in moving:
        return p, R, r
    carrier, R0, r0 = placements[p]
    return carrier, product(R0, R), r0 + _turned(R0, r)


def _regrouping(
    tree: KinematicTree, moving: list[int], turns: list[Array], placements: list[Placement]
) -> Array:
    """Linear map from the parameters of the arm's N bodies to those of the regrouped ones.

    Its shape is (moving ENTRIES, N ENTRIES). It is a Jacobian; leaves are regrouped before roots.
    """
    N = len(tree.parents)
    parameters = ca.SX.sym("parameters", ENTRIES * N)
    bodies = [body.turned(A) for body, A in zip(bodies_of(parameters), turns, strict=True)]
    for i in reversed(range(N)):
        p, R, r = placements[i]
        passed_on = bodies[i]
        if i in moving:
            bodies[i], passed_on = bodies[i].split(tree.prismatic[i])
        if p >= 0:
            bodies[p] += JointFrame(R, r).body_to_parent(passed_on)
    regrouped = ca.vertcat(*(bodies[i].parameters() for i in moving))
    jacobian = ca.Function("regrouping", [parameters], [ca.jacobian(regrouped, parameters)])
    return np.asarray(ca.DM(jacobian(0)))


def _unit_acceleration(body: Body, prismatic: bool) -> tuple[ca.SX, ca.SX]:
    """Force and moment at the origin that accelerate a body by one along or about z."""
    h, I = body.h, body.I  # noqa: E741
    if prismatic:
        return ca.vertcat(0, 0, body.m), ca.vertcat(h[1], -h[0], 0)
    return ca.vertcat(-h[1], h[0], 0), I[:, 2]


def _turn_to_z(axis: Array) -> Array:
    """Rotation A with A z = axis; a permutation of the axes where one suffices."""
    farthest = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(farthest, axis)
    x /= np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    return _clean(np.column_stack([x, np.cross(axis, x), axis]))


def _about_z(angle: float) -> Array:
    """Rz(angle), shape (3, 3)."""
    s, c = sin_cos(np.asarray(angle))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _clean(R: Array) -> Array:
    """Rotation with its exact zeros and ones restored, so that they need no arithmetic."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) < ROUNDING, nearest, R)
