"""The paper's double pendulum: URDF, class and closed form are one robot (Section V)."""

import numpy as np
import pytest

from ftcfa import Arm, PaperPendulum, load_arm
from ftcfa.arrays import Array

STATES = 1000
ROUNDING = 1e-12
"""Absolute; entries are below 100, so a few hundred units in the last place."""
M1, M2, L1, L2, G = 0.6, 0.8, 0.8, 1.2, 9.8
"""Masses [kg], lengths [m] and gravity [m/s^2] of Section V."""


def closed_form(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """M, C and h in absolute angles."""
    D = q[1] - q[0]
    M = [[(M1 + M2) * L1**2, M2 * L1 * L2 * np.cos(D)], [M2 * L1 * L2 * np.cos(D), M2 * L2**2]]
    C = [[0, -M2 * L1 * L2 * np.sin(D) * v[1]], [M2 * L1 * L2 * np.sin(D) * v[0], 0]]
    h = [(M1 + M2) * G * L1 * np.sin(q[0]), M2 * G * L2 * np.sin(q[1])]
    return np.array(M), np.array(C), np.array(h)


def states() -> Array:
    """Random (q, v), shape (STATES, 2, 2)."""
    return np.random.default_rng(0).uniform(-np.pi, np.pi, (STATES, 2, 2))


@pytest.mark.parametrize(
    "pendulum", [load_arm("double_pendulum", gravity=G), PaperPendulum()], ids=["urdf", "class"]
)
def test_the_pendulum_equals_the_closed_form(pendulum: Arm | PaperPendulum) -> None:
    for q, v in states():
        M, C, h = closed_form(q, v)
        np.testing.assert_allclose(pendulum.mass_matrix(q), M, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(pendulum.coriolis_matrix(q, v), C, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(pendulum.potential_force(q), h, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(pendulum.bias_force(q, v), C @ v + h, rtol=0, atol=ROUNDING)


def test_relative_angles_describe_the_same_robot() -> None:
    T = np.array([[1.0, 0.0], [1.0, 1.0]])  # absolute = T relative, for angles and velocities
    relative = load_arm("double_pendulum_relative", gravity=G)
    for q, v in states():
        M, C, h = closed_form(T @ q, T @ v)
        np.testing.assert_allclose(relative.mass_matrix(q), T.T @ M @ T, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(
            relative.bias_force(q, v), T.T @ (C @ T @ v + h), rtol=0, atol=ROUNDING
        )


def test_the_printed_variant_carries_the_misprints_and_only_those() -> None:
    printed, q, v = PaperPendulum(as_printed=True), np.array([0.3, 1.1]), np.array([0.7, -0.4])
    _, C, h = closed_form(q, v)
    misprinted = np.array([[0.0, C[0, 1]], [M2 * L1 * L2 * np.cos(0.8) * 0.7, 1.0]])
    np.testing.assert_allclose(printed.coriolis_matrix(q, v), misprinted, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(printed.mass_matrix(q), PaperPendulum().mass_matrix(q))
    np.testing.assert_allclose(printed.potential_force(q), h, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(printed.bias_force(q, v), misprinted @ v + h, rtol=0, atol=ROUNDING)


def test_base_coupling_of_class_and_urdf_agree_for_a_base_that_does_not_turn() -> None:
    arm, pendulum = load_arm("double_pendulum"), PaperPendulum()
    for q, _ in states()[:100]:
        M_qb = pendulum.base_coupling(q)
        np.testing.assert_allclose(arm.base_coupling(q)[:, :3], M_qb[:, :3], rtol=0, atol=ROUNDING)
        assert not M_qb[:, 3:].any()


def test_the_pendulum_has_the_limits_and_names_of_its_urdf() -> None:
    arm, pendulum = load_arm("double_pendulum"), PaperPendulum()
    assert arm.joint_names == pendulum.joint_names == ("shoulder", "elbow")
    assert arm.joint_types == pendulum.joint_types
    np.testing.assert_array_equal(arm.effort_limit, pendulum.effort_limit)
    np.testing.assert_array_equal(arm.home, pendulum.home)
    assert not pendulum.damping_matrix(np.ones(2)).any()
