"""xacro files are expanded in a process of its own, which sees their package and nothing else."""

import os
import subprocess
import sys

import numpy as np
import pytest

from ftcfa import UrdfError, load_arm, load_experiment
from ftcfa.cli import main
from ftcfa.model.urdf import xacro
from ftcfa.model.urdf.load import arm_from_source

from ..texts import AXIS_Y, BASE, LIMIT

HEAD = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MACROS = f"""{HEAD}
<xacro:macro name="body" params="name mass:=1"><link name="$(arg prefix)${{name}}"><inertial>
<origin xyz="0 0 ${{-0.5/2}}"/><mass value="${{mass}}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link></xacro:macro>
</robot>"""
ARM = f"""{HEAD}<xacro:arg name="prefix" default=""/>
<xacro:include filename="$(find parts)/macros.xacro"/>
{BASE}<xacro:body name="upper" mass="${{2*2}}"/>
<joint name="$(arg prefix)shoulder" type="revolute"><parent link="base"/>
<child link="$(arg prefix)upper"/>{AXIS_Y}{LIMIT}</joint></robot>"""


@pytest.fixture
def workspace(tmp_path):
    """Two packages: `arm` includes macros of `parts`."""
    for package in ("arm/urdf", "parts"):
        (tmp_path / package).mkdir(parents=True)
    for package in ("arm", "parts"):
        (tmp_path / package / "package.xml").write_text(
            f"<package><name>{package}</name></package>"
        )
    (tmp_path / "parts" / "macros.xacro").write_text(MACROS)
    (tmp_path / "arm" / "urdf" / "arm.urdf.xacro").write_text(ARM)
    return tmp_path


def test_macros_arguments_and_packages(workspace):
    arm = load_arm(
        workspace / "arm/urdf/arm.urdf.xacro",
        package_dirs=[workspace],
        xacro_args={"prefix": "left_"},
    )
    assert arm.joint_names == ("left_shoulder",)
    assert arm.moving_mass == 4.0
    again = arm_from_source(**arm.source)  # the text of the URDF: no xacro, no files
    np.testing.assert_array_equal(again.inertias, arm.inertias)


def test_xacro_under_another_name(tmp_path):
    file = tmp_path / "arm.urdf"
    limit = LIMIT.replace('lower="-1"', 'lower="${-pi}"')
    file.write_text(ARM.replace("$(find parts)/", "").replace(LIMIT, limit))
    (tmp_path / "macros.xacro").write_text(MACROS)
    assert load_arm(file).lower[0] == -np.pi


def test_the_command_line(workspace, capsys):
    with pytest.raises(SystemExit) as caught:
        main([
            "inspect", str(workspace / "arm/urdf/arm.urdf.xacro"), "--package-dir", str(workspace),
            "--arg", "prefix=right_",
        ])  # fmt: skip
    assert caught.value.code in (0, None)
    assert "right_shoulder" in capsys.readouterr().out


def test_an_experiment(workspace):
    file = workspace / "e.toml"
    file.write_text(
        'duration = 1.0\n[arm]\nrobot = "arm/urdf/arm.urdf.xacro"\npackage_dirs = ["."]\n'
        'xacro_args = { prefix = "x_" }\n[controller]\ntype = "PDGravity"\n'
        '[reference]\ntype = "Constant"\nq = [0.1]\n'
    )
    assert load_experiment(file).loop.arm.joint_names == ("x_shoulder",)


def refusal(tmp_path, inside, **options):
    file = tmp_path / "arm.xacro"
    file.write_text(f"{HEAD}{inside}</robot>")
    with pytest.raises(UrdfError) as caught:
        load_arm(file, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_nothing_outside_the_folders_is_read(tmp_path):
    (tmp_path / "inside").mkdir()
    secret = tmp_path / "secret.xacro"
    secret.write_text(MACROS)
    for inside in (
        f'<xacro:include filename="{secret}"/>',
        '<xacro:include filename="../secret.xacro"/>',
        f"<link name=\"${{xacro.load_yaml('{secret}')}}\"/>",
    ):
        said = refusal(tmp_path / "inside", inside)
        assert "outside the file's package and package_dirs" in said


CONFINED = """
import sys
from pathlib import Path
from ftcfa.model.urdf.xacro_child import confine
confine([Path({folder!r})])
try:
    {attempt}
except PermissionError:
    sys.exit(13)
"""


@pytest.mark.parametrize(
    "attempt",
    [
        "open('/etc/hostname')",
        "open(b'/etc/hostname')",
        "open('{folder}/new', 'w')",
        "__import__('os').open('/etc/hostname', 0)",
        "__import__('os').open('{folder}/inside', __import__('os').O_RDWR)",
        "__import__('os').system('true')",
        "__import__('os').remove('{folder}/inside')",
        "__import__('subprocess').run(['true'])",
        "__import__('socket').create_connection(('127.0.0.1', 9))",
    ],
)
def test_the_fence(tmp_path, attempt):
    (tmp_path / "inside").write_text("x")
    code = CONFINED.format(folder=str(tmp_path), attempt=attempt.format(folder=tmp_path))
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 13
    allowed = CONFINED.format(folder=str(tmp_path), attempt=f"open('{tmp_path}/inside').read()")
    assert subprocess.run([sys.executable, "-c", allowed], check=False).returncode == 0


def test_the_environment_is_empty(tmp_path, monkeypatch):
    monkeypatch.setitem(os.environ, "SECRET", "42")
    assert "SECRET" in refusal(tmp_path, '<link name="$(env SECRET)"/>')


def test_a_package_that_is_not_there(tmp_path):
    said = refusal(tmp_path, '<xacro:include filename="$(find nothing)/x.xacro"/>')
    assert "Package not found: nothing" in said
    assert "package_dirs" in said


def test_a_macro_without_an_end(tmp_path):
    loop = '<xacro:macro name="a" params=""><xacro:a/></xacro:macro><xacro:a/>'
    assert "recursion" in refusal(tmp_path, loop)


def test_an_expression_that_takes_for_ever(tmp_path, monkeypatch):
    monkeypatch.setattr(xacro, "SECONDS", 2)
    said = refusal(tmp_path, '<link name="${9**9**9}"/>')
    assert "did not end in 2 s" in said


def test_an_expression_that_takes_all_memory(tmp_path):
    assert "cannot be expanded" in refusal(tmp_path, "<link name=\"${'a'*10**11}\"/>")


def test_without_the_extra(tmp_path, monkeypatch):
    monkeypatch.setattr(xacro, "find_spec", lambda _: None)
    said = refusal(tmp_path, '<xacro:arm name="x"/>')
    assert "this is a xacro file, expected plain URDF" in said
    assert "pip install 'ftcfa[xacro]'" in said
