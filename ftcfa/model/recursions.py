"""Rigid-body recursions on symbols: Newton-Euler and composite bodies over a tree of joints.

Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 and 6.
"""

import casadi as ca
import numpy as np

from ftcfa.model.arm import Arm
from ftcfa.model.articulated import ArticulatedBody, Twist, Wrench
from ftcfa.model.rigid_body import Body, JointFrame
from ftcfa.model.turned_tree import Placement, TurnedTree

ZERO = ca.SX(3, 1)
"""No gravity, or a base that does not turn."""


class Chain:
    """Recursions over the moving joints, each frame turned so that its joint's axis is z.

    A joint that does not move (its row of G is zero) is welded: its body becomes part of the
    nearest moving body above it, and its children are placed relative to that body.
    """

    def __init__(self, arm: Arm) -> None:
        tree = arm.tree()
        self.moving = np.flatnonzero(arm.G.any(axis=1)).tolist()
        self.turned = TurnedTree(tree, self.moving, arm.g0)
        index = {-1: -1} | {joint: i for i, joint in enumerate(self.moving)}
        self.G, self.g0 = ca.DM(arm.G[self.moving]), ca.DM(arm.g0[self.moving])
        self.gravity = ca.SX(ca.DM(tree.gravity))
        self.prismatic = [tree.prismatic[i] for i in self.moving]
        self.parents = [index[self.turned.placements[i][0]] for i in self.moving]
        self.frames: dict[str, Placement] = {}  # in the frames of the moving joints, by name
        for name, frame in tree.frames.items():
            carrier, R, r = self.turned.placed(frame)
            self.frames[name] = (index[carrier], R, r)
        self.regrouping = self.turned.regrouping()

    def joint_frames(self, q: ca.SX) -> list[JointFrame]:
        """Frames of the moving joints at the arm's coordinates q."""
        at = self.G @ q + self.g0
        return [self.turned.joint_frame(joint, at[i]) for i, joint in enumerate(self.moving)]

    def inverse_dynamics(
        self,
        q: ca.SX,
        v: ca.SX,
        bodies: list[Body],
        gravity: ca.SX = ZERO,
        omega: ca.SX = ZERO,
        acceleration: ca.SX | None = None,
    ) -> ca.SX:
        """Torque of the moving joints, M a + C v + h for a base that does not turn: Newton, Euler.

        ``q``, ``v`` and ``acceleration`` (None: zero) are the arm's coordinates, ``bodies`` the
        regrouped ones, ``omega`` the angular velocity of the base [rad/s].
        """
        frames, rates, z = self.joint_frames(q), self.G @ v, ca.DM([0, 0, 1])
        growth = self.G @ (ca.SX(v.shape[0], 1) if acceleration is None else acceleration)
        base = (omega, ca.SX(3, 1), -gravity)
        motion: list[tuple[ca.SX, ca.SX, ca.SX]] = []  # w, w', acceleration of each origin
        wrenches = []
        for i, (frame, p, body) in enumerate(zip(frames, self.parents, bodies, strict=True)):
            w, dw, a = motion[p] if p >= 0 else base
            carried = a + ca.cross(dw, frame.r) + ca.cross(w, ca.cross(w, frame.r))
            w, dw, a = map(frame.vector_to_child, (w, dw, carried))
            rate = z * rates[i]
            if self.prismatic[i]:
                a = a + 2 * ca.cross(w, rate) + z * growth[i]
            else:
                dw, w = dw + ca.cross(w, rate) + z * growth[i], w + rate
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
        frames = self.joint_frames(q)
        N, composites = len(frames), self._composites(frames, bodies)
        M, coupling = ca.SX(N, N), ca.SX(N, 6)
        for i in reversed(range(N)):
            force, moment = _unit_acceleration(composites[i], self.prismatic[i])
            j = i
            while j >= 0:
                M[i, j] = M[j, i] = force[2] if self.prismatic[j] else moment[2]
                force, moment = frames[j].wrench_to_parent(force, moment)
                j = self.parents[j]
            coupling[i, :] = ca.vertcat(force, moment).T
        return M, coupling

    def _composites(self, frames: list[JointFrame], bodies: list[Body]) -> list[Body]:
        """Each joint's body with all bodies that it carries, in the joint's frame."""
        composites = list(bodies)
        for i in reversed(range(len(frames))):
            if self.parents[i] >= 0:
                composites[self.parents[i]] += frames[i].body_to_parent(composites[i])
        return composites

    def forward_dynamics(self, q: ca.SX, tau: ca.SX, bodies: list[Body], damping: ca.SX) -> ca.SX:
        """(M + diag(damping))^-1 tau of the moving joints at rest, by articulated bodies.

        All in the moving joints' own order, (moving,).
        """
        frames = self.joint_frames(q)
        articulated = [ArticulatedBody.of(body) for body in bodies]
        pushes: list[Wrench] = [(ca.SX(3, 1), ca.SX(3, 1)) for _ in frames]  # of the joints above
        pivots: list[tuple[Wrench, ca.SX, ca.SX]] = []
        for i in reversed(range(len(frames))):
            slides, body, (force, moment) = self.prismatic[i], articulated[i], pushes[i]
            U = body.along(slides)
            D = (U[0] if slides else U[1])[2] + damping[i]
            a = (tau[i] - (force if slides else moment)[2]) / D
            pivots.append((U, D, a))
            p = self.parents[i]
            if p >= 0:
                articulated[p] += body.freed(U, D).in_parent(frames[i])
                force, moment = frames[i].wrench_to_parent(force + U[0] * a, moment + U[1] * a)
                pushes[p] = (pushes[p][0] + force, pushes[p][1] + moment)
        motion: list[Twist] = []
        accelerations = []
        for i, (frame, (U, D, a)) in enumerate(zip(frames, reversed(pivots), strict=True)):
            p = self.parents[i]
            linear, angular = motion[p] if p >= 0 else (ca.SX(3, 1), ca.SX(3, 1))
            linear = frame.vector_to_child(linear + ca.cross(angular, frame.r))
            angular = frame.vector_to_child(angular)
            a = a - (ca.dot(U[0], linear) + ca.dot(U[1], angular)) / D
            accelerations.append(a)
            along = ca.vertcat(0, 0, a)
            motion.append(
                (linear + along, angular) if self.prismatic[i] else (linear, angular + along)
            )
        return ca.vertcat(*accelerations)

    def base_coupling(self, q: ca.SX, bodies: list[Body]) -> ca.SX:
        """M_qb of the moving joints, by composite rigid bodies, in the axes of the base."""
        frames = self.joint_frames(q)
        coupling, composites = ca.SX(len(frames), 6), self._composites(frames, bodies)
        places: list[tuple[ca.SX, ca.SX]] = []  # R and r in the base
        for i, (frame, p) in enumerate(zip(frames, self.parents, strict=True)):
            R, r = places[p] if p >= 0 else (ca.SX.eye(3), ca.SX(3, 1))
            r = r + R @ frame.r
            R = frame.rotated(R)
            places.append((R, r))
            force, moment = _unit_acceleration(composites[i], self.prismatic[i])
            force = R @ force
            coupling[i, :] = ca.vertcat(force, R @ moment + ca.cross(r, force)).T
        return coupling

    def pose(self, q: ca.SX, frame: str) -> tuple[ca.SX, ca.SX]:
        """Rotation (3, 3) and origin (3,) of a frame in the axes of the base."""
        frames = self.joint_frames(q)
        i, *place = self.frames[frame]
        R, r = (ca.SX(ca.DM(part)) for part in place)
        while i >= 0:
            R, r = frames[i].columns_to_parent(R), frames[i].r + frames[i].vector_to_parent(r)
            i = self.parents[i]
        return R, r

    def jacobian(self, q: ca.SX, frame: str) -> ca.SX:
        """Jacobian (6, n) of a frame's origin and rotation, in the axes of the base."""
        frames, z = self.joint_frames(q), ca.SX(ca.DM([0, 0, 1]))
        i, _, point = self.frames[frame]
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


def _unit_acceleration(body: Body, prismatic: bool) -> tuple[ca.SX, ca.SX]:
    """Force and moment at the origin that accelerate a body by one along or about z."""
    h, I = body.h, body.I  # noqa: E741
    if prismatic:
        return ca.vertcat(0, 0, body.m), ca.vertcat(h[1], -h[0], 0)
    return ca.vertcat(-h[1], h[0], 0), I[:, 2]
