"""Read, check and normalise a URDF into a sound tree of links and joints.

Only what dynamics needs is kept: visual and collision elements are dropped, so no mesh is ever
opened. yourdfpy turns the rest into dataclasses.
"""

import copy
import io
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import yourdfpy
from lxml import etree
from yourdfpy.urdf import Joint, Robot

from ftcfa.errors import CompoundUrdfError, UrdfError
from ftcfa.model.urdf.text import parse, read_bytes
from ftcfa.model.urdf.xml import cut_down, element_faults, tree_faults

NO_LIMIT = 1e6
"""Position limits this large mean "unlimited" [rad or m]."""


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A URDF whose tree has been checked."""

    file: Path  # or its name in messages
    robot: Robot  # links and joints as yourdfpy's dataclasses
    root: etree._Element  # the XML tree, cut down to what dynamics needs
    warnings: tuple[str, ...] = ()  # about its XML
    faults: tuple[UrdfError, ...] = ()  # that make it unusable, but leave a tree

    def subject(self, name: str) -> str:
        """Subject of a message about a joint."""
        return f"{self.file}: joint '{name}'"

    @cached_property
    def moving_joints(self) -> dict[str, Joint]:
        """The joints that are not fixed, by name, in the order of the file."""
        return {joint.name: joint for joint in self.robot.joints if joint.type != "fixed"}

    @cached_property
    def armature(self) -> dict[str, float]:
        """Rotor inertia J r^2 by joint, of the <transmission> elements [kg m^2 or kg]."""
        found = {}
        for transmission in self.root.iterchildren("transmission"):
            values = {part.tag: float(part.get("value")) for part in transmission}
            if len(values) == 2:  # none of them was wrong
                found[transmission.get("joint")] = (
                    values["rotor_inertia"] * values["gear_ratio"] ** 2
                )
        return {name: value for name, value in found.items() if name in self.moving_joints}

    @property
    def text(self) -> str:
        """Text of the URDF with only what dynamics needs; it loads as the same robot.

        Raises:
            UrdfError: If it has faults.
        """
        raise_all(self.faults)
        return etree.tostring(self.root, encoding="unicode")

    def pinocchio_xml(self) -> str:
        """Text of the URDF for Pinocchio.

        Continuous joints become revolute (one coordinate, not cosine and sine). Mimic, limit and
        dynamics tags are removed, because the Arm has coordinates, limits and friction itself.
        """
        root = _without_rotors(self.root)
        for joint in root.findall("joint"):
            etree.strip_elements(joint, "mimic", "limit", "dynamics")
            if joint.get("type") != "fixed":
                joint.set("type", joint.get("type").replace("continuous", "revolute"))
                etree.SubElement(joint, "limit", lower="-1", upper="1", effort="1", velocity="1")
        return etree.tostring(root, encoding="unicode")


def read_urdf(file: Path, content: bytes | None = None) -> RobotDescription:
    """Read a URDF whose links and joints are one tree.

    Args:
        file: Path of the file, or its name in messages if ``content`` is given.
        content: Content of the file; read from it if None.

    Raises:
        UrdfError: If the file cannot be read, is not a URDF, or has no tree of joints. Other
            faults stand in `RobotDescription.faults`.
    """
    if content is None:
        content = read_bytes(file)
    tree, warnings = parse(file, content)
    root, more = cut_down(tree)
    faults = [*tree_faults(file, root)]
    whole = not faults
    faults += element_faults(file, root)
    if not whole:
        raise_all(faults)
    stream = io.BytesIO(etree.tostring(_without_rotors(root), encoding="utf-8"))
    robot = yourdfpy.URDF.load(stream, build_scene_graph=False, load_meshes=False).robot
    loose = [*_loose_ends(file, robot)]
    faults += loose
    for joint in robot.joints:
        faults += _motion_faults(f"{file}: joint '{joint.name}'", joint)
    if loose:
        raise_all(faults)
    return RobotDescription(file, robot, root, tuple(warnings + more), tuple(faults))


def _without_rotors(root: etree._Element) -> etree._Element:
    """Copy of a tree with nothing but links and joints, for other parsers."""
    root = copy.deepcopy(root)
    etree.strip_elements(root, "transmission")
    return root


def raise_all(faults: Sequence[UrdfError]) -> None:
    """Raise one fault as it is, and several together."""
    if faults:
        raise faults[0] if len(faults) == 1 else CompoundUrdfError(faults)


def _loose_ends(file: Path, robot: Robot) -> Iterator[UrdfError]:
    """Why joints are not one tree of existing links."""
    links = {link.name for link in robot.links}
    if not links:
        yield UrdfError(str(file), "no links", "links and joints in <robot>", "export it again")
        return
    parents: dict[str, Joint] = {}
    dangling = False
    for joint in robot.joints:
        subject = f"{file}: joint '{joint.name}'"
        for end in (joint.parent, joint.child):
            if end not in links:
                dangling = True
                got, remedy = f"link '{end}' does not exist", "add it, or delete the joint"
                yield UrdfError(subject, got, "a link of this file", remedy)
        if joint.child in parents:
            other = parents[joint.child].name
            got = f"link '{joint.child}' is also the child of joint '{other}'"
            remedy = "remove one joint of the kinematic loop"
            yield UrdfError(subject, got, "a tree: one parent for each link", remedy)
        parents[joint.child] = joint
    if dangling:
        return  # other loose ends may follow from it
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        got = f"{len(roots)} root links ({', '.join(roots)})"
        expected = "exactly one link without a parent"
        yield UrdfError(str(file), got, expected, "connect them with fixed joints")
    looped = sorted(links - carried_by(robot, roots))
    if looped:
        names = ", ".join(f"'{name}'" for name in looped)
        got = f"carried by a loop of joints, not by the root link: {names}"
        yield UrdfError(str(file), got, "a tree", "remove one joint of the loop")


def carried_by(robot: Robot, links: Iterable[str]) -> set[str]:
    """The named links and all links that they carry."""
    below: defaultdict[str, list[str]] = defaultdict(list)
    for joint in robot.joints:
        below[joint.parent].append(joint.child)
    carried, pending = set(), list(links)
    while pending:
        link = pending.pop()
        if link not in carried:
            carried.add(link)
            pending += below[link]
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


def _motion_faults(subject: str, joint: Joint) -> Iterator[UrdfError]:
    """A missing axis, limits in wrong order and negative values of a moving joint."""
    if joint.type == "fixed":
        return
    if not np.linalg.norm(joint.axis) > 0:
        remedy = 'write one, such as <axis xyz="0 0 1"/>'
        yield UrdfError(subject, "the axis is zero", "a direction", remedy)
    lower, upper = position_limits(joint)
    if lower > upper:
        got = f"lower limit {lower:g} is above upper limit {upper:g}"
        expected = "lower <= upper (a missing limit is 0)"
        yield UrdfError(subject, got, expected, "correct its <limit>")
    for tag in (joint.limit, joint.dynamics):
        for name in ("effort", "velocity", "damping", "friction"):
            value = float(getattr(tag, name, None) or 0.0)
            if value < 0:
                remedy = "remove the minus sign"
                yield UrdfError(subject, f"{name} is {value:g}", f"{name} >= 0", remedy)
