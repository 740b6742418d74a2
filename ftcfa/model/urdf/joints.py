"""Locked and mimic joints of a URDF as one linear map of the arm's coordinates.

Every moving joint j of the file follows q_j = a_j q_i + b_j for one coordinate i of the arm, or
does not move and has the value b_j (a locked joint, or one that mimics a locked or fixed joint).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_number, known_name
from ftcfa.errors import ParameterError, UrdfError
from ftcfa.model.urdf.catalogue import CatalogueEntry
from ftcfa.model.urdf.coordinates import home_position
from ftcfa.model.urdf.description import RobotDescription

Locks = Mapping[str, float] | Iterable[str]


@dataclass(frozen=True)
class JointRule:
    """How one joint of the file follows the arm's coordinates.

    Attributes:
        leader: Name of the joint whose coordinate it follows (its own name if it is independent),
            or None if it does not move.
        multiplier: a_j.
        offset: b_j [rad or m].
    """

    leader: str | None
    multiplier: float
    offset: float


def locked_joints(
    description: RobotDescription, entry: CatalogueEntry | None, lock: Locks | None
) -> dict[str, float]:
    """Joints to hold and their values [rad or m]: the catalogue's, overridden by ``lock``.

    Raises:
        UnknownNameError: If a joint of ``lock`` is not a moving joint of the file.
        UrdfError: If a joint of ``lock`` is a mimic joint.
        ParameterError: If ``lock`` or one of its values is of the wrong type.
    """
    locks: dict[str, float] = {}
    if entry is not None and entry.joints:
        independent = (j.name for j in description.moving_joints.values() if j.mimic is None)
        locked = (name for name in independent if name not in entry.joints)
        locks = {name: home_position(description, entry, name) for name in locked}
    if lock is None:
        return locks
    if not isinstance(lock, Iterable):
        expected = "joint names, or names with values [rad or m]"
        raise ParameterError("lock", repr(lock), expected, field="lock")
    names = [lock] if isinstance(lock, str) else [str(name) for name in lock]
    for name in names:
        _check_lockable(description, name)
    if not isinstance(lock, Mapping):
        lock = {name: home_position(description, entry, name) for name in names}
    for name, value in lock.items():
        if not is_number(value):
            subject = f"lock of joint '{name}'"
            raise ParameterError(subject, repr(value), "a number [rad or m]", field="lock")
    return locks | {name: float(value) for name, value in lock.items()}


def _check_lockable(description: RobotDescription, name: str) -> None:
    joints = description.moving_joints
    known_name(f"{description.file}: moving joint", name, joints, field="lock")
    mimic = joints[name].mimic
    if mimic is not None:
        raise UrdfError(
            f"{description.file}: joint '{name}'",
            "a mimic joint cannot be locked",
            "an independent joint",
            f"lock '{mimic.joint}', which it mimics",
            field="lock",
        )


def joint_rules(description: RobotDescription, locks: Mapping[str, float]) -> dict[str, JointRule]:
    """The rule of every moving joint of the file.

    Args:
        description: The URDF.
        locks: Joint names and the values at which they are held [rad or m].

    Raises:
        UrdfError: If a mimic tag names a joint that does not exist or leads to itself.
    """
    joints = description.moving_joints
    fixed = {joint.name for joint in description.robot.joints} - joints.keys()

    def rule(name: str) -> JointRule:
        multiplier, offset = 1.0, 0.0
        chain: list[str] = []
        while name in joints and name not in locks:
            mimic = joints[name].mimic
            if mimic is None:
                return JointRule(name, multiplier, offset)
            if name in chain:
                others = ", ".join(f"'{other}'" for other in chain[chain.index(name) + 1 :])
                raise UrdfError(
                    f"{description.file}: joint '{name}'",
                    f"mimics itself through {others}" if others else "mimics itself",
                    "mimic joints that lead to an independent joint",
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


def coordinate_map(
    joints: list[str], coordinates: tuple[str, ...], rules: Mapping[str, JointRule]
) -> tuple[Array, Array]:
    """G (N, n) and g0 (N,) of q_model = G q + g0, for N joints that follow n coordinates."""
    G = np.zeros((len(joints), len(coordinates)))
    for row, joint in enumerate(joints):
        rule = rules[joint]
        if rule.leader is not None:
            G[row, coordinates.index(rule.leader)] = rule.multiplier
    return G, np.array([rules[joint].offset for joint in joints])
