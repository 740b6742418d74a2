"""Limits, friction and home position of each coordinate, from the URDF and from the user."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import known_name, vector
from ftcfa.errors import ParameterError, UrdfError
from ftcfa.model.urdf.catalogue import CatalogueEntry
from ftcfa.model.urdf.description import RobotDescription, position_limits

EffortLimit = float | Sequence[float] | Mapping[str, float]


def home_position(description: RobotDescription, entry: CatalogueEntry | None, joint: str) -> float:
    """The catalogue's value, else zero, else the middle of a range that excludes zero."""
    lower, upper = position_limits(description.moving_joints[joint])
    fallback = 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2
    return entry.home.get(joint, fallback) if entry is not None else fallback


def joint_limits(
    description: RobotDescription, names: tuple[str, ...]
) -> tuple[Array, Array, Array]:
    """Lower, upper and velocity limits, shape (n,) each; infinite where the URDF gives none.

    Raises:
        UrdfError: If the lower and the upper limit of a joint are equal.
    """
    n = len(names)
    lower, upper, velocity = np.empty(n), np.empty(n), np.full(n, np.inf)
    for i, name in enumerate(names):
        joint = description.moving_joints[name]
        lower[i], upper[i] = position_limits(joint)
        if lower[i] == upper[i]:
            raise UrdfError(
                f"{description.file}: joint '{name}'",
                f"lower and upper limit are both {lower[i]:g}",
                "a range to move in",
                "widen it, or lock the joint",
            )
        if joint.limit is not None and joint.limit.velocity:
            velocity[i] = joint.limit.velocity
    return lower, upper, velocity


def effort_limits(
    description: RobotDescription, names: tuple[str, ...], effort_limit: EffortLimit | None
) -> Array:
    """u*, shape (n,): the user's value where there is one, else the URDF's.

    Raises:
        UrdfError: If the URDF has no effort limit for a joint that needs it.
        UnknownNameError, ParameterError, ShapeError: If ``effort_limit`` names an unknown joint,
            or has a wrong value or shape.
    """
    if effort_limit is None or isinstance(effort_limit, Mapping):
        by_name = dict(effort_limit or {})
        for name in by_name:
            known_name("effort_limit of joint", name, names, field="effort_limit")
        effort_limit = [
            by_name[name] if name in by_name else _urdf_effort(description, name) for name in names
        ]
    limits = vector("effort_limit", effort_limit, len(names), field="effort_limit")
    if not np.all(limits > 0):
        expected = "positive numbers [N m or N]"
        raise ParameterError("effort_limit", f"{limits.tolist()}", expected, field="effort_limit")
    return limits


def _urdf_effort(description: RobotDescription, joint: str) -> float:
    limit = description.moving_joints[joint].limit
    if limit is None or not limit.effort:
        raise UrdfError(
            f"{description.file}: joint '{joint}'",
            "effort limit missing or zero",
            "a positive effort",
            'write <limit effort="..."> or pass effort_limit',
        )
    return float(limit.effort)


def joint_friction(description: RobotDescription, joints: Iterable[str], name: str) -> Array:
    """``damping`` or ``friction`` of the named joints; zero where the URDF gives none."""
    tags = [description.moving_joints[joint].dynamics for joint in joints]
    return np.array([float(getattr(tag, name, None) or 0.0) for tag in tags])
