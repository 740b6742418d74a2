"""Keep what dynamics needs of a URDF's XML and check every attribute of it."""

import re
from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from ftcfa.errors import UrdfError

SUPPORTED_TYPES = ("revolute", "continuous", "prismatic", "fixed")
LARGEST, SMALLEST = 1e100, 1e-100
"""Sizes of numbers whose squares and quotients a double still holds."""

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
    "rotor_inertia": {"value": 1},
    "gear_ratio": {"value": 1},
}
_ROTOR = ("rotor_inertia", "gear_ratio")
_REQUIRED = {  # attributes that may not be missing where the element occurs
    "mass": ("value",),
    "inertia": tuple(_INERTIA),
    "axis": ("xyz",),
    "mimic": ("joint",),
}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
"""What exporters write in a <limit> for "none"."""


def cut_down(root: etree._Element) -> tuple[etree._Element, list[str]]:
    """Copy of links, joints and those children that dynamics needs, without extra white space.

    Of several children of a kind the first is kept, and a second <inertial> is warned of.
    """
    cut, warnings = etree.Element("robot", name=root.get("name", "robot")), []
    for element in root.iterchildren(*_KEPT):
        kept = etree.SubElement(cut, element.tag, dict(element.attrib))
        for tag in _KEPT[element.tag]:
            children = element.findall(tag)
            kept.extend(children[:1])
            if tag == "inertial" and len(children) > 1:
                name = element.get("name")
                warnings.append(f"link '{name}': {len(children)} <inertial>; the first one counts")
    cut.extend(_rotors(root))
    for element in [e for e in cut.iter(etree.Element) if ":" in e.tag]:
        element.getparent().remove(element)  # an extension: no other parser reads it
    for element in cut.iter(etree.Element):
        for attribute, value in element.attrib.items():
            element.set(attribute, " ".join(value.split()))
    return cut, warnings


def _rotors(root: etree._Element) -> Iterator[etree._Element]:
    """<transmission joint="..."> with <rotor_inertia> and <gear_ratio>, from Drake's elements."""
    for transmission in root.iterchildren("transmission"):
        parts = {e.tag.rpartition("}")[2].rpartition(":")[2]: e for e in transmission.iter()}
        joint = parts.get("joint")
        name = None if joint is None else joint.get("name") or joint.text
        if name is not None and "rotor_inertia" in parts:
            rotor = etree.Element("transmission", joint=name, name=name)
            for tag in _ROTOR:
                value = parts[tag].get("value", "") if tag in parts else "1"
                etree.SubElement(rotor, tag, value=value)
            yield rotor


def tree_faults(file: Path, root: etree._Element) -> Iterator[UrdfError]:
    """Missing and repeated names and references, without which there is no tree."""
    seen: set[tuple[str, str]] = set()
    for element in root.iterchildren(*_KEPT):
        name = element.get("name")
        if not name:
            got, expected = f"a <{element.tag}> without a name", f'<{element.tag} name="...">'
            yield UrdfError(str(file), got, expected)
            continue
        subject = f"{file}: {element.tag} '{name}'"
        if (element.tag, name) in seen:
            yield UrdfError(subject, "the name occurs twice", "unique names", "rename one of them")
        seen.add((element.tag, name))
        for tag in ("parent", "child") if element.tag == "joint" else ():
            end = element.find(tag)
            if end is None:
                got, expected = f'no <{tag} link="...">', "a parent and a child link"
                yield UrdfError(subject, got, expected, f"add the <{tag}>")
            elif end.get("link") is None:
                got = f"<{tag}> without 'link'"
                yield UrdfError(subject, got, f'<{tag} link="...">')


def element_faults(file: Path, root: etree._Element) -> Iterator[UrdfError]:
    """Wrong types, and wrong and missing attributes, of links and joints.

    What is wrong is taken out or made harmless, so that the rest can be checked as well. Numbers
    are rewritten in plain form, so that every other parser reads the checked values.
    """
    for element in root:
        subject = f"{file}: {element.tag} '{element.get('name')}'"
        if element.tag == "joint" and element.get("type") not in SUPPORTED_TYPES:
            yield _unsupported(subject, element.get("type"))
            element.set("type", "fixed")
        for child in list(element):
            faults = [*_missing_parts(subject, child)]
            for part in child.iter(*_NUMBERS, *_REQUIRED):
                faults += _attribute_faults(subject, part)
            if faults:
                element.remove(child)
            yield from faults


def _unsupported(subject: str, kind: str | None) -> UrdfError:
    got = f"joint type '{kind}' is not supported"
    expected = f"one of {', '.join(SUPPORTED_TYPES)}"
    right = (kind or "").lower()
    remedy = "model it with single-axis joints, or make it fixed"
    return UrdfError(
        subject, got, expected, f'write "{right}"' if right in SUPPORTED_TYPES else remedy
    )


def _missing_parts(subject: str, child: etree._Element) -> Iterator[UrdfError]:
    """The parts that an <inertial> lacks."""
    if child.tag == "inertial":
        remedy = "add it, or delete the <inertial> if the link is massless"
        for tag in ("mass", "inertia"):
            if child.find(tag) is None:
                got = f"<inertial> without <{tag}>"
                yield UrdfError(subject, got, "<mass> and <inertia>", remedy)


def _attribute_faults(subject: str, part: etree._Element) -> Iterator[UrdfError]:
    for attribute in _REQUIRED.get(part.tag, ()):
        if part.get(attribute) is None:
            got = f"<{part.tag}> without '{attribute}'"
            yield UrdfError(subject, got, f'<{part.tag} {attribute}="...">')
    for attribute, count in _NUMBERS.get(part.tag, {}).items():
        text = part.get(attribute)
        if text is None:
            continue
        words, got = text.split(), f'<{part.tag} {attribute}="{text[:40]}">'
        numbers = [_number(word, part.tag == "limit") for word in words]
        if len(numbers) != count or None in numbers:
            expected = "a finite number" if count == 1 else f"{count} finite numbers"
            remedy = "correct it, or delete it if it is optional"
            yield UrdfError(subject, got, expected, remedy)
        elif part.tag != "limit" and not all(map(_has_usual_size, numbers)):
            expected = f"zero, or sizes from {SMALLEST:g} to {LARGEST:g}"
            yield UrdfError(subject, got, expected, "a double cannot compute with it")
        else:
            part.set(attribute, " ".join(map(repr, numbers)))


def _number(word: str, may_be_infinite: bool) -> float | None:
    """The number that a word is in every parser; None if it is none."""
    infinite = may_be_infinite and _INFINITE.fullmatch(word)
    return float(word) if infinite or _NUMBER.fullmatch(word) else None


def _has_usual_size(number: float | None) -> bool:
    return number is not None and (number == 0.0 or SMALLEST <= abs(number) <= LARGEST)
