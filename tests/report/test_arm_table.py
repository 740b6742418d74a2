"""`ftcfa inspect`'s record and table, against the URDF read by other means."""

import io
import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from rich.console import Console

from ftcfa import load_arm
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.report.arm import arm_record, print_arm

GANTRY = """<robot name="gantry">
  <link name="base"/>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-0.5" upper="0.5" effort="20" velocity="2"/><dynamics damping="3"/>
  </joint>
  <link name="carriage">{two_kilograms}</link>
  <joint name="turn" type="continuous">
    <parent link="carriage"/><child link="pole"/><axis xyz="0 1 0"/>
    <limit effort="5" velocity="4"/>
  </joint>
  <link name="pole">{two_kilograms}</link>
</robot>""".replace(
    "{two_kilograms}",
    '<inertial><mass value="2"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>',
)


@pytest.fixture
def gantry(tmp_path):
    file = tmp_path / "gantry.urdf"
    file.write_text(GANTRY)
    return file


def table(record, width=80) -> str:
    stream = io.StringIO()
    print_arm(record, Console(file=stream, width=width), "an arm")
    return stream.getvalue()


def test_record_of_the_double_pendulum() -> None:
    record = arm_record(load_arm("double_pendulum"))
    assert [joint["name"] for joint in record["joints"]] == ["shoulder", "elbow"]
    assert record["joints"][0] == {
        "name": "shoulder",
        "type": "continuous",
        "lower": None,
        "upper": None,
        "velocity_limit": 20.0,
        "effort_limit": 15.0,
        "damping": 0.0,
        "friction": 0.0,
        "armature": 0.0,
        "gravity_load": pytest.approx((0.6 + 0.8) * 9.81 * 0.8, rel=1e-3),  # horizontal
        "gravity_load_at_home": 0.0,
        "home": 0.0,
    }
    assert record["mimic"] == {
        "carrier_joint": {"joint": "shoulder", "multiplier": -1.0, "offset": 0.0}
    }
    assert record["locked"] == {}
    assert record["moving_mass"] == pytest.approx(0.6 + 0.8)
    assert len(record["warnings"]) == 2


def test_mass_matrix_bounds_of_the_double_pendulum() -> None:
    """M depends on cos D alone: the extremes lie at D = 0 or pi, eigenvalues in closed form."""
    (m1, m2), (l1, l2) = (0.6, 0.8), (0.8, 1.2)
    stretched = [[(m1 + m2) * l1**2, m2 * l1 * l2], [m2 * l1 * l2, m2 * l2**2]]
    smallest, largest = np.linalg.eigvalsh(stretched)
    bounds = arm_record(load_arm("double_pendulum"))["mass_matrix_bounds"]
    assert bounds["Mmin"] == pytest.approx(smallest, rel=1e-6)
    assert bounds["Mmax"] == pytest.approx(largest, rel=1e-6)


def test_moving_mass_of_panda_is_that_of_its_links() -> None:
    root = ElementTree.parse(catalogue()["panda"].path()).getroot()
    masses = {
        link.get("name"): float(link.find("inertial/mass").get("value"))
        for link in root.findall("link")
        if link.find("inertial") is not None
    }
    moving = sum(mass for name, mass in masses.items() if name != "panda_link0")
    assert arm_record(load_arm("panda"))["moving_mass"] == pytest.approx(moving)


def test_a_locked_base_joint_takes_its_body_out_of_the_moving_mass(gantry) -> None:
    assert arm_record(load_arm(gantry))["moving_mass"] == pytest.approx(4.0)
    assert arm_record(load_arm(gantry, lock={"slide": 0.1}))["moving_mass"] == pytest.approx(2.0)
    assert arm_record(load_arm(gantry, lock={"turn": 0.1}))["moving_mass"] == pytest.approx(4.0)


def test_lock_shows_where_it_holds(gantry) -> None:
    record = arm_record(load_arm(gantry, lock={"turn": 0.25}))
    assert record["locked"] == {"turn": 0.25}
    assert "turn = 0.25" in table(record)


def test_units_of_mixed_joints(gantry) -> None:
    text = table(arm_record(load_arm(gantry)))
    for unit in ("rad/s", "m/s", "N m", "Nms/rad", "N s/m", "kg m^2 or kg"):
        assert unit in text
    assert "friction" in text.split("\n\n")[1]  # absent from the table, said below it
    assert "friction" not in text.split("\n\n")[0]


@pytest.mark.parametrize("name", [name for name in catalogue() if name != "asr_twodof"])
def test_every_arm_of_the_catalogue(name) -> None:
    arm = load_arm(name)
    record = arm_record(arm)
    json.dumps(record, allow_nan=False)
    assert 0 < record["mass_matrix_bounds"]["Mmin"] <= record["mass_matrix_bounds"]["Mmax"]
    for width in (80, 120):
        text = table(record, width)
        assert all(len(line) <= width for line in text.splitlines())
        assert "…" not in text
        for joint in record["joints"]:  # each on one line, unbroken
            (line,) = [s for s in text.splitlines() if s.startswith(f"{joint['name']} ")]
            assert f"{joint['home']:.3f}" in line
            assert f"{joint['effort_limit']:.4g}" in line
    assert all(warning[:40] in text for warning in record["warnings"])
