"""Read, check and normalise a URDF: a file in, a sound tree of links and joints out.

The XML is parsed once, with entities, DTDs and the network refused. Only what dynamics needs is
kept (no visual, no collision, so no mesh is ever opened); yourdfpy turns it into dataclasses.
"""

import io
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import yourdfpy
from lxml import etree
from yourdfpy.urdf import Joint, Link, Robot

from ftcfa.errors import UrdfError

MAX_BYTES = 32 * 2**20
SUPPORTED_TYPES = ("revolute", "continuous", "prismatic", "fixed")
INERTIA_TOLERANCE = 1e-6
"""Slack of the inertia checks relative to the largest principal moment: CAD exporters round."""

_KEPT = {
    "link": ("inertial",),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}
_INERTIA = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1)
_NUMBERS = {  # attributes that must be numbers, with their count
    "mass": {"value": 1},
    "inertia": _INERTIA,
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
}
_REQUIRED = {  # attributes that may not be missing where the element occurs
    "mass": ("value",),
    "inertia": tuple(_INERTIA),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
}


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

    def links_moved_by(self, joint_names: set[str]) -> list[Link]:
        """The links that at least one of the named joints moves."""
        joint_above = {joint.child: joint for joint in self.robot.joints}

        def moves(link: str) -> bool:
            joint = joint_above.get(link)
            return joint is not None and (joint.name in joint_names or moves(joint.parent))

        return [link for link in self.robot.links if moves(link.name)]

    def pinocchio_xml(self) -> str:
        """The tree as Pinocchio reads it best.

        Continuous joints become revolute (one coordinate, not cosine and sine); mimic and limit
        tags go, because coordinates, limits and friction are the Arm's.
        """
        root = etree.fromstring(etree.tostring(self.root))
        for joint in root.findall("joint"):
            for element in joint.findall("mimic") + joint.findall("limit"):
                joint.remove(element)
            if joint.get("type") != "fixed":
                joint.set("type", joint.get("type").replace("continuous", "revolute"))
                etree.SubElement(joint, "limit", lower="-1", upper="1", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")


def read_urdf(file: Path) -> RobotDescription:
    """Read a URDF file and check its tree.

    Raises:
        UrdfError: If the file cannot be read, is not a URDF, or is not one tree of fixed,
            revolute, continuous and prismatic joints.
    """
    root = _cut_down(_parse(file, _read_bytes(file)))
    _check_elements(file, root)
    text = io.BytesIO(etree.tostring(root))
    robot = yourdfpy.URDF.load(text, build_scene_graph=False, load_meshes=False).robot
    _check_tree(file, robot)
    return RobotDescription(file, robot, root)


def _read_bytes(file: Path) -> bytes:
    try:
        size = file.stat().st_size
        if size > MAX_BYTES:
            raise UrdfError(
                str(file),
                f"the file has {size / 2**20:.0f} MiB",
                f"at most {MAX_BYTES // 2**20} MiB of URDF text",
                "name the URDF itself, not a mesh or an archive",
            )
        return file.read_bytes()
    except OSError as error:
        reason = (error.strerror or "unreadable").lower()
        raise UrdfError(
            str(file), reason, "a readable URDF file", "check the path and its permissions"
        ) from error


def _parse(file: Path, text: bytes) -> etree._Element:
    parser = etree.XMLParser(
        resolve_entities=False, load_dtd=False, no_network=True, remove_comments=True
    )
    try:
        root = etree.fromstring(text, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise UrdfError(
            str(file), f"not XML ({error})", "a URDF", "run `check_urdf` or re-export the file"
        ) from error
    if root.getroottree().docinfo.doctype:
        raise UrdfError(
            str(file),
            "a DOCTYPE, which could expand or include entities",
            "plain XML",
            "delete the <!DOCTYPE ...> and write the values out",
        )
    if root.tag != "robot":
        raise UrdfError(str(file), f"the root element is <{root.tag}>", "<robot>")
    if any("ros.org/wiki/xacro" in str(e.tag) for e in root.iter()):
        raise UrdfError(
            str(file), "xacro elements", "plain URDF", "run `xacro FILE > arm.urdf` first"
        )
    return root


def _cut_down(root: etree._Element) -> etree._Element:
    """Keep the attributes of links and joints and those children that dynamics needs."""
    cut = etree.Element("robot", name=root.get("name", "robot"))
    for element in root:
        if element.tag in _KEPT:
            kept = etree.SubElement(cut, element.tag, dict(element.attrib))
            kept.extend(child for tag in _KEPT[element.tag] for child in element.findall(tag)[:1])
    return cut


def _check_elements(file: Path, root: etree._Element) -> None:
    """Every name, reference and number that will be read is there and well formed."""
    seen: set[tuple[str, str]] = set()
    for element in root:
        name = element.get("name")
        if not name:
            raise UrdfError(str(file), f"a <{element.tag}> without a name", "a unique name")
        subject = f"{file}: {element.tag} '{name}'"
        if (element.tag, name) in seen:
            raise UrdfError(subject, "the name occurs twice", "unique names", "rename one of them")
        seen.add((element.tag, name))
        if element.tag == "joint":
            _check_joint_element(subject, element)
        elif (inertial := element.find("inertial")) is not None:
            for tag in ("mass", "inertia"):
                if inertial.find(tag) is None:
                    raise UrdfError(subject, f"<inertial> without <{tag}>", f"a <{tag}>")
        for part in element.iter(*_NUMBERS, *_REQUIRED):
            _check_attributes(subject, part)


def _check_joint_element(subject: str, joint: etree._Element) -> None:
    kind = joint.get("type")
    if kind not in SUPPORTED_TYPES:
        raise UrdfError(
            subject,
            f"joint type '{kind}' is not supported",
            f"one of {', '.join(SUPPORTED_TYPES)}",
            "model it with single-axis joints, or make it fixed",
        )
    for tag in ("parent", "child"):
        if joint.find(tag) is None:
            raise UrdfError(subject, f"no <{tag} link=...>", "a parent and a child link")


def _check_attributes(subject: str, part: etree._Element) -> None:
    for attribute in _REQUIRED.get(part.tag, ()):
        if part.get(attribute) is None:
            raise UrdfError(subject, f"<{part.tag}> without '{attribute}'", "that attribute")
    for attribute, count in _NUMBERS.get(part.tag, {}).items():
        text = part.get(attribute)
        if text is None:
            continue
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            numbers = []
        if len(numbers) != count or not np.all(np.isfinite(numbers)):
            raise UrdfError(
                subject,
                f'<{part.tag} {attribute}="{text[:40]}">',
                "a finite number" if count == 1 else f"{count} finite numbers",
            )


def _check_tree(file: Path, robot: Robot) -> None:
    """The joints join existing links into one tree, along real axes, within ordered limits."""
    links = {link.name for link in robot.links}
    if not links:
        raise UrdfError(str(file), "no links", "a robot with links and joints")
    parents: dict[str, Joint] = {}
    for joint in robot.joints:
        subject = f"{file}: joint '{joint.name}'"
        for end in (joint.parent, joint.child):
            if end not in links:
                raise UrdfError(subject, f"link '{end}' does not exist", "a link of this file")
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
    if len(roots) != 1:
        found = f"{len(roots)} root links ({', '.join(roots)})" if roots else "a loop without root"
        raise UrdfError(str(file), found, "exactly one link without a parent")
    _check_no_loop(file, robot, parents)


def _check_no_loop(file: Path, robot: Robot, parents: dict[str, Joint]) -> None:
    for link in robot.links:
        above, steps = link.name, 0
        while above in parents:
            above, steps = parents[above].parent, steps + 1
            if steps > len(parents):
                raise UrdfError(
                    f"{file}: link '{link.name}'", "is above itself", "a tree", "cut the loop"
                )


def _check_limits(subject: str, joint: Joint) -> None:
    limit, dynamics = joint.limit, joint.dynamics
    if limit is not None:
        if None not in (limit.lower, limit.upper) and limit.lower > limit.upper:
            raise UrdfError(
                subject, f"lower limit {limit.lower} above upper {limit.upper}", "lower <= upper"
            )
        for name in ("effort", "velocity"):
            if (getattr(limit, name) or 0.0) < 0:
                raise UrdfError(subject, f"negative {name} limit", f"{name} >= 0")
    for name in ("damping", "friction"):
        if dynamics is not None and float(getattr(dynamics, name) or 0.0) < 0:
            raise UrdfError(
                subject, f"negative {name}", f"{name} >= 0", "a joint cannot push itself"
            )


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
    slack = INERTIA_TOLERANCE * max(abs(a), abs(c))
    if a < -slack:
        found = f"inertia is not positive definite (smallest eigenvalue {a:.3g} kg m^2)"
        return found, "principal moments >= 0", "give it a physical tensor"
    if a + b < c - slack:
        found = f"inertia breaks the triangle inequality ({a:.3g} + {b:.3g} < {c:.3g} kg m^2)"
        return found, "a tensor that a real body can have", "recompute <inertia> from the geometry"
    return None
