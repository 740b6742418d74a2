"""URDFs as other tools write them: each describes the two-joint arm, and must load as that arm."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

from ftcfa import Arm, load_arm

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

ROUNDING = 1e-14
"""Absolute; entries are of order one."""

DECLARATION = '<?xml version="1.0" encoding="{}"?>'
ACCENTED = TWO_JOINTS.replace('"upper"', '"oberarm größe"')
GAZEBO = '<gazebo reference="upper"><mu1>0.2</mu1></gazebo>'
TRANSMISSION = (
    '<transmission name="t"><joint name="elbow"><hardwareInterface>x</hardwareInterface></joint>'
    '<actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>'
)
SHAPES = (
    '<visual><geometry><mesh filename="package://nowhere/missing.stl"/></geometry></visual>'
    "<collision><geometry><box/></geometry></collision>"
)
SAFETY = '<safety_controller k_velocity="x"/><calibration rising="y"/>'

DIALECTS: dict[str, str | bytes] = {
    "byte order mark": b"\xef\xbb\xbf" + (DECLARATION.format("utf-8") + TWO_JOINTS).encode(),
    "Windows line endings": TWO_JOINTS.replace("><", ">\r\n\t<"),
    "UTF-16": (DECLARATION.format("UTF-16") + ACCENTED).encode("utf-16"),
    "ISO 8859-1": (DECLARATION.format("ISO-8859-1") + ACCENTED).encode("latin-1"),
    "US-ASCII": (DECLARATION.format("us-ascii") + TWO_JOINTS).encode(),
    "old xacro output": robot(
        LINKS, SHOULDER, ELBOW, attributes='name="r" xmlns:xacro="http://ros.org/wiki/xacro"'
    ),
    "onshape-to-robot": DECLARATION.format("utf-8")
    + "<!-- Generated using onshape-to-robot -->"
    + robot("<!-- Link base -->", LINKS, "<!-- Joints -->", SHOULDER, ELBOW),
    "xml-model instruction": '<?xml-model href="https://x/urdf.xsd"?>' + TWO_JOINTS,
    "instruction inside": robot(LINKS, "<?anything at all?>", SHOULDER, ELBOW),
    "version attribute": robot(LINKS, SHOULDER, ELBOW, attributes='name="r" version="1.0"'),
    "no robot name": robot(LINKS, SHOULDER, ELBOW, attributes=""),
    "simulator elements": robot(LINKS, GAZEBO, SHOULDER, TRANSMISSION, ELBOW, "<material/>"),
    "foreign namespace": robot(LINKS, '<x:link xmlns:x="urn:x"/>', SHOULDER, ELBOW),
    "meshes that do not exist": TWO_JOINTS.replace("</link>", SHAPES + "</link>"),
    "safety and calibration": TWO_JOINTS.replace("</joint>", SAFETY + "</joint>"),
    "joints before links": robot(ELBOW, SHOULDER, link("lower"), link("upper"), BASE),
    "fixed to a world": robot(
        '<link name="world"/>', joint("mount", "world", "base", "fixed", ""), LINKS, SHOULDER, ELBOW
    ).replace('child link="base"/><origin xyz="0 0 0.5"/>', 'child link="base"/>'),
    "SolidWorks fixed joint": robot(
        LINKS,
        link("tool", 0, "0 0 0", ixx=0, iyy=0, izz=0),
        SHOULDER,
        ELBOW,
        joint(
            "tip",
            "lower",
            "tool",
            "fixed",
            '<axis xyz="0 0 0"/><limit lower="0" upper="0" effort="0" velocity="0"/>',
        ),
    ),
    "joint and link share a name": TWO_JOINTS.replace('"elbow"', '"upper"'),
    "a link called universe": TWO_JOINTS.replace('"base"', '"universe"'),
    "a joint called root_joint": TWO_JOINTS.replace('"shoulder"', '"root_joint"'),
    "exponents and signs": with_upper(
        link("upper", "+1.0E+00", ixx="1.0e-01", ixy="-0", iyy=".1", izz="100e-3")
    ),
    "spaces around values": with_upper(link(" upper ", " 1\t", " 0.1  0 0.2 ")).replace(
        "revolute", " revolute\n"
    ),
    "axis of another length": TWO_JOINTS.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 25 0"/>'),
    "inertial turned about its axis": with_upper(
        link("upper").replace("<origin ", '<origin rpy="0 0 0.7" ')
    ),
    "empty dynamics": with_elbow(AXIS_Y + LIMIT + "<dynamics/>"),
    "two inertials": TWO_JOINTS.replace("</inertial>", "</inertial><inertial/>", 1),
}


def assert_same_robot(arm: Arm, expected: Arm) -> None:
    assert arm.n == expected.n
    for q, v in np.random.default_rng(0).uniform(-2, 2, (5, 2, arm.n)):
        np.testing.assert_allclose(
            arm.mass_matrix(q), expected.mass_matrix(q), rtol=0, atol=ROUNDING
        )
        np.testing.assert_allclose(
            arm.bias_force(q, v), expected.bias_force(q, v), rtol=0, atol=100 * ROUNDING
        )
    np.testing.assert_array_equal(arm.lower, expected.lower)
    np.testing.assert_array_equal(arm.upper, expected.upper)
    np.testing.assert_array_equal(arm.effort_limit, expected.effort_limit)
    np.testing.assert_array_equal(arm.velocity_limit, expected.velocity_limit)


@pytest.fixture
def two_joints(urdf: Callable[..., Path]) -> Arm:
    return load_arm(urdf(TWO_JOINTS, "plain.urdf"))


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS.keys())
def test_a_dialect_loads_as_the_same_robot(
    urdf: Callable[..., Path], two_joints: Arm, text: str | bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    assert_same_robot(load_arm(urdf(text)), two_joints)
    assert capfd.readouterr().err == ""  # no parser complains behind our back


@pytest.mark.parametrize("axis", ["", '<axis xyz="1 0 0"/>'])
def test_a_missing_axis_is_the_x_axis(urdf: Callable[..., Path], axis: str) -> None:
    arm = load_arm(urdf(with_elbow(axis + LIMIT)))
    np.testing.assert_array_equal(arm.tree().axes[1], [1.0, 0.0, 0.0])


def test_a_missing_inertial_origin_is_the_link_frame(urdf: Callable[..., Path]) -> None:
    plain = load_arm(urdf(with_upper(link("upper", centre="0 0 0"))))
    text = with_upper(link("upper").replace('<origin xyz="0.1 0 0.2"/>', ""))
    assert_same_robot(load_arm(urdf(text)), plain)


def test_a_prismatic_joint_without_position_limits_is_unlimited(urdf: Callable[..., Path]) -> None:
    text = with_elbow('<axis xyz="0 0 1"/><limit effort="5" velocity="1"/>', "prismatic")
    arm = load_arm(urdf(text))
    assert arm.joint_types == ("revolute", "prismatic")
    assert (arm.lower[1], arm.upper[1]) == (-np.inf, np.inf)
    assert "joint 'elbow': no position limits; taken as unlimited" in arm.warnings


def test_names_may_have_spaces_and_any_letters(urdf: Callable[..., Path]) -> None:
    text = TWO_JOINTS.replace('"shoulder"', '"Gelenk Nr. 1 (größer)"').replace('"elbow"', '"肘"')
    arm = load_arm(urdf(text), effort_limit={"肘": 3.0})
    assert arm.joint_names == ("Gelenk Nr. 1 (größer)", "肘")
    assert load_arm(urdf(text), lock="肘").joint_names == ("Gelenk Nr. 1 (größer)",)


names = st.text(st.characters(codec="utf-8", categories="LNPSZ"), min_size=1, max_size=12)


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(new=st.lists(names.filter(str.strip), min_size=5, max_size=5, unique_by=str.strip))
def test_names_never_change_the_robot(
    urdf: Callable[..., Path], two_joints: Arm, new: list[str]
) -> None:
    rename = dict(zip(["base", "upper", "lower", "shoulder", "elbow"], new, strict=True))
    root = etree.fromstring(TWO_JOINTS)
    for element in root.iter("link", "joint", "parent", "child"):
        key = "link" if element.tag in ("parent", "child") else "name"
        element.set(key, rename[element.get(key)])
    assert_same_robot(load_arm(urdf(etree.tostring(root))), two_joints)
