"""Joint friction f(v) is what the URDF's <dynamics> says."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ftcfa import Arm, load_arm
from ftcfa.arrays import Array
from ftcfa.model.urdf.catalogue import catalogue

from .texts import AXIS_Y, LIMIT, with_elbow

SMOOTHING = 2e-6
"""Relative; sign(v) is smoothed over 1e-3 rad/s, which costs (1e-3/v)^2/2 at v = 0.5 rad/s."""
ROUNDING = 1e-14
"""Relative."""


def friction_of_file(arm: Arm) -> tuple[Array, Array]:
    """Damping and friction as they stand in the URDF's text, shape (n,) each."""
    root = ElementTree.parse(catalogue()[arm.name].path()).getroot()
    tags = {joint.get("name"): joint.find("dynamics") for joint in root.findall("joint")}
    dynamics = [tags[name] for name in arm.joint_names]
    damping, friction = (
        np.array([float(tag.get(key, 0)) for tag in dynamics if tag is not None])
        for key in ("damping", "friction")
    )
    return damping, friction


@pytest.mark.parametrize("name", ["xarm7", "z1"])
def test_friction_is_that_of_the_urdf(name: str) -> None:
    arm = load_arm(name)
    damping, friction = friction_of_file(arm)
    assert np.all(damping > 0)
    assert np.all(friction > 0)
    v = np.where(np.arange(arm.n) % 2, 1.0, -0.5)
    expected = damping * v + friction * np.sign(v)
    np.testing.assert_allclose(arm.friction_force(v), expected, rtol=SMOOTHING)
    np.testing.assert_allclose(arm.damping_matrix(v) @ v, arm.friction_force(v), rtol=ROUNDING)
    np.testing.assert_array_equal(arm.friction_force(0 * v), 0 * v)


def test_friction_only_takes_energy_and_is_odd(arm: Arm) -> None:
    rng = np.random.default_rng(0)
    for v in rng.standard_normal((20, arm.n)) * 10.0 ** rng.uniform(-5, 1, (20, 1)):
        assert v @ arm.friction_force(v) >= 0
        np.testing.assert_array_equal(arm.friction_force(-v), -arm.friction_force(v))


def test_a_urdf_without_dynamics_has_no_friction() -> None:
    assert not load_arm("double_pendulum").friction_force(np.ones(2)).any()


def test_friction_of_a_mimic_joint_counts_through_its_multiplier(urdf: Callable[..., Path]) -> None:
    dynamics = '<dynamics damping="2" friction="0.5"/>'
    mimic = '<mimic joint="shoulder" multiplier="-3"/>'
    arm = load_arm(urdf(with_elbow(AXIS_Y + LIMIT + dynamics + mimic)))
    v = np.array([4.0])  # the elbow turns at -12 rad/s
    np.testing.assert_allclose(arm.friction_force(v), 3 * (2 * 12 + 0.5), rtol=SMOOTHING)
