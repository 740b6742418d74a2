"""What an Arm needs beside Pinocchio's functions: constants of models, forces."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ftcfa.arrays import Array
from ftcfa.model.inertia import steiner, symmetric


class BodyFrame(NamedTuple):
    """A frame fixed to a body of a tree of joints."""

    joint: int  # index of the joint that carries the frame, -1 for the base
    rotation: Array  # from the frame to the joint frame, shape (3, 3)
    translation: Array  # origin of the frame in the joint frame, shape (3,) [m]


@dataclass(frozen=True, eq=False)
class KinematicTree:
    """Tree of N single-axis joints, parents before children."""

    parents: tuple[int, ...]  # index of each joint's parent, -1 for the base
    rotations: Array  # from the joint frame at zero to the parent frame, shape (N, 3, 3)
    translations: Array  # origin of the joint frame in the parent frame, shape (N, 3) [m]
    axes: Array  # unit axis in the joint frame, shape (N, 3)
    prismatic: tuple[bool, ...]  # whether each joint slides along its axis instead of turning
    gravity: Array  # shape (3,) [m/s^2]
    frames: Mapping[str, BodyFrame]  # links and joints of the URDF, by name

    def joints_above(self, frame: BodyFrame) -> list[int]:
        """Joints between a frame and the base, those nearest to the frame first."""
        joints, joint = [], frame.joint
        while joint >= 0:
            joints.append(joint)
            joint = self.parents[joint]
        return joints


def body_inertias(model: pin.Model) -> Array:
    """Inertial parameters of a model's bodies, shape (N, 10), as `Arm.inertias` has them.

    This and its inverse do what Pinocchio's functions do, with the same bits on every machine.
    """
    rows = []
    for body in list(model.inertias)[1:]:
        I = body.inertia + steiner(body.mass, body.lever)  # noqa: E741
        upper = (I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2])
        rows.append([body.mass, *(body.mass * body.lever), *upper])
    return np.array(rows)


def with_body_inertias(model: pin.Model, inertias: Array) -> pin.Model:
    """Copy of a model with other inertial parameters, shape (N, 10)."""
    model = model.copy()
    for i, row in enumerate(np.asarray(inertias, dtype=float), 1):
        m, (xx, xy, yy, xz, yz, zz) = float(row[0]), row[4:]
        centre = row[1:4] / m if m != 0.0 else np.zeros(3)
        about_origin = symmetric(xx, yy, zz, xy, xz, yz)
        model.inertias[i] = body_of(m, centre, about_origin - steiner(m, centre))
    return model


def body_of(mass: float, centre: Array, inertia: Array) -> pin.Inertia:
    """Pinocchio's inertia of mass, centre of mass and inertia about it, whatever they are.

    Its constructor refuses the moments of a thin rod, of which rounding has made -1e-18.
    """
    body = pin.Inertia.Zero()
    body.mass, body.lever, body.inertia = mass, centre, inertia
    return body


def frames_by_name(model: pin.Model) -> dict[str, pin.Frame]:
    """Links and joints of the URDF; a link comes before a joint of the same name."""
    frames = list(model.frames)[1:]
    links = [frame for frame in frames if frame.type == pin.FrameType.BODY]
    return {frame.name: frame for frame in (*frames, *links)}


def kinematic_tree(model: pin.Model) -> KinematicTree:
    """Constants of a model as plain arrays."""
    data, placements = model.createData(), list(model.jointPlacements)[1:]
    axes = np.array([data.joints[i].S.ravel() for i in range(1, model.njoints)])  # (N, 6)
    prismatic = np.linalg.norm(axes[:, :3], axis=1) > 0
    return KinematicTree(
        parents=tuple(parent - 1 for parent in list(model.parents)[1:]),
        rotations=np.array([placement.rotation for placement in placements]),
        translations=np.array([placement.translation for placement in placements]),
        axes=np.where(prismatic[:, None], axes[:, :3], axes[:, 3:]),
        prismatic=tuple(bool(p) for p in prismatic),
        gravity=np.array(model.gravity.linear),
        frames={
            name: BodyFrame(f.parentJoint - 1, f.placement.rotation, f.placement.translation)
            for name, f in frames_by_name(model).items()
        },
    )


class TurningBase:
    """The joints and bodies of a model on a base that is free to move, without gravity."""

    def __init__(self, model: pin.Model) -> None:
        free = pin.Model()
        free.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
        for i in range(1, model.njoints):
            parent = model.parents[i] + 1
            free.addJoint(parent, model.joints[i], model.jointPlacements[i], model.names[i])
            free.appendBodyToJoint(i + 1, model.inertias[i], pin.SE3.Identity())
        free.gravity.linear = np.zeros(3)
        self._model, self._data = free, free.createData()

    def force(self, q: Array, v: Array, omega: Array) -> Array:
        """Difference that omega makes to C v, shape (N,); see `Arm.base_rotation_force`."""
        at = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], q])
        turning, still = np.concatenate([np.zeros(3), omega, v]), np.concatenate([np.zeros(6), v])
        force = pin.nonLinearEffects(self._model, self._data, at, turning)[6:].copy()
        return force - pin.nonLinearEffects(self._model, self._data, at, still)[6:]
