"""Every arm of the catalogue against Pinocchio called directly, and against mechanics itself."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

from ftcfa import Arm, ShapeError, load_arm
from ftcfa.arrays import Array
from ftcfa.model.urdf.catalogue import catalogue

STATES = 10
AGREEMENT = 1e-10
"""Relative to the largest entry; two algorithms on up to 48 joints lose a few digits of 16."""
STEP = 1e-5
SKEWNESS = 1e-8
"""Relative; a central difference errs by STEP^2 = 1e-10 and by rounding, 1e-16/STEP = 1e-11."""
ENERGY_DRIFT = 1e-7
"""Relative; the integrator's tolerance is 1e-10 a step, over some hundred steps."""


def states(arm: Arm) -> list[tuple[Array, Array]]:
    """Random positions, over the whole turn, and velocities."""
    rng = np.random.default_rng(1)
    return [(rng.uniform(-3, 3, arm.n), rng.standard_normal(arm.n)) for _ in range(STATES)]


def assert_close(actual: Array, expected: Array, tolerance: float = AGREEMENT) -> None:
    scale = max(np.max(np.abs(expected)), 1e-3)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * scale)


def file_of(arm: Arm) -> Path:
    return catalogue()[arm.name].path()


def configuration(model: pin.Model, arm: Arm, q: Array) -> Array:
    """A configuration of the unchanged URDF, whose continuous joints are cosines and sines."""
    turned = np.zeros(model.nv)
    turned[-arm.model.nv :] = arm.G @ q + arm.g0
    return pin.integrate(model, pin.neutral(model), turned)


def test_mass_matrix_is_symmetric_and_positive_definite(arm: Arm) -> None:
    for q, _ in states(arm):
        M = arm.mass_matrix(q)
        assert_close(M, M.T)
        assert np.linalg.eigvalsh(M)[0] > 0


def test_dynamics_agree_with_newton_and_euler_on_the_unchanged_urdf(arm: Arm) -> None:
    model = pin.buildModelFromUrdf(str(file_of(arm)))
    data = model.createData()
    rng = np.random.default_rng(2)
    for q, v in states(arm):
        acceleration = rng.standard_normal(arm.n)
        q_file, v_file = configuration(model, arm, q), arm.G @ v
        force = arm.G.T @ pin.rnea(model, data, q_file, v_file, arm.G @ acceleration)
        bias = arm.G.T @ pin.rnea(model, data, q_file, v_file, 0 * v_file)
        h = arm.G.T @ pin.computeGeneralizedGravity(model, data, q_file)
        assert_close(arm.coriolis_matrix(q, v) @ v + arm.potential_force(q), bias)
        assert_close(arm.potential_force(q), h)
        assert_close(arm.mass_matrix(q) @ acceleration + bias, force)


def test_bias_is_the_sum_of_its_parts(arm: Arm) -> None:
    for q, v in states(arm):
        parts = arm.coriolis_matrix(q, v) @ v + arm.potential_force(q) + arm.friction_force(v)
        assert_close(arm.bias_force(q, v), parts)


def test_forward_dynamics_inverts_the_equation_of_motion(arm: Arm) -> None:
    for q, v in states(arm):
        tau = arm.effort_limit * np.sin(np.arange(arm.n))
        acceleration = arm.forward_dynamics(q, v, tau)
        assert_close(arm.mass_matrix(q) @ acceleration + arm.bias_force(q, v), tau, 1e-8)


def test_rate_of_mass_matrix_minus_twice_coriolis_is_skew(arm: Arm) -> None:
    for q, v in states(arm):
        rate = (arm.mass_matrix(q + STEP * v) - arm.mass_matrix(q - STEP * v)) / (2 * STEP)
        S = rate - 2 * arm.coriolis_matrix(q, v)
        size = np.max(np.abs(rate)) + np.max(np.abs(arm.mass_matrix(q)))
        np.testing.assert_allclose(S + S.T, 0 * S, rtol=0, atol=SKEWNESS * size)


def test_base_coupling_is_a_block_of_the_free_floating_mass_matrix(arm: Arm) -> None:
    model = pin.buildModelFromUrdf(str(file_of(arm)), pin.JointModelFreeFlyer())
    for q, _ in states(arm):
        floating = configuration(model, arm, q)
        M = pin.crba(model, model.createData(), floating, pin.Convention.WORLD)
        assert_close(arm.base_coupling(q), arm.G.T @ M[:6, 6:].T)


def test_a_base_acceleration_acts_like_a_change_of_gravity(arm: Arm) -> None:
    gravity, a = np.array([0.0, 0.0, -9.81]), np.array([0.7, -1.3, 2.1])
    shaken = load_arm(arm.name, gravity=gravity - a)
    for q, _ in states(arm):
        Lambda = -arm.base_coupling(q)[:, :3]
        assert_close(shaken.potential_force(q) - arm.potential_force(q), -Lambda @ a)


def test_energy_is_conserved_without_friction_and_torque(arm: Arm) -> None:
    n = arm.n
    free = replace(arm, damping=0 * arm.damping, friction=0 * arm.friction)
    data = arm.model.createData()

    def rate(_t: float, x: Array) -> Array:
        return np.concatenate([x[n:], free.forward_dynamics(x[:n], x[n:], np.zeros(n))])

    def energies(x: Array) -> tuple[float, float]:
        kinetic = x[n:] @ arm.mass_matrix(x[:n]) @ x[n:] / 2
        return kinetic, pin.computePotentialEnergy(arm.model, data, arm.G @ x[:n] + arm.g0)

    start = np.concatenate([arm.home, np.full(n, 0.5)])
    path = solve_ivp(rate, (0.0, 0.2), start, method="DOP853", rtol=1e-10, atol=1e-10)
    kinetic, potential = np.array([energies(x) for x in path.y.T]).T
    exchanged = np.ptp(kinetic) + np.ptp(potential)
    assert exchanged > 0
    assert np.ptp(kinetic + potential) < ENERGY_DRIFT * (exchanged + np.max(kinetic))


def test_an_arm_survives_pickling_and_still_computes(arm: Arm) -> None:
    (q, v), *_ = states(arm)
    M, b = arm.mass_matrix(q), arm.bias_force(q, v)
    copy = pickle.loads(pickle.dumps(arm))
    assert vars(copy).keys() == vars(replace(arm)).keys()  # the work space stays behind
    np.testing.assert_array_equal(copy.mass_matrix(q), M)
    np.testing.assert_array_equal(copy.bias_force(q, v), b)
    assert copy.joint_names == arm.joint_names
    np.testing.assert_array_equal(copy.effort_limit, arm.effort_limit)


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((2, 1)), np.zeros(()), np.zeros(0)])
def test_arrays_of_the_wrong_shape_are_refused(wrong: Array) -> None:
    arm, right = load_arm("double_pendulum"), np.zeros(2)
    calls = {
        "q": [
            lambda: arm.mass_matrix(wrong),
            lambda: arm.potential_force(wrong),
            lambda: arm.base_coupling(wrong),
            lambda: arm.coriolis_matrix(wrong, right),
            lambda: arm.bias_force(wrong, right),
        ],
        "v": [
            lambda: arm.coriolis_matrix(right, wrong),
            lambda: arm.bias_force(right, wrong),
            lambda: arm.friction_force(wrong),
        ],
        "tau": [lambda: arm.forward_dynamics(right, right, wrong)],
    }
    for symbol, uses in calls.items():
        for use in uses:
            with pytest.raises(ShapeError) as caught:
                use()
            shape = f"shape {wrong.shape}, expected shape (2,)"
            assert str(caught.value) == f"{symbol} of double_pendulum: {shape}"
