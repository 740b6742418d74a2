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
ROUNDING = 1e-15
"""Moments of inertia of a body of one kilogram that are only rounding errors [m^2]."""
INERTIA_TOLERANCE = 1e-6
"""Slack of the inertia checks relative to the largest principal moment: CAD exporters round."""


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A URDF whose tree has been checked."""

    file: Path  # or its name in messages
    robot: Robot  # links and joints as yourdfpy's dataclasses
    root: etree._Element  # the XML tree, cut down to what dynamics needs

    def subject(self, name: str) -> str:
        """Subject of a message about a joint."""
        return f"{self.file}: joint '{name}'"

    @cached_property
    def moving_joints(self) -> dict[str, Joint]:
        """The joints that are not fixed, by name, in the order of the file."""
        return {joint.name: joint for joint in self.robot.joints if joint.type != "fixed"}

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
    """Read a URDF and check its tree; see `read_xml` for the arguments.

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
        got, remedy = f"{len(links)} links", "merge links fixed together"
        raise UrdfError(str(file), got, f"at most {MAX_LINKS}", remedy)
    parents: dict[str, Joint] = {}
    for joint in robot.joints:
        subject = f"{file}: joint '{joint.name}'"
        for end in (joint.parent, joint.child):
            if end not in links:
                got, remedy = f"link '{end}' does not exist", "add it, or delete the joint"
                raise UrdfError(subject, got, "a link of this file", remedy)
        if joint.child in parents:
            other = parents[joint.child].name
            got = f"link '{joint.child}' is also the child of joint '{other}'"
            remedy = "remove one joint of the kinematic loop"
            raise UrdfError(subject, got, "a tree: one parent for each link", remedy)
        parents[joint.child] = joint
        if joint.type != "fixed":
            _check_motion(subject, joint)
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        got = f"{len(roots)} root links ({', '.join(roots)})"
        expected = "exactly one link without a parent"
        raise UrdfError(str(file), got, expected, "connect them with fixed joints")
    for name in sorted(links - _carried_by(robot, roots)):
        got = "carried by a loop of joints, not by the root link"
        raise UrdfError(f"{file}: link '{name}'", got, "a tree", "remove one joint of the loop")


def _carried_by(robot: Robot, links: Iterable[str]) -> set[str]:
    """The named links and all links that they carry."""
    carried = set(links)
    while below := {j.child for j in robot.joints if j.parent in carried} - carried:
        carried |= below
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
        got = f"lower limit {lower:g} is above upper limit {upper:g}"
        expected = "lower <= upper (a missing limit is 0)"
        raise UrdfError(subject, got, expected, "correct its <limit>")
    for tag in (joint.limit, joint.dynamics):
        for name in ("effort", "velocity", "damping", "friction"):
            value = float(getattr(tag, name, None) or 0.0)
            if value < 0:
                remedy = "remove the minus sign"
                raise UrdfError(subject, f"{name} is {value:g}", f"{name} >= 0", remedy)


def lint(
    description: RobotDescription, moving: set[str], coordinates: tuple[str, ...]
) -> tuple[str, ...]:
    """Warnings about an unusual but usable URDF.

    ``moving`` are the joints that move, ``coordinates`` those of them with their own coordinate.

    Raises:
        UrdfError: If a link that moves has an unphysical inertia.
    """
    robot = description.robot
    carried = _carried_by(robot, (joint.child for joint in robot.joints if joint.name in moving))
    moved = [link for link in robot.links if link.name in carried]
    warnings = []
    for link in robot.links:
        defect = _inertia_defect(link)
        if defect is not None:
            if link in moved:
                raise UrdfError(f"{description.file}: link '{link.name}'", *defect)
            ignored = "ignored because the link does not move"
            warnings.append(f"link '{link.name}': {defect[0]}; {ignored}")
    for link in moved:
        body = link.inertial
        if body is not None and body.mass > 0 and not body.inertia.any():
            warnings.append(f"link '{link.name}': no rotational inertia; taken as a point mass")
        if body is not None and body.mass == 0 and body.inertia.any():
            warnings.append(f"link '{link.name}': rotational inertia without mass")
    for name in coordinates:
        joint = description.moving_joints[name]
        if joint.type != "continuous" and position_limits(joint)[0] == -np.inf:
            warnings.append(f"joint '{name}': no position limits; taken as unlimited")
        if joint.limit is None or not joint.limit.velocity:
            warnings.append(f"joint '{name}': no velocity limit; taken as unlimited")
    return tuple(warnings)


def _inertia_defect(link: Link) -> tuple[str, str, str] | None:
    """Why a link's inertia is unphysical: (got, expected, remedy), or None.

    Mass m >= 0; the rotational inertia about the centre of mass has principal moments
    0 <= a <= b <= c with a + b >= c (the triangle inequality of any real mass distribution).
    """
    if link.inertial is None:
        return None
    if link.inertial.mass < 0:
        return f"mass is {link.inertial.mass:g} kg", "a mass >= 0", "correct <mass>"
    a, b, c = np.linalg.eigvalsh(link.inertial.inertia)
    slack = INERTIA_TOLERANCE * max(abs(a), abs(c)) + ROUNDING * link.inertial.mass
    if a < -slack:
        got = f"inertia is not positive definite (smallest eigenvalue {a:.3g} kg m^2)"
        return got, "principal moments >= 0", "correct <inertia>"
    if a < c - b - slack:
        got = f"inertia violates the triangle inequality ({a:.3g} + {b:.3g} < {c:.3g} kg m^2)"
        return got, "a tensor that a real body can have", "recompute <inertia> from the geometry"
    return None
