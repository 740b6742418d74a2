"""Which joints of a URDF are an arm's coordinates: mimic joints and locks as one linear map.

Every moving joint j of the file follows q_j = a_j q_i + b_j for one coordinate i of the arm, or
stands still at b_j (a locked joint, or one that mimics a locked or fixed joint).
"""

from collections.abc import Mapping
from dataclasses import dataclass

from ftcfa.errors import UrdfError
from ftcfa.model.urdf.description import RobotDescription


@dataclass(frozen=True)
class JointRule:
    """How one joint of the file follows the arm's coordinates.

    Attributes:
        leader: Name of the joint whose coordinate it follows (itself if it is one), or None if
            it stands still.
        multiplier: a_j.
        offset: b_j [rad or m].
    """

    leader: str | None
    multiplier: float
    offset: float


def joint_rules(description: RobotDescription, locks: Mapping[str, float]) -> dict[str, JointRule]:
    """The rule of every moving joint of the file.

    Args:
        description: The URDF.
        locks: Joint names and the values at which they are held [rad or m].

    Raises:
        UnknownNameError: If a locked joint does not exist.
        UrdfError: If a mimic tag names no joint or leads to itself, or a mimic joint is locked.
    """
    joints = description.moving_joints
    fixed = {joint.name for joint in description.robot.joints} - joints.keys()
    for name in locks:
        mimic = description.moving_joint(name).mimic
        if mimic is not None:
            raise UrdfError(
                f"{description.file}: joint '{name}'",
                "a mimic joint cannot be locked",
                "a joint with a coordinate of its own",
                f"lock '{mimic.joint}', which it mimics",
            )

    def rule(name: str) -> JointRule:
        multiplier, offset = 1.0, 0.0
        chain: list[str] = []
        while name in joints and name not in locks:
            mimic = joints[name].mimic
            if mimic is None:
                return JointRule(name, multiplier, offset)
            if name in chain:
                others = "".join(f", through '{other}'" for other in chain[chain.index(name) + 1 :])
                raise UrdfError(
                    f"{description.file}: joint '{name}'",
                    f"mimics itself{others}",
                    "a joint that leads and does not mimic",
                    "correct its <mimic>",
                )
            chain.append(name)
            multiplier, offset = multiplier * mimic.multiplier, offset + multiplier * mimic.offset
            name = mimic.joint
        if name not in joints and name not in fixed:
            raise UrdfError(
                f"{description.file}: joint '{chain[-1]}'",
                f"mimics '{name}', which does not exist",
                f"a joint of this file ({', '.join(joints)})",
                "correct its <mimic>",
            )
        return JointRule(None, 0.0, offset + multiplier * locks.get(name, 0.0))

    return {name: rule(name) for name in joints}
