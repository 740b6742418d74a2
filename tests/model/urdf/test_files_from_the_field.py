"""URDFs as people have them: what other readers take loads with a warning, the rest is named."""

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ftcfa import FtcfaError, load_arm
from ftcfa.errors import CompoundUrdfError

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
    with_upper,
)

DECLARATION = '<?xml version="1.0"?>\n'
TAKEN = {
    "a wrong version": (
        TWO_JOINTS.join(['<?xml version="0.0"?>', ""]),
        "an unknown version of XML in the declaration, line 1",
    ),
    "a blank first line": (
        f"\n{DECLARATION}{TWO_JOINTS}",
        "an XML declaration that is not at the start, line 2",
    ),
    "a comment before the declaration": (
        f"<!-- made by hand -->\n{DECLARATION}{TWO_JOINTS}",
        "an XML declaration that is not at the start, line 2",
    ),
    "an undeclared prefix": (
        TWO_JOINTS.replace(LINKS, f'{LINKS}<gz:sensor gz:rate="1"/>'),
        "a prefix without a declaration, line 1",
    ),
    "undeclared prefixes everywhere": (
        TWO_JOINTS.replace("<robot ", '<robot gz:a="1" ')
        .replace("<link ", '<link gz:a="1" ')
        .replace("<mass ", '<gz:mass value="9"/><mass gz:a="1" ')
        .replace("<axis ", '<gz:axis/><axis gz:a="1" '),
        "a prefix without a declaration, line 1",
    ),
    "dashes in a comment": (
        TWO_JOINTS.replace(LINKS, f"{LINKS}\n<!-- a -- b --->"),
        "a comment that has -- in it, line 2",
    ),
    "a byte of Latin-1": (
        TWO_JOINTS.replace(LINKS, f"{LINKS}\n<!-- Gr\xf6\xdfe -->").encode("latin-1"),
        "bytes that are not UTF-8, line 2; read as Latin-1",
    ),
    "processing instructions": (
        f"<?a b?>{TWO_JOINTS}".replace(LINKS, f"<?a b?>{LINKS}").replace(
            "<inertial>", "<inertial><?a b?>"
        ),
        "a processing instruction, ignored, line 1",
    ),
    "a default namespace": (
        robot(LINKS, SHOULDER, ELBOW, attributes='name="arm" xmlns="urn:x"'),
        "a default namespace (urn:x), ignored",
    ),
    "two inertials": (
        TWO_JOINTS.replace("</inertial>", "</inertial><inertial/>", 1),
        "link 'upper': 2 <inertial>; the first one counts",
    ),
    "limits in degrees": (
        with_elbow(AXIS_Y + '<limit lower="-170" upper="170" effort="100" velocity="1"/>'),
        "joint 'elbow': may turn to 170 rad, 27 turns; degrees?",
    ),
    "millimetres": (
        TWO_JOINTS.replace('<origin xyz="0 0 0.5"/>', '<origin xyz="0 0 500"/>', 1),
        "joint 'shoulder': 500 m from its parent's origin; millimetres?",
    ),
    "friction beyond the limit": (
        with_elbow(AXIS_Y + LIMIT + '<dynamics friction="11"/>'),
        "joint 'elbow': its friction, 11 N m, is not below its limit, 10 N m",
    ),
    "a gyration beyond the link": (
        robot(
            BASE + link("upper") + link("lower", 1e-3, "0 0 0.01", ixx=1e-3, iyy=1e-3, izz=1e-3),
            SHOULDER + ELBOW,
        ),
        "link 'lower': 0.001 kg with a radius of gyration of 1 m, on a link of 0.01 m; "
        "check <mass> and <inertia>",
    ),
}
SILENT = {
    "UTF-16": TWO_JOINTS.encode("utf-16"),
    "declared Latin-1": ('<?xml version="1.0" encoding="iso-8859-1"?>' + TWO_JOINTS).encode(),
}
NAMED = {
    "gzip": (gzip.compress(TWO_JOINTS.encode()), "a gzip archive"),
    "zip": (b"PK\x03\x04 and so on", "a zip archive"),
    "Git LFS": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "Git LFS"),
    "MJCF": (b'<mujoco model="m"><worldbody/></mujoco>', "a MuJoCo model (MJCF)"),
    "SDF": (b'<?xml version="1.0"?><sdf version="1.6"><model/></sdf>', "an SDF model"),
    "HTML": (b"<!DOCTYPE html>\n<html><body><br>404</body></html>", "a web page"),
    "conflict": (
        TWO_JOINTS.replace(LINKS, f"\n<<<<<<< HEAD\n{LINKS}\n=======\n{LINKS}\n>>>>>>> b\n"),
        "conflict markers",
    ),
    "a mesh": (b"solid part\nfacet normal 0 0 1\n", "a mesh (STL)"),
    "JSON": (b'{"robot": 1}', "JSON"),
}
REFUSED = {
    "an underscore": (with_upper(link("upper", "1_0")), '<mass value="1_0">'),
    "a subnormal": (with_upper(link("upper", "1e-320")), '<mass value="1e-320">'),
    "a giant": (with_upper(link("upper", 1, "0 0 1e150")), '<origin xyz="0 0 1e150">'),
}


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str | bytes], Path]:
    def write(content: str | bytes) -> Path:
        file = tmp_path / "arm.urdf"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return file

    return write


@pytest.mark.parametrize("name", TAKEN)
def test_what_others_take_loads_with_a_warning(write, name):
    content, warning = TAKEN[name]
    arm = load_arm(write(content))
    assert arm.n == 2
    assert warning in arm.warnings


@pytest.mark.parametrize("name", SILENT)
def test_what_is_right_loads_without_a_word(write, name):
    arm, plain = load_arm(write(SILENT[name])), load_arm(write(TWO_JOINTS))
    assert arm.warnings == plain.warnings
    np.testing.assert_array_equal(arm.inertias, plain.inertias)


@pytest.mark.parametrize("name", NAMED)
def test_something_else_is_named_as_what_it_is(write, name):
    content, what = NAMED[name]
    assert what in sentence_of(write(content))


@pytest.mark.parametrize("name", REFUSED)
def test_numbers_that_others_read_differently_are_refused(write, name):
    content, got = REFUSED[name]
    assert got in sentence_of(write(content))


def test_all_faults_of_a_file_are_said_at_once(write):
    text = robot(
        BASE + link("upper", "heavy") + link("lower", ixy=0.5),
        joint("shoulder", "base", "upper", "Revolute"),
        joint("elbow", "upper", "lower", "revolute", AXIS_Y + '<limit lower="1" upper="-1"/>'),
    )
    with pytest.raises(CompoundUrdfError) as caught:
        load_arm(write(text))
    sentences = str(caught.value).splitlines()
    for said in (
        '<mass value="heavy">',
        'write "revolute"',
        "lower limit 1 is above upper limit -1",
        "effort limit missing",
        "not positive definite",
    ):
        assert sum(said in sentence for sentence in sentences) == 1, said


def test_all_joints_without_an_effort_limit_are_named_in_one_sentence(write):
    text = TWO_JOINTS.replace('effort="10"', 'effort="0"')
    sentence = sentence_of(write(text))
    assert "joints shoulder, elbow" in sentence
    assert "--effort-limit shoulder=50" in sentence
    arm = load_arm(write(text), effort_limit={"shoulder": 50.0, "elbow": 20.0})
    np.testing.assert_array_equal(arm.effort_limit, [50.0, 20.0])


def test_links_without_inertia_are_said_of_the_whole_arm(write):
    text = robot(BASE, '<link name="upper"/><link name="lower"/>', SHOULDER, ELBOW)
    assert "no moving link has an <inertial>" in sentence_of(write(text))


def test_gravity_beyond_an_effort_limit_is_warned_of(write):
    # Two bodies of 5 and 4 kg, 0.25 m and 0.75 m from the shoulder: (5*0.25 + 4*0.75) 9.81 N m.
    text = robot(
        BASE, link("upper", 5, "0.25 0 0"), link("lower", 4, "0.25 0 0"),
        SHOULDER.replace('effort="10"', 'effort="20"'),
        ELBOW.replace("0 0 0.5", "0.5 0 0").replace('effort="10"', 'effort="20"'),
    )  # fmt: skip
    said = "joint 'shoulder': needs 41.69 N m against gravity at home, its limit is 20 N m"
    assert said in load_arm(write(text)).warnings


def test_equal_efforts_of_three_joints_are_asked_about(write):
    text = robot(LINKS, link("hand"), SHOULDER, ELBOW, joint("wrist", "lower", "hand"))
    assert "all effort limits are 10; placeholders?" in load_arm(write(text)).warnings
    different = load_arm(write(text), effort_limit={"wrist": 9.0})
    assert not any("placeholders" in warning for warning in different.warnings)


def test_too_many_joints_are_refused_before_they_are_parsed(write):
    text = robot("".join(f'<joint name="j{i}"/>' for i in range(1001)))
    assert "1001 <joint> elements, expected at most 1000" in sentence_of(write(text))
    text = robot("".join(f"<joint name='j{i}' type='revolute'/>" for i in range(201)))
    assert "201 joints that move, expected at most 200" in sentence_of(write(text))


def test_an_experiment_names_all_faults_of_its_arm(write, tmp_path):
    from ftcfa import load_experiment

    write(with_upper(link("upper", "heavy")).replace('lower="-1"', 'lower="low"'))
    file = tmp_path / "e.toml"
    file.write_text('duration = 1.0\n[arm]\nrobot = "arm.urdf"\n[reference]\ntype = "Setpoint"\n')
    with pytest.raises(FtcfaError) as caught:
        load_experiment(file)
    assert 'value="heavy"' in str(caught.value)
    assert 'lower="low"' in str(caught.value)
