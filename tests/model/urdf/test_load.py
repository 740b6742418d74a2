"""What `load_arm` takes: paths, packages, gravity and limits; the rest it refuses in a sentence."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ftcfa import FtcfaError, ParameterError, ShapeError, UnknownNameError, UrdfError, load_arm

from ..texts import AXIS_Y, TWO_JOINTS, robot, with_elbow

ROUNDING = 1e-12
"""Absolute; the compared entries are below 100."""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A ROS package in a workspace: .../workspace/my_robot/urdf/arm.urdf."""
    file = tmp_path / "workspace" / "my_robot" / "urdf" / "arm.urdf"
    file.parent.mkdir(parents=True)
    file.write_text(TWO_JOINTS)
    return tmp_path / "workspace" / "my_robot"


def test_a_robot_may_be_a_path_or_its_text(urdf: Callable[..., Path]) -> None:
    file = urdf(TWO_JOINTS)
    for given in (file, str(file)):
        arm = load_arm(given)
        assert arm.name == "arm"
        assert arm.joint_names == ("shoulder", "elbow")


def test_a_path_may_be_relative_or_start_at_the_users_home(
    urdf: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = urdf(TWO_JOINTS)
    monkeypatch.chdir(file.parent)
    assert load_arm("arm.urdf").n == 2
    monkeypatch.setenv("HOME", str(file.parent))
    assert load_arm("~/arm.urdf").n == 2


def test_package_paths_are_found_in_package_dirs(package: Path) -> None:
    uri = "package://my_robot/urdf/arm.urdf"
    for package_dirs in ([package.parent], [str(package.parent)], str(package.parent), [package]):
        arm = load_arm(uri, package_dirs=package_dirs)
        assert arm.n == 2
        assert arm.source is not None
        assert load_arm(**arm.source).n == 2  # the source names the file itself


def test_package_paths_are_found_in_ros_package_path(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = [str(tmp_path / "nothing_here"), "", str(package.parent)]
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(folders))
    assert load_arm("package://my_robot/urdf/arm.urdf").n == 2


def test_package_dirs_come_before_ros_package_path(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(package.parent))
    other = tmp_path / "other" / "my_robot" / "urdf" / "arm.urdf"
    other.parent.mkdir(parents=True)
    other.write_text(TWO_JOINTS.replace('name="arm"', 'name="other"'))
    uri = "package://my_robot/urdf/arm.urdf"
    assert load_arm(uri, package_dirs=[tmp_path / "other"]).name == "other"
    assert load_arm(uri).name == "arm"


def test_a_package_that_is_not_found_names_the_places_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    uri = "package://my_robot/arm.urdf"
    for package_dirs, searched in (([], "no folder"), ([tmp_path], str(tmp_path))):
        with pytest.raises(UrdfError) as caught:
            load_arm(uri, package_dirs=package_dirs)
        assert str(caught.value) == (
            f"{uri}: not found (searched: {searched}), expected a folder that holds the package "
            "'my_robot'; name it in package_dirs or in the environment variable ROS_PACKAGE_PATH"
        )


def test_gravity_is_a_downward_number_or_a_vector() -> None:
    q = np.array([0.4, -0.9])

    def force(gravity: Any) -> Any:
        return load_arm("double_pendulum", gravity=gravity).potential_force(q)

    np.testing.assert_array_equal(force(9.8), force([0.0, 0.0, -9.8]))
    np.testing.assert_array_equal(force(np.float32(2.5)), force((0, 0, -2.5)))
    np.testing.assert_array_equal(force(0), [0.0, 0.0])
    np.testing.assert_allclose(force(-9.8), -force(9.8), rtol=0, atol=ROUNDING)
    sideways = -3.0 * np.array([1.4 * 0.8, 0.8 * 1.2]) * np.cos(q)
    np.testing.assert_allclose(force([3.0, 0, 0]), sideways, rtol=0, atol=ROUNDING)


def test_effort_limits_come_from_the_urdf_or_the_user(urdf: Callable[..., Path]) -> None:
    file = urdf(with_elbow(f'{AXIS_Y}<limit lower="-1" upper="1" effort="3" velocity="2"/>'))
    for given, expected in (
        (None, [10, 3]),
        (7, [7, 7]),
        ([1, 2], [1, 2]),
        (np.array([1.0, 2.0]), [1, 2]),
        ({"elbow": 4}, [10, 4]),
        ({"elbow": 4, "shoulder": 5.5}, [5.5, 4]),
    ):
        np.testing.assert_array_equal(load_arm(file, effort_limit=given).effort_limit, expected)


def test_an_effort_limit_that_is_given_need_not_stand_in_the_urdf(
    urdf: Callable[..., Path],
) -> None:
    file = urdf(with_elbow(AXIS_Y))
    np.testing.assert_array_equal(load_arm(file, effort_limit=7).effort_limit, [7, 7])
    np.testing.assert_array_equal(load_arm(file, effort_limit={"elbow": 2}).effort_limit, [10, 2])


def test_limits_that_the_urdf_leaves_out_are_infinite_and_reported(
    urdf: Callable[..., Path],
) -> None:
    arm = load_arm(urdf(with_elbow(f'{AXIS_Y}<limit effort="3"/>')))
    np.testing.assert_array_equal(arm.lower, [-1, -np.inf])
    np.testing.assert_array_equal(arm.upper, [1, np.inf])
    np.testing.assert_array_equal(arm.velocity_limit, [2, np.inf])
    assert arm.warnings == (
        "joint 'elbow': no position limits; taken as unlimited",
        "joint 'elbow': no velocity limit; taken as unlimited",
    )


def test_one_position_limit_alone_leaves_the_other_at_zero(urdf: Callable[..., Path]) -> None:
    arm = load_arm(urdf(with_elbow(f'{AXIS_Y}<limit lower="-2" effort="3" velocity="1"/>')))
    assert (arm.lower[1], arm.upper[1]) == (-2.0, 0.0)
    assert arm.warnings == ()


def test_home_is_zero_or_the_middle_of_a_range_without_zero(urdf: Callable[..., Path]) -> None:
    arm = load_arm(urdf(with_elbow(f'{AXIS_Y}<limit lower="1" upper="2" effort="3"/>')))
    np.testing.assert_array_equal(arm.home, [0.0, 1.5])


@pytest.mark.parametrize(
    ("options", "error", "sentence"),
    [
        ({"gravity": "down"}, ShapeError, "gravity: 'down', expected a number or 3 numbers"),
        ({"gravity": [1, 2]}, ShapeError, "gravity: shape (2,), expected a number or shape (3,)"),
        (
            {"gravity": [1, [2, 3]]},
            ShapeError,
            "gravity: [1, [2, 3]], expected a number or 3 numbers",
        ),
        ({"gravity": np.nan}, ShapeError, "gravity: nan, expected finite numbers"),
        (
            {"effort_limit": [1, 2, 3]},
            ShapeError,
            "effort_limit: shape (3,), expected a number or shape (2,)",
        ),
        (
            {"effort_limit": {"elbow": "big"}},
            ParameterError,
            "effort_limit of joint 'elbow': 'big', expected a number > 0 [N m or N]",
        ),
        (
            {"effort_limit": {"elbow": np.inf}},
            ParameterError,
            "effort_limit of joint 'elbow': inf, expected a number > 0 [N m or N]",
        ),
        (
            {"effort_limit": {"elbow": 0}},
            ParameterError,
            "effort_limit of joint 'elbow': 0, expected a number > 0 [N m or N]",
        ),
        (
            {"effort_limit": -1},
            ParameterError,
            "effort_limit: [-1.0, -1.0], expected numbers > 0 [N m or N]",
        ),
        (
            {"effort_limit": {"wrist": 1}},
            UnknownNameError,
            "effort_limit of joint 'wrist': unknown name, expected one of: shoulder, elbow",
        ),
        (
            {"lock": {"elbow": "shut"}},
            ParameterError,
            "lock of joint 'elbow': 'shut', expected a number [rad or m]",
        ),
        (
            {"lock": {"elbow": np.nan}},
            ParameterError,
            "lock of joint 'elbow': nan, expected a number [rad or m]",
        ),
        (
            {"lock": 3},
            ParameterError,
            "lock: 3, expected joint names, or names with values [rad or m]",
        ),
    ],
)
def test_an_unusable_option_is_refused_in_one_sentence(
    urdf: Callable[..., Path], options: dict[str, Any], error: type[FtcfaError], sentence: str
) -> None:
    file = urdf(TWO_JOINTS)
    with pytest.raises(error) as caught:
        load_arm(file, **options)
    assert str(caught.value) == sentence
    assert [caught.value.field] == list(options)


@pytest.mark.parametrize("given", [None, 5, b"panda", ["panda"]])
def test_a_robot_must_be_a_name_or_a_path(given: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        load_arm(given)
    assert str(caught.value) == f"robot: {given!r}, expected a name or the path of a URDF"
    assert caught.value.field == "robot"


def test_urdf_text_in_place_of_a_path_is_recognised() -> None:
    with pytest.raises(ParameterError) as caught:
        load_arm(TWO_JOINTS)
    sentence = "robot: XML text, expected a name or the path of a URDF; write the text to a file"
    assert str(caught.value) == sentence


def test_a_mimic_joint_needs_no_effort_limit(urdf: Callable[..., Path]) -> None:
    file = urdf(with_elbow(AXIS_Y + '<mimic joint="shoulder"/>'))
    np.testing.assert_array_equal(load_arm(file).effort_limit, [10])


def test_a_robot_of_a_file_is_named_by_its_robot_element(urdf: Callable[..., Path]) -> None:
    file = urdf(robot(*TWO_JOINTS.split(">", 1)[1].rsplit("<", 1)[:1], attributes='name="Ann"'))
    assert load_arm(file).name == "Ann"
