"""From the bytes of a file to the XML tree of a URDF, as forgiving as other readers of URDF.

What others take is taken with a warning; what is no URDF is named as what it is. Entities, DTDs and
the network are refused.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import shorten

from lxml import etree

from ftcfa.errors import FtcfaError, UrdfError
from ftcfa.files import decoded, read_bounded

MAX_BYTES = 32 * 2**20
MAX_ELEMENTS = {"link": 1000, "joint": 1000}
"""Largest numbers of elements: parsers recurse down the tree and overflow their stacks."""
MAX_MOVING = 200
"""Largest number of joints that move: the work on M grows with its cube."""
MAX_REASON = 160
"""Length to which a message shortens the text of the XML parser's error."""
TOLERATED = {
    "ERR_UNKNOWN_VERSION": "an unknown version of XML in the declaration",
    "WAR_UNKNOWN_VERSION": "an unknown version of XML in the declaration",
    "ERR_RESERVED_XML_NAME": "an XML declaration that is not at the start",
    "ERR_UNSUPPORTED_ENCODING": "an unknown encoding in the declaration, read as UTF-8",
    "NS_ERR_UNDEFINED_NAMESPACE": "a prefix without a declaration",
}
"""Errors of libxml2 that other readers of URDF do not look for, as warnings."""
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_MOVING = re.compile(r"""\stype\s*=\s*["']\s*(?:revolute|continuous|prismatic)""")
_CONFLICT = re.compile(r"^(<<<<<<<|>>>>>>>) ", re.MULTILINE)
_INSTRUCTION = re.compile(r"<\?(?!xml\b)", re.IGNORECASE)
_LATIN = re.compile(rb"encoding=[\"'](iso-8859-1|latin-?1|windows-1252)", re.IGNORECASE)
_XACRO = re.compile(
    r"""<xacro:|=\s*["'][^"'<>]*\$(\{[^}]*\}|\((find|arg|env|optenv|dirname|eval)\b)"""
)
_BY_START = {
    b"\x1f\x8b": ("a gzip archive", "unpack it with `gunzip`"),
    b"PK\x03\x04": ("a zip archive", "unpack it and give the URDF inside"),
    b"version https://git-lfs": ("a pointer of Git LFS", "run `git lfs pull` to get the file"),
    b"solid ": ("a mesh (STL)", "give the URDF that names it"),
    b"{": ("JSON", "give a URDF"),
}
"""What a file is by its first bytes, and what to do."""
_BY_ROOT = {
    "mujoco": ("a MuJoCo model (MJCF)", "convert it to URDF, or give the URDF it was made from"),
    "sdf": ("an SDF model", "convert it to URDF, or give the URDF it was made from"),
    "html": ("a web page", "download the file itself (on GitHub: `Raw`)"),
    "COLLADA": ("a mesh (Collada)", "give the URDF that names it"),
    "package": ("a ROS package manifest", "give the URDF in the package"),
    "launch": ("a ROS launch file", "give the URDF that it loads"),
}
"""What a file is by its root element, and what to do."""


def read_bytes(file: Path) -> bytes:
    """Content of a file of at most MAX_BYTES.

    Raises:
        UrdfError: If it cannot be read, or is larger.
    """
    try:
        return read_bounded(file, MAX_BYTES)
    except FtcfaError as error:
        remedy = error.remedy or "give the path of a URDF, not of a mesh or an archive"
        raise UrdfError(str(file), error.got, "a readable URDF file", remedy) from error


def parse(file: Path, content: bytes) -> tuple[etree._Element, list[str]]:
    """The <robot> element of a file's content, and warnings about its XML.

    Raises:
        UrdfError: If the content is something else, is too large, or is XML that other readers of
            URDF refuse too.
    """
    if not content.strip():
        raise UrdfError(str(file), "an empty file", "a URDF", "export it again")
    for start, (what, remedy) in _BY_START.items():
        if content.lstrip().startswith(start):
            raise UrdfError(str(file), f"this is {what}", "a URDF", remedy)
    text, odd = decoded(content)
    warnings = [*_oddities(text)]
    if odd is not None and not _LATIN.search(content[:200]):
        line = content.count(b"\n", 0, odd) + 1
        warnings.insert(0, f"bytes that are not UTF-8, line {line}; read as Latin-1")
    text = _COMMENT.sub(_lines, text)
    _refuse_by_counting(file, text)
    root, errors = _tree(text)
    fatal = next((_reason(error) for error in errors if error.type_name not in TOLERATED), "")
    if root is None or fatal or _name_of(root) in _BY_ROOT:
        raise _no_urdf(file, text, root, fatal)
    if root.getroottree().docinfo.doctype:
        got = "a DOCTYPE, which could expand or include entities"
        remedy = "delete the <!DOCTYPE ...> and replace its entities by their values"
        raise UrdfError(str(file), got, "plain XML", remedy)
    first = {error.type_name: error.line for error in reversed(errors)}
    warnings += [f"{TOLERATED[kind]}, line {line}" for kind, line in first.items()]
    _drop_undeclared_prefixes(root)
    warnings += _without_default_namespace(root)
    if root.tag != "robot":
        got, remedy = f"the root element is <{root.tag}>", "convert the file to URDF"
        raise UrdfError(str(file), got, "<robot>", remedy)
    return root, warnings


def _oddities(text: str) -> Iterator[str]:
    """Warnings about what is taken out before the XML is read."""
    comments = (c.start() for c in _COMMENT.finditer(text) if "--" in f"{c[0][4:-3]}-")
    instructions = (found.start() for found in _INSTRUCTION.finditer(text))
    for what, places in (
        ("a processing instruction, ignored", instructions),
        ("a comment that has -- in it", comments),
    ):
        place = next(places, None)
        if place is not None:
            yield f"{what}, line {text.count(chr(10), 0, place) + 1}"


def _no_urdf(file: Path, text: str, root: etree._Element | None, fatal: str) -> UrdfError:
    """The error for a text that is something else, or broken."""
    if root is not None and _name_of(root) in _BY_ROOT:
        what, remedy = _BY_ROOT[_name_of(root)]
        return UrdfError(str(file), f"this is {what}", "a URDF", remedy)
    if _CONFLICT.search(text):
        got, remedy = "conflict markers of a version control", "resolve the conflict in the file"
        return UrdfError(str(file), got, "a URDF", remedy)
    remedy = "run `check_urdf` or export the file again"
    return UrdfError(str(file), f"not XML ({fatal or 'no element'})", "a URDF", remedy)


def is_xacro(content: bytes) -> bool:
    """Whether a file has elements or expressions of xacro."""
    return bool(_XACRO.search(_COMMENT.sub("", decoded(content)[0])))


def _lines(comment: re.Match[str]) -> str:
    """The line breaks of a comment, so that messages count lines as an editor does."""
    return "\n" * comment[0].count("\n")


def _refuse_by_counting(file: Path, text: str) -> None:
    """Raise UrdfError if a text has more elements than any arm needs."""
    for tag, most in MAX_ELEMENTS.items():
        count = len(re.findall(rf"<{tag}\s", text))
        if count > most:
            got, remedy = f"{count} <{tag}> elements", "merge links fixed together"
            raise UrdfError(str(file), got, f"at most {most}", remedy)
    moving = len(_MOVING.findall(text))
    if moving > MAX_MOVING:
        got, remedy = f"{moving} joints that move", "split the robot, or make joints fixed"
        raise UrdfError(str(file), got, f"at most {MAX_MOVING}", remedy)


def _tree(text: str) -> tuple[etree._Element | None, list[etree._LogEntry]]:
    """The tree that libxml2 makes of a text, and all that it found wrong."""
    parser = etree.XMLParser(
        encoding="utf-8", recover=True, resolve_entities=False, load_dtd=False, no_network=True,
        remove_comments=True, remove_pis=True,
    )  # fmt: skip
    try:
        root = etree.fromstring(text.encode("utf-8", errors="replace"), parser)
    except etree.XMLSyntaxError as error:
        return None, list(error.error_log)
    return root, list(parser.error_log)


def _reason(error: etree._LogEntry) -> str:
    """What libxml2 found wrong, and where."""
    return f"{shorten(error.message, MAX_REASON)}, line {error.line}, column {error.column}"


def _name_of(element: etree._Element) -> str:
    """Name of an element without its namespace."""
    return element.tag.rpartition("}")[2]


def _drop_undeclared_prefixes(root: etree._Element) -> None:
    """Take out attributes whose prefix is not declared: lxml cannot write them again."""
    for element in root.iter(etree.Element):
        for name in [name for name in element.attrib if ":" in name and name[0] != "{"]:
            del element.attrib[name]


def _without_default_namespace(root: etree._Element) -> Iterator[str]:
    """Strip the namespace of the root from every element, and warn of it."""
    namespace = root.nsmap.get(None)
    if namespace is None:
        return
    for element in root.iter(etree.Element):
        element.tag = element.tag.removeprefix(f"{{{namespace}}}")
    yield f"a default namespace ({namespace}), ignored"
