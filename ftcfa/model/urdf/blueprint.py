"""An arm about to be made of a description: what moves, and how."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from yourdfpy.urdf import Link

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm
from ftcfa.model.urdf.catalogue import CatalogueEntry
from ftcfa.model.urdf.description import RobotDescription, carried_by
from ftcfa.model.urdf.joints import (
    JointRule,
    JointValues,
    coordinate_map,
    effort_limits,
    home_position,
    joint_armature,
    joint_friction,
    joint_limits,
)
from ftcfa.model.urdf.model import model_of_urdf


@dataclass(frozen=True)
class Blueprint:
    """All that an Arm is made of; nothing in it is checked yet.

    Attributes:
        description: The URDF.
        entry: Entry of the catalogue, None for a file of the user.
        source: The arguments that find the URDF again.
        locks: Values of the joints that are held [rad or m].
        rules: How each moving joint of the file follows the arm's coordinates.
        gravity: The gravity field, shape (3,) [m/s^2].
        mounting: Orientation of the base in the world, shape (3, 3).
        effort_limit: Torque limits that override those of the URDF.
        armature: Rotor inertias that override those of the catalogue and the URDF.
    """

    description: RobotDescription
    entry: CatalogueEntry | None
    source: Mapping[str, Any]
    locks: Mapping[str, float]
    rules: Mapping[str, JointRule]
    gravity: Array
    mounting: Array
    effort_limit: JointValues | None
    armature: JointValues | None

    def moved(self) -> list[Link]:
        """The links that some coordinate moves."""
        robot = self.description.robot
        moving = {name for name, rule in self.rules.items() if rule.leader is not None}
        carried = carried_by(robot, (j.child for j in robot.joints if j.name in moving))
        return [link for link in robot.links if link.name in carried]

    def arm(self) -> Arm:
        """The arm; its effort limit is NaN where there is none."""
        description, entry = self.description, self.entry
        model = model_of_urdf(description.pinocchio_xml(), self.gravity, self.mounting)
        joints = list(model.names[1:])
        names = tuple(name for name in joints if self.rules[name].leader == name)
        G, g0 = coordinate_map(joints, names, self.rules)
        lower, upper, velocity = joint_limits(description, names)
        effort = effort_limits(description, names, self.effort_limit)
        armature = joint_armature(description, entry, joints, names, self.armature)
        rotors: dict[str, Any] = {}
        if self.armature is not None or armature.any():
            rotors["armature"] = dict(zip(joints, armature.tolist(), strict=True))
        return Arm(
            name=description.robot.name if entry is None else self.source["robot"],
            model=model,
            G=G,
            g0=g0,
            joint_names=names,
            joint_types=tuple(description.moving_joints[name].type for name in names),
            lower=lower,
            upper=upper,
            velocity_limit=velocity,
            effort_limit=effort,
            damping=joint_friction(description, joints, "damping"),
            friction=joint_friction(description, joints, "friction"),
            armature=armature,
            home=np.array([home_position(description, entry, name) for name in names]),
            tool="",
            source={
                **self.source,
                "lock": dict(self.locks),
                "gravity": self.gravity.tolist(),
                "effort_limit": effort.tolist(),
                "mounting": self.mounting.tolist(),
                **rotors,
            },
        )
