"""Read the XML of a URDF, keep what dynamics needs and check every attribute of it.

Entities, DTDs and the network are refused.
"""

from pathlib import Path
from textwrap import shorten

import numpy as np
from lxml import etree

from ftcfa.errors import UrdfError

MAX_BYTES = 32 * 2**20
MAX_REASON = 160
"""Length to which a message shortens the text of the XML parser's error."""
SUPPORTED_TYPES = ("revolute", "continuous", "prismatic", "fixed")

_KEPT = {
    "link": ("inertial",),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}
_INERTIA = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1)
_NUMBERS = {  # attributes that must be numbers, and how many
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
    "axis": ("xyz",),
    "parent": ("link",),
    "child": ("link",),
    "mimic": ("joint",),
}


def read_xml(file: Path, text: bytes | None = None) -> etree._Element:
    """The <robot> element of a URDF with only the links, joints and children that dynamics needs.

    Args:
        file: Path of the file, or its name in messages if ``text`` is given.
        text: Content of the file; read from it if None.

    Raises:
        UrdfError: If the file cannot be read, is not a URDF, or has a missing or wrong attribute.
    """
    root = _cut_down(_parse(file, _read_bytes(file) if text is None else text))
    _check_elements(file, root)
    return root


def _read_bytes(file: Path) -> bytes:
    try:
        with file.expanduser().open("rb") as stream:
            text = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError, RuntimeError) as error:  # a null byte, an unknown ~user
        reason = (getattr(error, "strerror", None) or str(error)).lower().rstrip(".")
        remedy = "check the path and its permissions"
        raise UrdfError(str(file), reason, "a readable URDF file", remedy) from error
    if len(text) > MAX_BYTES:
        got = f"more than {MAX_BYTES // 2**20} MiB"
        remedy = "give the URDF itself, not a mesh or an archive"
        raise UrdfError(str(file), got, "the text of a URDF", remedy)
    return text


def _parse(file: Path, text: bytes) -> etree._Element:
    parser = etree.XMLParser(
        resolve_entities=False, load_dtd=False, no_network=True, remove_comments=True
    )
    try:
        root = etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        got = f"not XML ({shorten(error.msg, MAX_REASON)})"
        remedy = "run `check_urdf` or export the file again"
        raise UrdfError(str(file), got, "a URDF", remedy) from error
    if root.getroottree().docinfo.doctype:
        got = "a DOCTYPE, which could expand or include entities"
        remedy = "delete the <!DOCTYPE ...> and replace its entities by their values"
        raise UrdfError(str(file), got, "plain XML", remedy)
    if root.tag != "robot":
        remedy = "convert the file to URDF, without a default namespace"
        raise UrdfError(str(file), f"the root element is <{root.tag}>", "<robot>", remedy)
    if any("ros.org/wiki/xacro" in str(e.tag) for e in root.iter()):
        remedy = "run `xacro FILE > arm.urdf` first"
        raise UrdfError(str(file), "xacro elements", "plain URDF", remedy)
    return root


def _cut_down(root: etree._Element) -> etree._Element:
    """Copy of links, joints and those children that dynamics needs, without extra white space."""
    cut = etree.Element("robot", name=root.get("name", "robot"))
    for element in root:
        if element.tag in _KEPT:
            kept = etree.SubElement(cut, element.tag, dict(element.attrib))
            kept.extend(child for tag in _KEPT[element.tag] for child in element.findall(tag)[:1])
    for element in cut.iter(etree.Element):
        for attribute, value in element.attrib.items():
            element.set(attribute, " ".join(value.split()))
    return cut


def _check_elements(file: Path, root: etree._Element) -> None:
    """Refuse missing or malformed names, references and numbers.

    Numbers are rewritten in plain form, so that every other parser reads the checked values.
    """
    seen: set[tuple[str, str]] = set()
    for element in root:
        name = element.get("name")
        if not name:
            got, expected = f"a <{element.tag}> without a name", f'<{element.tag} name="...">'
            raise UrdfError(str(file), got, expected)
        subject = f"{file}: {element.tag} '{name}'"
        if (element.tag, name) in seen:
            raise UrdfError(subject, "the name occurs twice", "unique names", "rename one of them")
        seen.add((element.tag, name))
        if element.tag == "joint":
            _check_joint_element(subject, element)
        elif (inertial := element.find("inertial")) is not None:
            remedy = "add it, or delete the <inertial> if the link is massless"
            for tag in ("mass", "inertia"):
                if inertial.find(tag) is None:
                    got = f"<inertial> without <{tag}>"
                    raise UrdfError(subject, got, "<mass> and <inertia>", remedy)
        for part in element.iter(*_NUMBERS, *_REQUIRED):
            _check_attributes(subject, part)


def _check_joint_element(subject: str, joint: etree._Element) -> None:
    kind = joint.get("type")
    if kind not in SUPPORTED_TYPES:
        got = f"joint type '{kind}' is not supported"
        expected = f"one of {', '.join(SUPPORTED_TYPES)}"
        remedy = "model it with single-axis joints, or make it fixed"
        raise UrdfError(subject, got, expected, remedy)
    for tag in ("parent", "child"):
        if joint.find(tag) is None:
            got, expected = f'no <{tag} link="...">', "a parent and a child link"
            raise UrdfError(subject, got, expected, f"add the <{tag}>")


def _check_attributes(subject: str, part: etree._Element) -> None:
    for attribute in _REQUIRED.get(part.tag, ()):
        if part.get(attribute) is None:
            got = f"<{part.tag}> without '{attribute}'"
            raise UrdfError(subject, got, f'<{part.tag} {attribute}="...">')
    for attribute, count in _NUMBERS.get(part.tag, {}).items():
        text = part.get(attribute)
        if text is None:
            continue
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            numbers = []
        if len(numbers) != count or not np.all(np.isfinite(numbers)):
            got = f'<{part.tag} {attribute}="{text[:40]}">'
            expected = "a finite number" if count == 1 else f"{count} finite numbers"
            raise UrdfError(subject, got, expected, "correct it, or delete it if it is optional")
        part.set(attribute, " ".join(map(repr, numbers)))
