"""Names of any letters appear as they are written in tables, messages and figures."""

import io

import pytest
from rich.console import Console

from ftcfa import FTCF, ClosedLoop, FtcfaError, Sinusoid, load_arm, simulate
from ftcfa.errors import LONGEST, ParameterError, plain
from ftcfa.report.arm import arm_record, print_arm
from ftcfa.report.figures import rendered, tracking

LINK = (
    '<link name="{}"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
JOINT = (
    '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/>'
    '<limit lower="-1" upper="1" effort="10" velocity="2"/></joint>'
)

NAMES = [
    "wrist[left]",
    "wrist[/left]",
    ":smile:",
    "[link=https://x.y]z[/link]",
    "$x_",
    "a$b$c",
    "_j",
]
BELL, TURNED, C1 = "\x07", "\u202e", "\x9b"


@pytest.fixture
def named(tmp_path):
    def named(name):
        file = tmp_path / "arm.urdf"
        parts = LINK.format("base"), LINK.format("upper"), LINK.format("lower")
        joints = JOINT.format(name, "base", "upper"), JOINT.format("elbow", "upper", "lower")
        file.write_text(f'<robot name="arm">{"".join(parts + joints)}</robot>')
        return load_arm(file)

    return named


@pytest.mark.parametrize("name", NAMES)
def test_tables_show_names_as_written(named, name):
    buffer = io.StringIO()
    print_arm(arm_record(named(name)), Console(file=buffer, width=120, force_terminal=True))
    assert name in buffer.getvalue()
    assert "\x1b]8" not in buffer.getvalue()  # no link


@pytest.mark.parametrize("name", NAMES)
def test_figures_show_names_as_written(named, name):
    arm = named(name)
    path = simulate(ClosedLoop(arm, FTCF(arm), Sinusoid([0.1, 0.1])), 0.01, signals="all")
    assert len(rendered(tracking(path, "title", "note"))) == 2


@pytest.mark.parametrize("sign", [BELL, TURNED, C1, "\n", "\u2028"])
def test_messages_and_tables_escape_what_a_terminal_obeys(sign):
    said = str(ParameterError(f"joint 'a{sign}b'", "x"))
    assert sign not in said
    assert plain(sign) in said
    assert plain("größer, 肘, 😀") == "größer, 肘, 😀"


def test_long_names_are_shortened_in_messages():
    said = str(FtcfaError("joint 'a" + 10_000 * "b" + "c'", "x"))
    assert len(said) < LONGEST + 20
    assert said.startswith("joint 'abb")
    assert said.endswith("bc': x")
