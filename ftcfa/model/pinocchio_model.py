"""Pinocchio's models: built from a URDF, given other inertias, read as plain arrays."""

import numpy as np
import pinocchio as pin

from ftcfa.arrays import Array
from ftcfa.model.tree import BodyFrame, KinematicTree


def model_of_urdf(xml: str, gravity: Array, mounting: Array) -> pin.Model:
    """Pinocchio's model of a URDF text.

    Args:
        xml: Text of the URDF.
        gravity: Gravity field in world axes, shape (3,) [m/s^2].
        mounting: Orientation of the base in the world, shape (3, 3). The model's own base frame
            has the axes of the world, so every quantity of the base is in world axes.
    """
    model = pin.buildModelFromXML(xml)
    model.gravity.linear = gravity
    turn = pin.SE3(mounting, np.zeros(3))
    for i in range(1, model.njoints):
        if model.parents[i] == 0:
            model.jointPlacements[i] = turn * model.jointPlacements[i]
    for frame in model.frames[1:]:  # the first is the world's
        if frame.parentJoint == 0:
            frame.placement = turn * frame.placement
    return model


def body_inertias(model: pin.Model) -> Array:
    """Inertial parameters of the bodies in their joint frames, shape (N, 10)."""
    return np.array([body.toDynamicParameters() for body in model.inertias[1:]])


def mass_beyond(model: pin.Model, joints: list[int]) -> float:
    """Mass of all bodies that at least one of the joints, numbers from 0 to N - 1, moves [kg]."""
    numbers = {joint + 1 for joint in joints}  # Pinocchio's joint 0 is the fixed base
    bodies = zip(model.inertias[1:], model.supports[1:], strict=True)
    return float(sum(body.mass for body, above in bodies if numbers.intersection(above)))


def with_body_inertias(model: pin.Model, inertias: Array) -> pin.Model:
    """Copy of a model with other inertial parameters, shape (N, 10)."""
    model = model.copy()
    for i, row in enumerate(inertias):
        model.inertias[i + 1] = _body(row)
    return model


def _body(row: Array) -> pin.Inertia:
    """Body of ten inertial parameters; Pinocchio's own function divides by the mass."""
    if row[0] != 0:
        return pin.Inertia.FromDynamicParameters(row)
    xx, xy, yy, xz, yz, zz = row[4:]
    return pin.Inertia(0.0, np.zeros(3), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def frames_by_name(model: pin.Model) -> dict[str, pin.Frame]:
    """Links and joints of the URDF; a link comes before a joint of the same name."""
    frames = list(model.frames)[1:]
    links = [frame for frame in frames if frame.type == pin.FrameType.BODY]
    return {frame.name: frame for frame in (*frames, *links)}


def kinematic_tree(model: pin.Model) -> KinematicTree:
    """Constants of a model as plain arrays."""
    joints, data = model.joints[1:], model.createData()
    axes = np.array([data.joints[joint.id].S.ravel() for joint in joints])  # (N, 6)
    placements = [model.jointPlacements[joint.id] for joint in joints]
    prismatic = np.linalg.norm(axes[:, :3], axis=1) > 0
    return KinematicTree(
        parents=tuple(model.parents[joint.id] - 1 for joint in joints),
        rotations=np.array([placement.rotation for placement in placements]),
        translations=np.array([placement.translation for placement in placements]),
        axes=np.where(prismatic[:, None], axes[:, :3], axes[:, 3:]),
        prismatic=tuple(bool(p) for p in prismatic),
        gravity=np.array(model.gravity.linear),
        frames={
            name: BodyFrame(
                frame.parentJoint - 1, frame.placement.rotation, frame.placement.translation
            )
            for name, frame in frames_by_name(model).items()
        },
    )
