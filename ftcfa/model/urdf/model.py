"""Pinocchio's model of a URDF, with constants that have the same bits on every machine.

Pinocchio computes placements and the inertias of welded links as well. But a compiler fuses its
products and sums where the processor has an instruction for it, and sines come from the machine's C
library, so the last bits differ. The model therefore takes the constants of this module.
"""

from collections import defaultdict
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from lxml import etree

from ftcfa.arrays import Array
from ftcfa.model.inertia import steiner, symmetric
from ftcfa.model.pinocchio_model import body_of
from ftcfa.portable import product, sin_cos

BASE = "universe"
"""Pinocchio's name of the joint that does not move."""
ENTRIES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of <inertia>, as `symmetric` takes them."""


def model_of_urdf(xml: str, gravity: Array, mounting: Array) -> pin.Model:
    """Pinocchio's model of a URDF text in a gravity field, shape (3,) [m/s^2], in world axes.

    ``mounting`` is the orientation of the base in the world, shape (3, 3). The model's own base
    frame has the axes of the world, so every quantity of the base is in world axes.
    """
    model, root = pin.buildModelFromXML(xml), etree.fromstring(xml)
    model.gravity.linear = gravity
    links, joints = _frames(root, mounting)
    bodies = _bodies(root, links)
    for i, name in enumerate(model.names):
        if name != BASE:
            model.jointPlacements[i] = joints[name].placement
            model.inertias[i] = bodies.get(name, pin.Inertia.Zero())
    for frame in list(model.frames)[1:]:  # the first is the world's; a slice would be a copy
        if frame.type != pin.FrameType.JOINT:  # that of a joint that moves is the joint's own
            known = links if frame.type == pin.FrameType.BODY else joints
            frame.placement = known[frame.name].placement
    return model


class _Frame(NamedTuple):
    """A frame fixed to the body of a joint that moves, or to the base."""

    carrier: str  # name of the joint
    R: Array  # rotation to the axes of the joint's frame, shape (3, 3)
    p: Array  # origin in the joint's frame, shape (3,) [m]

    def at(self, element: etree._Element) -> "_Frame":
        """The frame of an element's <origin> in this frame."""
        origin = element.find("origin")
        xyz, rpy = (_numbers(origin, name) for name in ("xyz", "rpy"))
        p = product(self.R, xyz[:, None])[:, 0] + self.p
        return _Frame(self.carrier, product(self.R, _rotation(rpy)), p)

    @property
    def placement(self) -> pin.SE3:
        return pin.SE3(self.R, self.p)


def _numbers(origin: etree._Element | None, name: str) -> Array:
    words = "0 0 0" if origin is None else origin.get(name, "0 0 0")
    return np.array([float(word) for word in words.split()])


def _rotation(rpy: Array) -> Array:
    """Rotation Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = sin_cos(rpy)
    Rx = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    Ry = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    Rz = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return product(Rz, product(Ry, Rx))


def _frames(root: etree._Element, mounting: Array) -> tuple[dict[str, _Frame], dict[str, _Frame]]:
    """Frames of the links and of the joints, by name; a joint's is that at zero, of its parent."""
    below: defaultdict[str, list[etree._Element]] = defaultdict(list)
    for joint in root.findall("joint"):
        below[joint.find("parent").get("link")].append(joint)
    children = {joint.find("child").get("link") for joint in root.findall("joint")}
    (base,) = {link.get("name") for link in root.findall("link")} - children
    links, joints, pending = {base: _Frame(BASE, mounting, np.zeros(3))}, {}, [base]
    while pending:
        parent = pending.pop()
        for joint in below[parent]:
            name, child = joint.get("name"), joint.find("child").get("link")
            joints[name] = frame = links[parent].at(joint)
            fixed = joint.get("type") == "fixed"
            links[child] = frame if fixed else _Frame(name, np.eye(3), np.zeros(3))
            pending.append(child)
    return links, joints


def _bodies(root: etree._Element, links: dict[str, _Frame]) -> dict[str, pin.Inertia]:
    """Inertia of all links that a joint carries, by the joint's name."""
    parts: defaultdict[str, list[tuple[float, Array, Array]]] = defaultdict(list)
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            frame = links[link.get("name")].at(inertial)
            inertia = inertial.find("inertia")
            entries = np.array([float(inertia.get(name, "0")) for name in ENTRIES])
            I = symmetric(*entries)  # noqa: E741
            turned = product(product(frame.R, I), frame.R.T)
            mass = float(inertial.find("mass").get("value"))
            parts[frame.carrier].append((mass, frame.p, (turned + turned.T) / 2.0))
    return {carrier: _welded(welded) for carrier, welded in parts.items()}


def _welded(parts: Iterable[tuple[float, Array, Array]]) -> pin.Inertia:
    """Inertia of bodies welded together, of each: mass, centre of mass, inertia about it."""
    masses, centres, inertias = zip(*parts, strict=True)
    m, first = sum(masses), centres[0]
    moment = sum((mass * (c - first) for mass, c in zip(masses, centres, strict=True)), np.zeros(3))
    centre = first + moment / m if m > 0.0 else first
    total = np.zeros((3, 3))
    for mass, c, I in zip(masses, centres, inertias, strict=True):  # noqa: E741
        total = total + (I + steiner(mass, c - centre))
    return body_of(m, centre, total)
