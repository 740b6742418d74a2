"""Read, check and normalise a URDF into a sound tree of links and joints.

Only what dynamics needs is kept: visual and collision elements are dropped, so no mesh is ever
opened. yourdfpy turns the rest into dataclasses.
"""

import io
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import yourdfpy
from lxml import etree
from yourdfpy.urdf import Joint, Link, Robot

from ftcfa.errors import UrdfError
from ftcfa.model.urdf.xml import read_xml

NO_LIMIT = 1e6
"""Position limits this large mean "unlimited" [rad or m]."""
MAX_LINKS = 1000
"""Parsers recurse down the tree; several thousand links in a row overflow their stacks."""


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A URDF whose tree has been checked.

    Attributes:
        file: Path of the file, or its name in messages.
        robot: Links and joints as yourdfpy's dataclasses.
        root: The XML tree, cut down to what dynamics needs.
    """

    file: Path
    robot: Robot
    root: etree._Element

    @cached_property
    def moving_joints(self) -> dict[str, Joint]:
        """The joints that are not fixed, by name, in the order of the file."""
        return {joint.name: joint for joint in self.robot.joints if joint.type != "fixed"}

    def links_moved_by(self, joint_names: set[str]) -> list[Link]:
        """The links that at least one of the named joints moves."""
        children = [joint.child for joint in self.robot.joints if joint.name in joint_names]
        moved = _carried_by(self.robot, children)
        return [link for link in self.robot.links if link.name in moved]

    @property
    def text(self) -> str:
        """Text of the URDF with only what dynamics needs; it loads as the same robot."""
        return etree.tostring(self.root, encoding="unicode")

    def pinocchio_xml(self) -> str:
        """Text of the URDF for Pinocchio.

        Continuous joints become revolute (one coordinate, not cosine and sine). Mimic, limit and
        dynamics tags are removed, because the Arm has coordinates, limits and friction itself.
        """
        root = etree.fromstring(self.text)
        for joint in root.findall("joint"):
            etree.strip_elements(joint, "mimic", "limit", "dynamics")
            if joint.get("type") != "fixed":
                joint.set("type", joint.get("type").replace("continuous", "revolute"))
                etree.SubElement(joint, "limit", lower="-1", upper="1", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")


def read_urdf(file: Path, text: bytes | None = None) -> RobotDescription:
    """Read a URDF and check its tree.

    Args:
        file: Path of the file, or its name in messages if ``text`` is given.
        text: Content of the file; read from it if None.

    Raises:
        UrdfError: If the file cannot be read, is not a URDF, or its joints are not one tree of
            fixed, revolute, continuous and prismatic joints.
    """
    root = read_xml(file, text)
    stream = io.BytesIO(etree.tostring(root, encoding="utf-8"))
    robot = yourdfpy.URDF.load(stream, build_scene_graph=False, load_meshes=False).robot
    _check_tree(file, robot)
    return RobotDescription(file, robot, root)


def _check_tree(file: Path, robot: Robot) -> None:
    """Refuse joints that are not one tree of existing links, or have wrong axes or limits."""
    links = {link.name for link in robot.links}
    if not links:
        raise UrdfError(str(file), "no links", "links and joints in <robot>", "export it again")
    if len(links) > MAX_LINKS:
        raise UrdfError(
            str(file), f"{len(links)} links", f"at most {MAX_LINKS}", "merge links fixed together"
        )
    parents: dict[str, Joint] = {}
    for joint in robot.joints:
        subject = f"{file}: joint '{joint.name}'"
        for end in (joint.parent, joint.child):
            if end not in links:
                raise UrdfError(
                    subject,
                    f"link '{end}' does not exist",
                    "a link of this file",
                    "add it, or delete the joint",
                )
        if joint.child in parents:
            other = parents[joint.child].name
            raise UrdfError(
                subject,
                f"link '{joint.child}' is also the child of joint '{other}'",
                "a tree: one parent for each link",
                "remove one joint of the kinematic loop",
            )
        parents[joint.child] = joint
        if joint.type != "fixed":
            _check_motion(subject, joint)
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        raise UrdfError(
            str(file),
            f"{len(roots)} root links ({', '.join(roots)})",
            "exactly one link without a parent",
            "connect them with fixed joints",
        )
    for name in sorted(links - _carried_by(robot, roots)):
        raise UrdfError(
            f"{file}: link '{name}'",
            "carried by a loop of joints, not by the root link",
            "a tree",
            "remove one joint of the loop",
        )


def _carried_by(robot: Robot, links: Iterable[str]) -> set[str]:
    """The named links and all links that they carry."""
    below: dict[str, list[str]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint.child)
    carried: set[str] = set()
    waiting = list(links)
    while waiting:
        link = waiting.pop()
        if link not in carried:
            carried.add(link)
            waiting.extend(below.get(link, ()))
    return carried


def position_limits(joint: Joint) -> tuple[float, float]:
    """Lower and upper limit [rad or m]; infinite where the URDF gives none, or 0 and 0.

    Exporters write huge numbers for an unlimited joint: limits from NO_LIMIT on are infinite.
    """
    limit = joint.limit
    lower, upper = (limit.lower or 0.0, limit.upper or 0.0) if limit is not None else (0.0, 0.0)
    if joint.type == "continuous" or lower == upper == 0.0:
        return -np.inf, np.inf
    return (-np.inf if lower <= -NO_LIMIT else lower, np.inf if upper >= NO_LIMIT else upper)


def _check_motion(subject: str, joint: Joint) -> None:
    """Refuse a moving joint without an axis, with limits in wrong order or negative values."""
    if not np.linalg.norm(joint.axis) > 0:
        remedy = 'write one, such as <axis xyz="0 0 1"/>'
        raise UrdfError(subject, "the axis is zero", "a direction", remedy)
    lower, upper = position_limits(joint)
    if lower > upper:
        raise UrdfError(
            subject,
            f"lower limit {lower:g} is above upper limit {upper:g}",
            "lower <= upper (a missing limit is 0)",
            "correct its <limit>",
        )
    for tag, names in (
        (joint.limit, ("effort", "velocity")),
        (joint.dynamics, ("damping", "friction")),
    ):
        for name in names:
            value = float(getattr(tag, name, None) or 0.0)
            if value < 0:
                remedy = "remove the minus sign"
                raise UrdfError(subject, f"{name} is {value:g}", f"{name} >= 0", remedy)
