"""Malicious or damaged files are refused in bounded memory, and no other file is opened."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

from ftcfa import FtcfaError, load_arm
from ftcfa.model.urdf.text import MAX_ELEMENTS

from ..refusal import sentence_of
from ..texts import (
    AXIS_Y,
    BASE,
    ELBOW,
    LIMIT,
    LINKS,
    SHOULDER,
    TWO_JOINTS,
    joint,
    link,
    robot,
    with_elbow,
)

MEMORY = 100 * 2**20
"""Three times the longest text that is read [bytes]; the entities expand to 20 GB."""

ENTITIES = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10}">' for i in range(1, 11))
LAUGHS = f'<!DOCTYPE robot [<!ENTITY e0 "ha">{ENTITIES}]>'


@pytest.mark.parametrize(
    "text",
    [
        LAUGHS + robot("&e10;", LINKS, SHOULDER, ELBOW),
        LAUGHS + robot(LINKS, SHOULDER, ELBOW, attributes='name="&e10;"'),
        LAUGHS + TWO_JOINTS,
    ],
    ids=["in the text", "in an attribute", "unused"],
)
def test_expanding_entities_are_refused(urdf: Callable[..., Path], text: str) -> None:
    assert "entit" in sentence_of(urdf(text))


DOCTYPE = (
    " a DOCTYPE, which could expand or include entities, expected plain XML; "
    "delete the <!DOCTYPE ...> and replace its entities by their values"
)


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE robot [<!ENTITY secret SYSTEM "{uri}">]>',
        '<!DOCTYPE robot [<!ENTITY % secret SYSTEM "{uri}"> %secret;]>',
        '<!DOCTYPE robot SYSTEM "{uri}">',
    ],
    ids=["entity", "parameter entity", "external DTD"],
)
def test_nothing_is_read_that_a_doctype_names(
    urdf: Callable[..., Path], tmp_path: Path, doctype: str
) -> None:
    secret = tmp_path / "secret"
    secret.write_text("<broken")  # whoever reads it complains of its syntax
    use = "&secret;" if "ENTITY secret" in doctype else ""
    text = doctype.format(uri=secret.as_uri()) + robot(use, LINKS, SHOULDER, ELBOW)
    reader = etree.XMLParser(resolve_entities=True, load_dtd=True, no_network=False)
    with pytest.raises(etree.XMLSyntaxError):
        etree.fromstring(text.encode(), reader)
    file = urdf(text)
    assert sentence_of(file) == f"{file}:{DOCTYPE}"


@pytest.mark.parametrize("size", [20 * 2**20, 100 * 2**20])
def test_megabytes_of_garbage_are_refused_in_bounded_memory(tmp_path: Path, size: int) -> None:
    file = tmp_path / "garbage.urdf"
    with file.open("wb") as stream:
        stream.write(np.random.default_rng(0).bytes(2**20))
        stream.truncate(size)
    tracemalloc.start()
    sentence = sentence_of(file)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < MEMORY
    if size > 32 * 2**20:
        assert sentence == (
            f"{file}: more than 32 MiB, expected a readable URDF file; "
            "give the path of a URDF, not of a mesh or an archive"
        )
    else:
        assert sentence.startswith(f"{file}: not XML (")


def test_an_endless_file_is_not_read_to_its_end() -> None:
    assert sentence_of("/dev/zero").startswith("/dev/zero: more than 32 MiB")


def test_a_tree_too_deep_for_parsers_is_refused(urdf: Callable[..., Path]) -> None:
    count = 5 * MAX_ELEMENTS["link"]  # in a row, this overflows the stack of a recursive parser
    links = [f'<link name="l{i}"/>' for i in range(count)]
    joints = [joint(f"j{i}", f"l{i}", f"l{i + 1}", "fixed") for i in range(count - 1)]
    file = urdf(robot(*links, *joints))
    most = MAX_ELEMENTS["link"]
    reason = f"{count} <link> elements, expected at most {most}; merge links fixed together"
    assert sentence_of(file) == f"{file}: {reason}"


def test_a_long_chain_of_mimics_is_followed(urdf: Callable[..., Path]) -> None:
    count = 120
    links = [BASE, *(link(f"l{i}") for i in range(count))]
    joints = [joint("j0", "base", "l0")]
    for i in range(1, count):
        mimic = AXIS_Y + LIMIT + f'<mimic joint="j{i - 1}"/>'
        joints.append(joint(f"j{i}", f"l{i - 1}", f"l{i}", "revolute", mimic))
    assert load_arm(urdf(robot(*links, *joints))).joint_names == ("j0",)


def assert_loads_or_gives_sentences(file: Path) -> None:
    try:
        arm = load_arm(file)
    except FtcfaError as error:
        sentences = str(error).splitlines()
    else:
        assert np.linalg.eigvalsh(arm.mass_matrix(arm.home))[0] > 0
        return
    assert all(sentence.startswith(f"{file}: ") for sentence in sentences)


VALUES = ("", "0", "-1", "nan", "inf", "1 2 3", "0 0 0", "abc", "1e-5", "upper", "elbow", "fixed")
ODD_VALUES = st.sampled_from(VALUES) | st.text(st.characters(codec="utf-8", categories="LNP"))


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_a_damaged_urdf_loads_or_gives_sentences(
    urdf: Callable[..., Path], data: st.DataObject
) -> None:
    root = etree.fromstring(with_elbow(AXIS_Y + LIMIT + '<mimic joint="shoulder"/>'))
    for _ in range(data.draw(st.integers(1, 3))):
        element = data.draw(st.sampled_from(list(root.iter())[1:] or [root]))
        match data.draw(st.sampled_from(["value", "no attribute", "gone", "twice"])):
            case "value" if element.attrib:
                element.set(data.draw(st.sampled_from(element.keys())), data.draw(ODD_VALUES))
            case "no attribute" if element.attrib:
                del element.attrib[data.draw(st.sampled_from(element.keys()))]
            case "gone" if element is not root:
                element.getparent().remove(element)
            case "twice" if element is not root:
                element.addnext(etree.fromstring(etree.tostring(element)))
    file = urdf(etree.tostring(root))
    assert_loads_or_gives_sentences(file)


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(place=st.integers(0, len(TWO_JOINTS)), rubbish=st.binary(min_size=1, max_size=8))
def test_damaged_bytes_load_or_give_sentences(
    urdf: Callable[..., Path], place: int, rubbish: bytes
) -> None:
    text = TWO_JOINTS.encode()
    file = urdf(text[:place] + rubbish + text[place:])
    assert_loads_or_gives_sentences(file)
