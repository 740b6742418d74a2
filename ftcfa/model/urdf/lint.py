"""Warnings about URDFs that load: what is unusual, and what is probably not meant."""

from collections.abc import Collection, Iterable, Iterator

import numpy as np
from yourdfpy.urdf import Link

from ftcfa.model.arm import Arm
from ftcfa.model.gravity_load import gravity_load
from ftcfa.model.urdf.bodies import defect
from ftcfa.model.urdf.description import RobotDescription, position_limits

TURNS = 4
"""A revolute joint that may turn further is probably limited in degrees."""
LONG = 10.0
"""Lengths beyond it are probably millimetres [m]."""
SPREAD = 5.0
"""A radius of gyration this many times the size of a link is not that of the link."""
SMALL = 0.1
"""Links count as this large at least: their geometry is not read [m]."""
ALIKE = 3
"""From so many equal effort limits of one digit on they are asked about."""


def lint_bodies(description: RobotDescription, moved: Iterable[Link]) -> Iterator[str]:
    """Warnings about the bodies of the links; ``moved`` are those that move."""
    reach, names = _sizes(description), {link.name for link in moved}
    for link in description.robot.links:
        body, subject = link.inertial, f"link '{link.name}'"
        if link.name not in names:
            why = defect(link)
            if why is not None:
                yield f"{subject}: {why[0]}; ignored because the link does not move"
        elif body is not None and body.mass > 0 and not body.inertia.any():
            yield f"{subject}: no rotational inertia; taken as a point mass"
        elif body is not None and body.mass == 0 and body.inertia.any():
            yield f"{subject}: rotational inertia without mass"
        elif body is not None and body.mass > 0:
            yield from _gyration(subject, link, reach[link.name])


def _sizes(description: RobotDescription) -> dict[str, float]:
    """Distance from each link's origin to the farthest of its centre of mass and its joints [m]."""
    sizes = {
        link.name: 0.0 if link.inertial is None else _length(link.inertial.origin)
        for link in description.robot.links
    }
    for joint in description.robot.joints:
        sizes[joint.parent] = max(sizes[joint.parent], _length(joint.origin))
    return sizes


def _length(origin: np.ndarray | None) -> float:
    return 0.0 if origin is None else float(np.linalg.norm(origin[:3, 3]))


def _gyration(subject: str, link: Link, size: float) -> Iterator[str]:
    radius = float(np.sqrt(np.linalg.eigvalsh(link.inertial.inertia)[-1] / link.inertial.mass))
    if radius > SPREAD * max(size, SMALL):
        yield (
            f"{subject}: {link.inertial.mass:.3g} kg with a radius of gyration of {radius:.3g} m, "
            f"on a link of {size:.2g} m; check <mass> and <inertia>"
        )


def lint_joints(description: RobotDescription, names: Collection[str]) -> Iterator[str]:
    """Warnings about the joints that have a coordinate of their own, by name."""
    for name in names:
        joint = description.moving_joints[name]
        lower, upper = position_limits(joint)
        if joint.type != "continuous" and lower == -np.inf:
            yield f"joint '{name}': no position limits; taken as unlimited"
        if joint.limit is None or not 0 < float(joint.limit.velocity or 0.0) < np.inf:
            yield f"joint '{name}': no velocity limit; taken as unlimited"
        farthest = max((abs(x) for x in (lower, upper) if np.isfinite(x)), default=0.0)
        turns = farthest / (2 * np.pi)
        if joint.type == "revolute" and turns > TURNS:
            yield f"joint '{name}': may turn to {farthest:.4g} rad, {turns:.0f} turns; degrees?"
        if joint.type == "prismatic" and farthest > LONG:
            yield f"joint '{name}': slides to {farthest:.4g} m; millimetres?"
    for joint in description.robot.joints:
        distance = _length(joint.origin)
        if distance > LONG:
            yield f"joint '{joint.name}': {distance:.4g} m from its parent's origin; millimetres?"


def lint_efforts(arm: Arm) -> Iterator[str]:
    """Warnings about effort limits that gravity or friction exceeds, or that are all alike."""
    load, limit = gravity_load(arm), np.asarray(arm.effort_limit)
    friction = np.abs(arm.G.T) @ arm.friction
    for i, name in enumerate(arm.joint_names):
        unit = "N" if arm.joint_types[i] == "prismatic" else "N m"
        for where, force in (("at home", load.home[i]), ("somewhere in its range", load.worst[i])):
            if force > limit[i]:
                yield (
                    f"joint '{name}': needs {force:.4g} {unit} against gravity {where}, "
                    f"its limit is {limit[i]:.4g} {unit}"
                )
                break
        if friction[i] >= limit[i]:
            yield (
                f"joint '{name}': its friction, {friction[i]:.4g} {unit}, is not below its limit, "
                f"{limit[i]:.4g} {unit}"
            )
    if arm.n >= ALIKE and len(set(limit.tolist())) == 1 and float(f"{limit[0]:.0e}") == limit[0]:
        yield f"all effort limits are {limit[0]:.4g}; placeholders?"
