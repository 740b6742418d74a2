"""Noise inputs against gravity, the pendulum's closed form and the paper's own print."""

from math import cos, sin

import numpy as np
import pytest

from ftcfa import (
    BaseAcceleration,
    PaperPendulum,
    PaperPendulumInput,
    ParameterError,
    ShapeError,
    load_arm,
)

ROUNDING = 1e-12
"""Sums of some ten products of numbers near one, done in two orders."""
GRID = 32
"""Angles a turn: the trapezoid rule on periodic analytic functions, right to five digits."""
AS_STATED = 0.006
"""EQUATIONS states the three figures with two decimals."""
M1, M2, L1, L2 = 0.6, 0.8, 0.8, 1.2


def random_postures(n, count, seed=0):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, n))


def physical(q1, q2):
    """Base accelerations (x, z) on two point masses on massless rods: minus sum of m dr/dq."""
    return -np.array(
        [
            [(M1 + M2) * L1 * cos(q1), (M1 + M2) * L1 * sin(q1)],
            [M2 * L2 * cos(q2), M2 * L2 * sin(q2)],
        ]
    )


def printed(q1, q2):
    """Lambda as the text of Section V prints it, entry by entry."""
    return np.array(
        [
            [
                -M1 * L1 * cos(q1) + 0.5 * M2 * L1 * sin(q1) * sin(2 * (q2 - q1)),
                -M1 * L1 * sin(q1) - 0.5 * M2 * L1 * cos(q1) * sin(2 * (q2 - q1)),
            ],
            [
                M2 * L2 * sin(q1) * sin(2 * (q2 - q1)),
                -M2 * L2 * cos(q1) * sin(2 * (q2 - q1)),
            ],
        ]
    )


@pytest.fixture(scope="module")
def pendulum():
    return load_arm("double_pendulum", gravity=9.8)


def test_base_acceleration_of_the_pendulum_is_its_closed_form(pendulum):
    for q in random_postures(2, 20):
        for arm in (pendulum, PaperPendulum()):
            got = BaseAcceleration("xz").matrix(arm, q)
            np.testing.assert_allclose(got, physical(*q), rtol=0, atol=ROUNDING)


def test_the_plane_of_the_pendulum_does_not_feel_the_third_axis(pendulum):
    for q in random_postures(2, 5):
        column = BaseAcceleration("y").matrix(pendulum, q)
        np.testing.assert_allclose(column, 0.0, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("robot", ["panda", "ur5"])
def test_an_accelerated_base_is_a_changed_gravity(robot):
    gravity, acceleration = np.array([0.3, -0.5, -9.81]), np.array([1.1, -0.7, 2.3])
    arm, shaken = (load_arm(robot, gravity=g) for g in (gravity, gravity - acceleration))
    for q in random_postures(arm.n, 5):
        change = shaken.potential_force(q) - arm.potential_force(q)
        got = -BaseAcceleration().matrix(arm, q) @ acceleration
        np.testing.assert_allclose(got, change, rtol=0, atol=100 * ROUNDING)  # tens of N m


@pytest.mark.parametrize("axes", ["x", "zx", "yzx"])
def test_channels_follow_the_order_of_the_axes(axes):
    arm = load_arm("ur5")
    all_axes = BaseAcceleration("xyz").matrix(arm, arm.home)
    noise = BaseAcceleration(axes)
    assert noise.channels == len(axes)
    expected = np.column_stack([all_axes[:, "xyz".index(axis)] for axis in axes])
    np.testing.assert_array_equal(noise.matrix(arm, arm.home), expected)


@pytest.mark.parametrize("axes", ["", "xx", "xw", "XZ", None, 3, ["x", "w"], ["x", "x"], [0, 2]])
def test_bad_axes_are_refused(axes):
    with pytest.raises(ParameterError, match=r'BaseAcceleration axes: .*such as "xyz" or "xz"'):
        BaseAcceleration(axes)


def test_the_paper_input_is_the_printed_formula():
    for q in random_postures(2, 50):
        got = PaperPendulumInput().matrix(PaperPendulum(), q)
        np.testing.assert_allclose(got, printed(*q), rtol=0, atol=ROUNDING)


def test_the_paper_input_is_not_the_physical_one_but_nearly_as_strong(pendulum):
    """Means over all postures, the noise power being tr(M^-1 Lambda Lambda^T M^-1)."""
    differences, powers = [], []
    angles = np.arange(GRID) * 2.0 * np.pi / GRID
    for q in np.array(np.meshgrid(angles, angles)).reshape(2, -1).T:
        ours = BaseAcceleration("xz").matrix(pendulum, q)
        theirs = PaperPendulumInput().matrix(pendulum, q)
        differences.append(np.linalg.norm(theirs - ours) / np.linalg.norm(ours))
        M = pendulum.mass_matrix(q)
        accelerations = np.linalg.solve(M, np.hstack([theirs, ours]))
        powers.append([np.sum(accelerations[:, :2] ** 2), np.sum(accelerations[:, 2:] ** 2)])
    assert np.mean(differences) == pytest.approx(0.89, abs=AS_STATED)
    assert np.mean(powers, axis=0) == pytest.approx([2.26, 2.23], abs=AS_STATED)


def test_the_paper_input_is_for_two_joints_only():
    with pytest.raises(ShapeError, match="an arm of 6 joints, expected 2 joints"):
        PaperPendulumInput().matrix(load_arm("ur5"), np.zeros(6))
