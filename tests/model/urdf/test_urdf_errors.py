"""Every unusable URDF gets one sentence that names file, element and remedy; never a traceback."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from ftcfa import FtcfaError, UnknownNameError, load_arm

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

FINITE = "correct it, or delete it if it is optional"
TYPES = "expected one of revolute, continuous, prismatic, fixed"
SINGLE_AXIS = "model it with single-axis joints, or make it fixed"
NO_EFFORT = (
    " joint 'elbow': effort limit missing, zero or infinite, expected a positive effort; "
    'write <limit effort="..."> or pass effort_limit, one number or {"elbow": value} '
    "(on the command line --effort-limit 50 or --effort-limit elbow=50)"
)
PROJECT = 'or pass repair="project" (--repair): M changes by'
NO_JOINT = " nothing in it can move, expected a joint that is not fixed; export it again"
SINGULAR = (
    "expected links with mass and inertia beyond every joint; "
    "give the links it moves an <inertial>, or lock the joint"
)
NOT_XML = "expected a URDF; run `check_urdf` or export the file again"

BAD = {
    # the file as a whole
    "not XML": (
        "hello",
        f" not XML (Start tag expected, '<' not found, line 1, column 1), {NOT_XML}",
    ),
    "empty": ("", " an empty file, expected a URDF; export it again"),
    "another format": (
        '<sdf version="1.6"/>',
        " this is an SDF model, expected a URDF; "
        "convert it to URDF, or give the URDF it was made from",
    ),
    "another root": (
        "<machine/>",
        " the root element is <machine>, expected <robot>; convert the file to URDF",
    ),
    "no links": (robot(), " no links, expected links and joints in <robot>; export it again"),
    "a single link": (robot(BASE), NO_JOINT),
    "everything fixed": (
        robot(BASE, link("upper"), joint("shoulder", "base", "upper", "fixed")),
        NO_JOINT,
    ),
    # the tree
    "two roots": (
        robot(LINKS, '<link name="lonely"/>', SHOULDER, ELBOW),
        " 2 root links (base, lonely), expected exactly one link without a parent; "
        "connect them with fixed joints",
    ),
    "a loop": (
        robot(LINKS, SHOULDER, ELBOW, joint("back", "lower", "base")),
        " carried by a loop of joints, not by the root link: 'base', 'lower', 'upper', "
        "expected a tree; remove one joint of the loop",
    ),
    "a loop beside the tree": (
        robot(
            LINKS,
            '<link name="x"/><link name="y"/>',
            SHOULDER,
            ELBOW,
            joint("there", "x", "y"),
            joint("back", "y", "x"),
        ),
        " carried by a loop of joints, not by the root link: 'x', 'y', "
        "expected a tree; remove one joint of the loop",
    ),
    "a link with two parents": (
        robot(LINKS, SHOULDER, ELBOW, joint("strut", "base", "lower")),
        " joint 'strut': link 'lower' is also the child of joint 'elbow', "
        "expected a tree: one parent for each link; remove one joint of the kinematic loop",
    ),
    "a link that does not exist": (
        robot(LINKS, SHOULDER, ELBOW, joint("wrist", "lower", "hand")),
        " joint 'wrist': link 'hand' does not exist, expected a link of this file; "
        "add it, or delete the joint",
    ),
    "duplicate link": (
        robot(LINKS, link("upper"), SHOULDER, ELBOW),
        " link 'upper': the name occurs twice, expected unique names; rename one of them",
    ),
    "duplicate joint": (
        robot(LINKS, SHOULDER, joint("shoulder", "upper", "lower")),
        " joint 'shoulder': the name occurs twice, expected unique names; rename one of them",
    ),
    "link without a name": (
        robot(LINKS, "<link/>", SHOULDER, ELBOW),
        ' a <link> without a name, expected <link name="...">',
    ),
    "joint without a parent": (
        robot(LINKS, SHOULDER, '<joint name="elbow" type="fixed"><child link="lower"/></joint>'),
        " joint 'elbow': no <parent link=\"...\">, expected a parent and a child link; "
        "add the <parent>",
    ),
    "parent without a link": (
        robot(LINKS, SHOULDER, ELBOW.replace('<parent link="upper"/>', "<parent/>")),
        " joint 'elbow': <parent> without 'link', expected <parent link=\"...\">",
    ),
    # joints
    **{
        f"{kind} joint": (
            with_elbow(AXIS_Y + LIMIT, kind),
            f" joint 'elbow': joint type '{kind}' is not supported, {TYPES}; {SINGLE_AXIS}",
        )
        for kind in ("floating", "planar", "spherical", "")
    },
    "Revolute joint": (
        with_elbow(AXIS_Y + LIMIT, "Revolute"),
        f" joint 'elbow': joint type 'Revolute' is not supported, {TYPES}; write \"revolute\"",
    ),
    "zero axis": (
        with_elbow(f'<axis xyz="0 0 0"/>{LIMIT}'),
        " joint 'elbow': the axis is zero, expected a direction; "
        'write one, such as <axis xyz="0 0 1"/>',
    ),
    "axis without a direction": (
        with_elbow(f"<axis/>{LIMIT}"),
        " joint 'elbow': <axis> without 'xyz', expected <axis xyz=\"...\">",
    ),
    "short axis": (
        with_elbow(f'<axis xyz="0 1"/>{LIMIT}'),
        f" joint 'elbow': <axis xyz=\"0 1\">, expected 3 finite numbers; {FINITE}",
    ),
    "lower above upper": (
        with_elbow('<limit lower="1" upper="-1" effort="1"/>'),
        " joint 'elbow': lower limit 1 is above upper limit -1, "
        "expected lower <= upper (a missing limit is 0); correct its <limit>",
    ),
    "no room between the limits": (
        with_elbow('<limit lower="0.5" upper="0.5" effort="1"/>'),
        " joint 'elbow': lower and upper limit are both 0.5, expected a range to move in; "
        "widen it, or lock the joint",
    ),
    "no effort": (with_elbow('<limit lower="-1" upper="1"/>'), NO_EFFORT),
    "no limit": (with_elbow(AXIS_Y), NO_EFFORT),
    "zero effort": (with_elbow('<limit lower="-1" upper="1" effort="0"/>'), NO_EFFORT),
    "negative effort": (
        with_elbow('<limit lower="-1" upper="1" effort="-3"/>'),
        " joint 'elbow': effort is -3, expected effort >= 0; remove the minus sign",
    ),
    "infinite effort": (with_elbow('<limit lower="-1" upper="1" effort="inf"/>'), NO_EFFORT),
    "negative damping": (
        with_elbow(LIMIT + '<dynamics damping="-1"/>'),
        " joint 'elbow': damping is -1, expected damping >= 0; remove the minus sign",
    ),
    "mimic of nothing": (
        with_elbow(LIMIT + '<mimic joint="wrist"/>'),
        " joint 'elbow': mimics 'wrist', which does not exist, "
        "expected a joint of this file (shoulder, elbow); correct its <mimic>",
    ),
    "mimic of itself": (
        with_elbow(LIMIT + '<mimic joint="elbow"/>'),
        " joint 'elbow': mimics itself, expected mimic joints that lead to an independent joint; "
        "correct its <mimic>",
    ),
    "mimic loop": (
        robot(
            LINKS,
            joint("shoulder", "base", "upper", "revolute", LIMIT + '<mimic joint="elbow"/>'),
            joint("elbow", "upper", "lower", "revolute", LIMIT + '<mimic joint="shoulder"/>'),
        ),
        " joint 'shoulder': mimics itself through 'elbow', "
        "expected mimic joints that lead to an independent joint; correct its <mimic>",
    ),
    # bodies
    "negative mass": (
        with_upper(link("upper", -1)),
        " link 'upper': mass is -1 kg, expected a mass >= 0; correct <mass>",
    ),
    "indefinite inertia": (
        with_upper(link("upper", ixy=0.5)),
        " link 'upper': inertia is not positive definite (smallest eigenvalue -0.4 kg m^2), "
        "expected principal moments >= 0; correct <inertia>, "
        f"{PROJECT} 0.23 at home and 0.28 at worst, of sqrt(M_ii M_jj)",
    ),
    "triangle inequality": (
        with_upper(link("upper", izz=0.9)),
        " link 'upper': inertia violates the triangle inequality (0.1 + 0.1 < 0.9 kg m^2), "
        "expected a tensor that a real body can have; recompute <inertia> from the geometry, "
        f"{PROJECT} 0.32 at home and 0.38 at worst, of sqrt(M_ii M_jj)",
    ),
    "mass in digits of another script": (
        with_upper(link("upper", "\uff11")),
        f" link 'upper': <mass value=\"\uff11\">, expected a finite number; {FINITE}",
    ),
    "mass is not a number": (
        with_upper(link("upper", "nan")),
        f" link 'upper': <mass value=\"nan\">, expected a finite number; {FINITE}",
    ),
    "mass is a word": (
        with_upper(link("upper", "abc")),
        f" link 'upper': <mass value=\"abc\">, expected a finite number; {FINITE}",
    ),
    "decimal comma": (
        with_upper(link("upper", ixx="0,1")),
        f" link 'upper': <inertia ixx=\"0,1\">, expected a finite number; {FINITE}",
    ),
    "inertial without mass": (
        with_upper(link("upper").replace('<mass value="1"/>', "")),
        " link 'upper': <inertial> without <mass>, expected <mass> and <inertia>; "
        "add it, or delete the <inertial> if the link is massless",
    ),
    "inertia without a component": (
        with_upper(link("upper").replace('iyz="0"', "")),
        " link 'upper': <inertia> without 'iyz', expected <inertia iyz=\"...\">",
    ),
    "massless moving link": (
        robot(BASE, link("upper"), '<link name="lower"/>', SHOULDER, ELBOW),
        f" joint 'elbow': the mass matrix is singular at q = [0.0, 0.0], {SINGULAR}",
    ),
}


@pytest.mark.parametrize(("text", "sentence"), BAD.values(), ids=BAD.keys())
def test_a_bad_urdf_is_refused_in_one_sentence(
    urdf: Callable[..., Path], text: str, sentence: str
) -> None:
    file = urdf(text)
    assert sentence_of(file) == f"{file}:{sentence}"


def test_two_joints_that_turn_the_same_body_alike(urdf: Callable[..., Path]) -> None:
    elbow = ELBOW.replace("0 0 0.5", "0 0 0")
    file = urdf(robot(BASE, '<link name="upper"/>', link("lower"), SHOULDER, elbow))
    got = "the mass matrix is singular at q = [0.0, 0.0]"
    assert re.fullmatch(
        rf"{re.escape(str(file))}: joint '(shoulder|elbow)': {re.escape(f'{got}, {SINGULAR}')}",
        sentence_of(file),
    )


def test_a_file_that_does_not_exist(tmp_path: Path) -> None:
    file = tmp_path / "missing.urdf"
    reason = "no such file or directory, expected a readable URDF file"
    assert sentence_of(file) == f"{file}: {reason}; check the path and its permissions"


def test_a_directory(tmp_path: Path) -> None:
    reason = "is a directory, expected a readable URDF file"
    assert sentence_of(tmp_path) == f"{tmp_path}: {reason}; check the path and its permissions"


@pytest.mark.parametrize("path", ["null\0byte.urdf", "~no such user/arm.urdf", "x" * 5000])
def test_a_path_that_cannot_be_one(path: str) -> None:
    with pytest.raises(
        FtcfaError, match=r"expected a readable URDF file|expected a path|unknown name"
    ):
        load_arm(path)


def test_an_unknown_locked_joint_lists_the_known_ones(urdf: Callable[..., Path]) -> None:
    file = urdf(TWO_JOINTS)
    for lock in ("wrist", ["wrist"], {"wrist": 0.0}):
        with pytest.raises(UnknownNameError) as caught:
            load_arm(file, lock=lock)
        known = "unknown name, expected one of: shoulder, elbow"
        assert str(caught.value) == f"{file}: moving joint 'wrist': {known}"
        assert caught.value.known == ("shoulder", "elbow")
        assert caught.value.field == "lock"


def test_a_mimic_joint_cannot_be_locked(urdf: Callable[..., Path]) -> None:
    file = urdf(with_elbow(LIMIT + '<mimic joint="shoulder"/>'))
    assert sentence_of(file, lock="elbow") == (
        f"{file}: joint 'elbow': a mimic joint cannot be locked, "
        "expected an independent joint; lock 'shoulder', which it mimics"
    )


def test_all_joints_locked(urdf: Callable[..., Path]) -> None:
    file = urdf(TWO_JOINTS)
    assert sentence_of(file, lock=["shoulder", "elbow"]) == (
        f"{file}: no joint moves, expected at least one free joint; lock fewer joints"
    )


def test_an_unphysical_link_that_does_not_move_is_only_warned_of(urdf: Callable[..., Path]) -> None:
    warning = "mass is -1 kg; ignored because the link does not move"
    arm = load_arm(urdf(robot(link("base", -1), link("upper"), SHOULDER)))
    assert arm.warnings == (f"link 'base': {warning}",)
    locked = load_arm(urdf(with_upper(link("upper", -1))), lock="shoulder")
    assert locked.warnings == (f"link 'upper': {warning}",)
