"""A tree of joints whose frames are turned so that a joint's axis is z: the constants of a Chain.

Inertial parameters are regrouped (Khalil and Kleinfinger 1987). The part of a body that its joint
cannot feel is counted with the parent body instead: for a revolute joint a mass on its axis, a
first moment along it and the inertia of a rod on it; for a prismatic joint the rotational inertia.
Most of the remaining parameters are zero, which saves arithmetic.
"""

import casadi as ca
import numpy as np

from ftcfa.arrays import Array
from ftcfa.model.pinocchio_model import BodyFrame, KinematicTree
from ftcfa.model.rigid_body import ENTRIES, JointFrame, bodies_of
from ftcfa.portable import product, sin_cos

CHEAP = 5
"""Entries of a rotation about a coordinate axis that are not zero."""
ROUNDING = 1e-15
"""Entries of a constant rotation this close to -1, 0 or 1 are set to that number."""

Placement = tuple[int, Array, Array]
"""Moving joint that carries a frame (-1: the base), and the frame's rotation and origin there."""


class TurnedTree:
    """Placement of every joint in the nearest moving joint above it, each frame turned to z.

    A joint's frame is also turned about its axis, so that the rotation to its first child is one
    about x and one about z, as in Denavit and Hartenberg's frames, if it would be dearer otherwise.

    Args:
        tree: The joints.
        moving: Joints that move, in the tree's order.
        g0: Value of each joint that does not move, shape (N,).
    """

    def __init__(self, tree: KinematicTree, moving: list[int], g0: Array) -> None:
        self.tree, self.moving = tree, moving
        self._turns = [_turn_to_z(axis) for axis in tree.axes]
        self.placements: list[Placement] = []
        self._place(g0)
        self._turn_to_children()
        self._place(g0)

    def _place(self, g0: Array) -> None:
        """Find the placement of every joint's turned frame."""
        tree = self.tree
        self.placements.clear()
        for i, p in enumerate(tree.parents):
            R = product(tree.rotations[i], self._turns[i])
            p, R, r = self.placed(BodyFrame(p, R, tree.translations[i]))
            if i not in self.moving and tree.prismatic[i]:
                r = r + R[:, 2] * g0[i]
            elif i not in self.moving:
                s, c = map(float, sin_cos(np.asarray(g0[i])))
                R = product(R, _about_z(c, s))
            self.placements.append((p, _clean(R), r))

    def placed(self, frame: BodyFrame) -> Placement:
        """Placement of a frame that the tree places in any joint's frame or in the base."""
        p, R, r = frame
        if p < 0:
            return p, R, r
        R, r = product(self._turns[p].T, R), _turned(self._turns[p].T, r)
        if p in self.moving:
            return p, R, r
        carrier, R0, r0 = self.placements[p]
        return carrier, product(R0, R), r0 + _turned(R0, r)

    def _turn_to_children(self) -> None:
        """Turn each frame about its z so that its first child's z lies in the y-z plane."""
        seen = {-1}
        for i in self.moving:
            p, R, _ = self.placements[i]
            x, y, _ = R[:, 2]
            if p not in seen and x != 0.0 and np.count_nonzero(R) > CHEAP:
                norm = np.sqrt(x * x + y * y)
                self._turns[p] = product(self._turns[p], _about_z(y / norm, -x / norm))
            seen.add(p)

    def joint_frame(self, i: int, q: ca.SX) -> JointFrame:
        """Frame of a moving joint at its coordinate q, in that of the moving joint above it."""
        _, R, r = self.placements[i]
        normal = np.flatnonzero(R[:, 2] == 0.0)
        if self.tree.prismatic[i] or len(normal) == 0 or np.count_nonzero(R) <= CHEAP:
            return JointFrame(R, r, q, self.tree.prismatic[i])
        c, s = R[normal[0], 0], -R[normal[0], 1]  # R = R0 Rz(g), where R0 is cheap
        return JointFrame(_clean(product(R, _about_z(c, -s))), r, q, zero=(c, s))

    def regrouping(self) -> Array:
        """Linear map from the parameters of the arm's N bodies to those of the regrouped ones.

        Its shape is (moving ENTRIES, N ENTRIES). It is a Jacobian; leaves are regrouped first.
        """
        N = len(self.placements)
        parameters = ca.SX.sym("parameters", ENTRIES * N)
        pairs = zip(bodies_of(parameters), self._turns, strict=True)
        bodies = [body.turned(A) for body, A in pairs]
        for i in reversed(range(N)):
            p, R, r = self.placements[i]
            passed_on = bodies[i]
            if i in self.moving:
                bodies[i], passed_on = bodies[i].split(self.tree.prismatic[i])
            if p >= 0:
                bodies[p] += JointFrame(R, r).body_to_parent(passed_on)
        regrouped = ca.vertcat(*(bodies[i].parameters() for i in self.moving))
        jacobian = ca.Function("regrouping", [parameters], [ca.jacobian(regrouped, parameters)])
        return np.asarray(ca.DM(jacobian(0)))


def _turned(R: Array, r: Array) -> Array:
    """A vector in other axes."""
    return product(R, r[:, None])[:, 0]


def _turn_to_z(axis: Array) -> Array:
    """Rotation A with A z = axis; a permutation of the axes where one suffices."""
    farthest = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(farthest, axis)
    x /= np.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    return _clean(np.column_stack([x, np.cross(axis, x), axis]))


def _about_z(c: float, s: float) -> Array:
    """Rz of the angle with the cosine c and the sine s, shape (3, 3)."""
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _clean(R: Array) -> Array:
    """Rotation with its exact zeros and ones restored, so that they need no arithmetic."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) < ROUNDING, nearest, R)
