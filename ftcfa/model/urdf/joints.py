"""The arm's coordinates: locked and mimic joints as one linear map; home, limits and friction.

Every moving joint j of the file follows q_j = a_j q_i + b_j for one coordinate i of the arm, or
does not move and has the value b_j (a locked joint, or one that mimics a locked or fixed joint).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import (
    about,
    is_number,
    known_name,
    not_negative,
    positive,
    positive_numbers,
    vector,
)
from ftcfa.errors import ParameterError, UrdfError
from ftcfa.model.urdf.catalogue import CatalogueEntry
from ftcfa.model.urdf.description import RobotDescription, position_limits

NO_EFFORT = 1e100
"""Effort limits this large mean "unlimited" [N m or N]."""
Locks = Mapping[str, float] | Iterable[str]
JointValues = float | Sequence[float] | Mapping[str, float]
"""One number, one for each coordinate, or some by joint name."""


class JointRule(NamedTuple):
    """How one joint of the file follows the arm's coordinates."""

    leader: str | None  # joint whose coordinate it follows, maybe itself; None: it does not move
    multiplier: float  # a_j
    offset: float  # b_j [rad or m]


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
    joints = description.moving_joints
    if entry is not None and entry.joints:
        for name, joint in joints.items():
            if joint.mimic is None and name not in entry.joints:
                locks[name] = home_position(description, entry, name)
    if lock is None:
        return locks
    if not isinstance(lock, Iterable):
        expected = "joint names, or names with values [rad or m]"
        raise ParameterError("lock", repr(lock), expected, field="lock")
    names = [lock] if isinstance(lock, str) else [str(name) for name in lock]
    for name in names:
        known_name(f"{description.file}: moving joint", name, joints, field="lock")
        if joints[name].mimic is not None:
            got, expected = "a mimic joint cannot be locked", "an independent joint"
            remedy = f"lock '{joints[name].mimic.joint}', which it mimics"
            raise UrdfError(description.subject(name), got, expected, remedy, field="lock")
    if not isinstance(lock, Mapping):
        lock = {name: home_position(description, entry, name) for name in names}
    for name, value in lock.items():
        if not is_number(value):
            subject = f"lock of joint '{name}'"
            raise ParameterError(subject, repr(value), "a number [rad or m]", field="lock")
    return locks | {name: float(value) for name, value in lock.items()}


def joint_rules(description: RobotDescription, locks: Mapping[str, float]) -> dict[str, JointRule]:
    """The rule of every moving joint of the file, where ``locks`` hold some [rad or m].

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
                got = f"mimics itself through {others}" if others else "mimics itself"
                expected = "mimic joints that lead to an independent joint"
                raise UrdfError(description.subject(name), got, expected, "correct its <mimic>")
            chain.append(name)
            multiplier, offset = multiplier * mimic.multiplier, offset + multiplier * mimic.offset
            name = mimic.joint
        if name not in joints and name not in fixed:
            got = f"mimics '{name}', which does not exist"
            expected = f"a joint of this file ({', '.join(joints)})"
            raise UrdfError(description.subject(chain[-1]), got, expected, "correct its <mimic>")
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


def home_position(description: RobotDescription, entry: CatalogueEntry | None, joint: str) -> float:
    """The catalogue's value, else zero, else the middle of a range that excludes zero."""
    lower, upper = position_limits(description.moving_joints[joint])
    fallback = 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2
    return entry.home.get(joint, fallback) if entry is not None else fallback


def joint_limits(
    description: RobotDescription, names: tuple[str, ...]
) -> tuple[Array, Array, Array]:
    """Lower, upper and velocity limits, shape (n,) each; infinite where the URDF gives none."""
    lower, upper, velocity = np.full((3, len(names)), np.inf)
    for i, name in enumerate(names):
        joint = description.moving_joints[name]
        lower[i], upper[i] = position_limits(joint)
        if joint.limit is not None and joint.limit.velocity:
            velocity[i] = joint.limit.velocity
    return lower, upper, velocity


def range_faults(description: RobotDescription, names: Iterable[str]) -> Iterator[UrdfError]:
    """Joints whose lower and upper limit are equal."""
    for name in names:
        lower, upper = position_limits(description.moving_joints[name])
        if lower == upper:
            got = f"lower and upper limit are both {lower:g}"
            remedy = "widen it, or lock the joint"
            yield UrdfError(description.subject(name), got, "a range to move in", remedy)


def effort_limits(
    description: RobotDescription, names: tuple[str, ...], effort_limit: JointValues | None
) -> Array:
    """u*, shape (n,): the user's value where there is one, else the URDF's; NaN without one.

    Raises:
        UnknownNameError, ParameterError, ShapeError: If ``effort_limit`` names an unknown joint,
            or has a wrong value or shape.
    """
    given = _by_joint("effort_limit", effort_limit, names, names)
    with about("effort_limit"):
        if isinstance(effort_limit, Mapping):
            for name, value in given.items():
                positive(f"effort_limit of joint '{name}'", value, "N m or N")
        elif given:
            check_effort_limit("effort_limit", given)
    return np.array([float(given.get(name, _urdf_effort(description, name))) for name in names])


def _by_joint(
    argument: str, values: JointValues | None, coordinates: Sequence[str], joints: Sequence[str]
) -> dict[str, float]:
    """Values of an argument by joint name: its own names, or those of the coordinates.

    Raises:
        UnknownNameError, ShapeError: If it names none of the joints, or has a wrong shape.
    """
    if isinstance(values, Mapping):
        for name in values:
            known_name(f"{argument} of joint", name, joints, field=argument)
        return dict(values)
    if values is None:
        return {}
    with about(argument):
        numbers = vector(argument, values, len(coordinates))
    return dict(zip(coordinates, numbers.tolist(), strict=True))


def _urdf_effort(description: RobotDescription, joint: str) -> float:
    limit = description.moving_joints[joint].limit
    effort = 0.0 if limit is None else float(limit.effort or 0.0)
    return abs(effort) if 0.0 < abs(effort) < NO_EFFORT else np.nan


def effort_faults(
    description: RobotDescription, names: tuple[str, ...], limits: Array
) -> Iterator[UrdfError]:
    """One fault with all joints that have no effort limit."""
    missing = [name for name, limit in zip(names, limits, strict=True) if np.isnan(limit)]
    if not missing:
        return
    which = f"joint '{missing[0]}'" if len(missing) == 1 else f"joints {', '.join(missing)}"
    remedy = (
        'write <limit effort="..."> or pass effort_limit, one number or '
        f'{{"{missing[0]}": value{", ..." if len(missing) > 1 else ""}}} '
        f"(on the command line --effort-limit 50 or --effort-limit {missing[0]}=50)"
    )
    got = "effort limit missing, zero or infinite"
    yield UrdfError(f"{description.file}: {which}", got, "a positive effort", remedy)


def joint_armature(
    description: RobotDescription,
    entry: CatalogueEntry | None,
    joints: Sequence[str],
    coordinates: Sequence[str],
    armature: JointValues | None,
) -> Array:
    """Rotor inertia J r^2 of each joint, shape (N,): the user's, else the catalogue's or URDF's.

    Raises:
        UnknownNameError, ParameterError, ShapeError: If ``armature`` names an unknown joint, or has
            a wrong value or shape.
    """
    known = {**description.armature, **(entry.armature if entry is not None else {})}
    known |= _by_joint("armature", armature, coordinates, joints)
    with about("armature"):
        check_armature("armature", known)
    return np.array([float(known.get(name, 0.0)) for name in joints])


def check_armature(subject: str, armature: JointValues) -> None:
    """Raise a FtcfaError unless rotor inertias are numbers from zero up."""
    given = armature.values() if isinstance(armature, Mapping) else np.ravel(armature)
    for value in given:
        not_negative(subject, value, "kg m^2 or kg")


def check_effort_limit(subject: str, effort_limit: JointValues | Array) -> None:
    """Raise a FtcfaError unless torque limits are positive numbers."""
    values = [*effort_limit.values()] if isinstance(effort_limit, Mapping) else effort_limit
    positive_numbers(subject, values, "N m or N")


def joint_friction(description: RobotDescription, joints: Iterable[str], name: str) -> Array:
    """``damping`` or ``friction`` of the named joints; zero where the URDF gives none."""
    tags = [description.moving_joints[joint].dynamics for joint in joints]
    return np.array([float(getattr(tag, name, None) or 0.0) for tag in tags])
