"""Every arm that we ship loads, and starts from a sensible posture."""

from pathlib import Path

import numpy as np
import pytest

from ftcfa import Arm, UnknownNameError, load_arm
from ftcfa.model.urdf.catalogue import catalogue, robots_folder

ROOM = 0.3
"""The reference motions of the examples swing this far about the home posture [rad]."""


def test_the_catalogue_describes_each_arm() -> None:
    assert {"double_pendulum", "panda", "ur5", "baxter"} <= catalogue().keys()
    for name, entry in catalogue().items():
        assert entry.description, name
        assert entry.path().is_file(), name


def test_every_urdf_of_ours_is_in_the_catalogue() -> None:
    ours = {entry.file for entry in catalogue().values() if not entry.package}
    assert ours == {file.name for file in robots_folder().glob("*.urdf")}


def test_home_lies_inside_the_joint_limits_with_room_to_move(arm: Arm) -> None:
    slides = np.array([kind == "prismatic" for kind in arm.joint_types])
    room = np.where(slides, 0.0, ROOM)
    assert np.all(arm.home >= arm.lower + room)
    assert np.all(arm.home <= arm.upper - room)


def test_listed_joints_exist_and_no_others_move(arm: Arm) -> None:
    entry = catalogue()[arm.name]
    everything = load_arm(entry.path(), effort_limit=1.0)
    assert set(entry.joints) <= set(everything.joint_names)
    assert set(entry.home) <= set(everything.joint_names)
    assert set(arm.joint_names) == set(entry.joints or everything.joint_names)
    for name, value in entry.home.items():
        if name in arm.joint_names:
            assert arm.home[arm.joint_names.index(name)] == value


def test_every_arm_has_finite_positive_limits_and_named_coordinates(arm: Arm) -> None:
    assert arm.n == len(arm.joint_names) == len(set(arm.joint_names)) == len(arm.joint_types)
    for vector in (arm.lower, arm.upper, arm.velocity_limit, arm.effort_limit, arm.home):
        assert vector.shape == (arm.n,)
    assert np.all(np.isfinite(arm.effort_limit))
    assert np.all(arm.effort_limit > 0)
    assert np.all(arm.velocity_limit > 0)
    assert np.all(arm.lower < arm.upper)


def test_a_loaded_arm_can_be_loaded_again_from_its_source(arm: Arm) -> None:
    assert arm.source is not None
    again = load_arm(**arm.source)
    assert again.joint_names == arm.joint_names
    np.testing.assert_array_equal(again.mass_matrix(arm.home), arm.mass_matrix(arm.home))
    np.testing.assert_array_equal(again.potential_force(arm.home), arm.potential_force(arm.home))
    np.testing.assert_array_equal(again.effort_limit, arm.effort_limit)


def test_an_unknown_name_lists_the_known_ones() -> None:
    for unknown, near in (("pandda", "panda"), ("Panda", "panda"), ("ur 5", "ur5")):
        with pytest.raises(UnknownNameError) as caught:
            load_arm(unknown)
        known = ", ".join(catalogue())
        assert str(caught.value) == (
            f"robot (not a file, not an arm of the catalogue) '{unknown}': unknown name, "
            f"expected one of: {known}; did you mean '{near}'?"
        )
        assert caught.value.known == tuple(catalogue())
        assert caught.value.field == "robot"


def test_a_file_named_like_no_arm_needs_no_suffix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine").write_bytes(catalogue()["double_pendulum"].path().read_bytes())
    monkeypatch.chdir(tmp_path)
    assert load_arm("mine").n == 2
