"""Read, check and normalise a URDF: a file in, a sound tree of links and joints out.

Only what dynamics needs is kept (no visual, no collision, so no mesh is ever opened); yourdfpy
turns it into dataclasses.
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

from ftcfa.errors import UnknownNameError, UrdfError
from ftcfa.model.urdf.xml import read_xml

NO_LIMIT = 1e6
"""Position limits this large are none [rad or m]."""
ROUNDING = 1e-15
"""Moments of inertia of a body of one kilogram that are nothing but rounding [m^2]."""
INERTIA_TOLERANCE = 1e-6
"""Slack of the inertia checks relative to the largest principal moment: CAD exporters round."""
MAX_LINKS = 1000
"""Parsers recurse down the tree; several thousand links in a row overflow their stack."""


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A URDF that has been read and whose tree is sound.

    Attributes:
        file: The path it came from.
        robot: yourdfpy's dataclasses of its links and joints.
        root: The XML tree, cut down to what dynamics needs.
    """

    file: Path
    robot: Robot
    root: etree._Element

    @cached_property
    def moving_joints(self) -> dict[str, Joint]:
        """The joints that are not fixed, by name, in the order of the file."""
        return {joint.name: joint for joint in self.robot.joints if joint.type != "fixed"}

    def moving_joint(self, name: str) -> Joint:
        """The moving joint of that name.

        Raises:
            UnknownNameError: If there is none; it lists the known ones.
        """
        if name not in self.moving_joints:
            raise UnknownNameError(f"{self.file}: moving joint", name, list(self.moving_joints))
        return self.moving_joints[name]

    def links_moved_by(self, joint_names: set[str]) -> list[Link]:
        """The links that at least one of the named joints moves."""
        children = [joint.child for joint in self.robot.joints if joint.name in joint_names]
        moved = _carried_by(self.robot, children)
        return [link for link in self.robot.links if link.name in moved]

    @property
    def text(self) -> str:
        """The URDF cut down to what dynamics needs: it loads as the same robot."""
        return etree.tostring(self.root, encoding="unicode")

    def pinocchio_xml(self) -> str:
        """The tree as Pinocchio reads it best.

        Continuous joints become revolute (one coordinate, not cosine and sine); mimic, limit and
        dynamics tags go, because coordinates, limits and friction are the Arm's.
        """
        root = etree.fromstring(self.text)
        for joint in root.findall("joint"):
            etree.strip_elements(joint, "mimic", "limit", "dynamics")
            if joint.get("type") != "fixed":
                joint.set("type", joint.get("type").replace("continuous", "revolute"))
                etree.SubElement(joint, "limit", lower="-1", upper="1", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")


def read_urdf(file: Path, text: bytes | None = None) -> RobotDescription:
    """Read a URDF file, or the text of one that messages call ``file``, and check its tree.

    Raises:
        UrdfError: If the file cannot be read, is not a URDF, or is not one tree of fixed,
            revolute, continuous and prismatic joints.
    """
    root = read_xml(file, text)
    stream = io.BytesIO(etree.tostring(root, encoding="utf-8"))
    robot = yourdfpy.URDF.load(stream, build_scene_graph=False, load_meshes=False).robot
    _check_tree(file, robot)
    return RobotDescription(file, robot, root)


def _check_tree(file: Path, robot: Robot) -> None:
    """The joints join existing links into one tree, along real axes, within ordered limits."""
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
                "cut the kinematic loop",
            )
        parents[joint.child] = joint
        if joint.type == "fixed":
            continue
        if not np.linalg.norm(joint.axis) > 0:
            raise UrdfError(
                subject, "the axis is zero", "a direction", 'such as <axis xyz="0 0 1"/>'
            )
        _check_limits(subject, joint)
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        raise UrdfError(
            str(file),
            f"{len(roots)} root links ({', '.join(roots)})",
            "exactly one link without a parent",
            "join the others to it with fixed joints",
        )
    for name in sorted(links - _carried_by(robot, roots)):
        raise UrdfError(
            f"{file}: link '{name}'",
            "hangs from a loop of joints, not from a root",
            "a tree",
            "remove one joint of the loop",
        )


def _carried_by(robot: Robot, links: Iterable[str]) -> set[str]:
    """The named links and all below them."""
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
    """Lower and upper limit [rad or m]; infinite where the URDF has none, or its defaults 0, 0.

    Exporters write huge numbers for no limit: from NO_LIMIT on they mean none.
    """
    limit = joint.limit
    lower, upper = (limit.lower or 0.0, limit.upper or 0.0) if limit is not None else (0.0, 0.0)
    if joint.type == "continuous" or lower == upper == 0.0:
        return -np.inf, np.inf
    return (-np.inf if lower <= -NO_LIMIT else lower, np.inf if upper >= NO_LIMIT else upper)


def _check_limits(subject: str, joint: Joint) -> None:
    lower, upper = position_limits(joint)
    if lower > upper:
        raise UrdfError(
            subject,
            f"lower limit {lower} above upper {upper}",
            "lower <= upper (0 where not given)",
            "correct its <limit>",
        )
    for tag, names in (
        (joint.limit, ("effort", "velocity")),
        (joint.dynamics, ("damping", "friction")),
    ):
        for name in names:
            value = float(getattr(tag, name, None) or 0.0)
            if value < 0:
                raise UrdfError(subject, f"{name} is {value:g}", f"{name} >= 0", "drop the sign")


def inertia_defect(link: Link) -> tuple[str, str, str] | None:
    """What makes a link's inertia unphysical: (found, expected, remedy), or None.

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
        found = f"inertia is not positive definite (smallest eigenvalue {a:.3g} kg m^2)"
        return found, "principal moments >= 0", "give it a physical tensor"
    if a < c - b - slack:
        found = f"inertia breaks the triangle inequality ({a:.3g} + {b:.3g} < {c:.3g} kg m^2)"
        return found, "a tensor that a real body can have", "recompute <inertia> from the geometry"
    return None
