"""Estimators of velocities against closed forms and exact solutions."""

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import solve_discrete_are

from ftcfa import (
    FTCF,
    BackwardDifference,
    ClosedLoop,
    Constant,
    Hardware,
    Kalman,
    Levant,
    ModelObserver,
    Sensors,
    load_arm,
    simulate,
)

H = 1e-3
ARM = load_arm("double_pendulum")


def estimated(estimator, q, torque=None):
    """Estimates of v from positions, shape (samples, n)."""
    torque = np.zeros_like(q) if torque is None else torque
    state, out = estimator.init(q[0]), []
    for row, u in zip(q, torque, strict=True):
        v, state = estimator.step(state, row, u, H)
        out.append(v)
    return np.array(out)


def wave(amplitude=1.0, w=5.0, duration=1.0):
    """A sine and its derivative, one joint."""
    t = np.arange(0.0, duration, H)
    return amplitude * np.sin(w * t)[:, None], amplitude * w * np.cos(w * t)[:, None]


def test_backward_difference_is_a_filter():
    q, _ = wave()
    corner = 20.0
    kept = np.exp(-2 * np.pi * corner * H)
    differences = np.diff(q[:, 0], prepend=q[0, 0]) / H
    expected = signal.lfilter([1 - kept], [1, -kept], differences)
    np.testing.assert_allclose(estimated(BackwardDifference(corner), q)[:, 0], expected, atol=1e-12)
    free = estimated(BackwardDifference(), q)[:, 0]
    np.testing.assert_allclose(free, differences, atol=1e-12)


@pytest.mark.parametrize("L", [30.0, 100.0])
def test_levant_converges_in_finite_time_below_its_bound(L):
    q, v = wave()  # |q''| is at most 25
    error = np.abs(estimated(Levant(L), q) - v)[:, 0]
    assert error[0] > 4.0
    reached = 5.0 * 5.0 / L  # the start is 5 rad/s off, and it moves with about L
    assert np.all(error[round(reached / H) :] < 0.05)


def test_levant_does_not_follow_beyond_its_bound():
    q, v = wave(w=20.0)  # |q''| is up to 400
    assert np.abs(estimated(Levant(30.0), q) - v)[500:].max() > 2.0


@pytest.mark.parametrize("make", [ModelObserver, Kalman])
def test_with_the_true_arm_and_torque_the_model_knows_better(make):
    """Of a plant that is nearly continuous, as the prediction takes it."""
    loop = ClosedLoop(
        ARM, FTCF(ARM), Constant([0.0, 0.0]), substeps=50, q0=[0.7, -0.4], v0=[1.0, 2.0]
    )
    path = simulate(loop, 1.0)
    q, v, u = (path[name].values for name in "qvu")
    before = np.concatenate([u[:1], u[:-1]])
    errors = np.abs(estimated(make(ARM), q, before) - v)[300:].max()
    difference = np.abs(estimated(BackwardDifference(), q) - v)[300:].max()
    assert errors < 0.1 * difference


def test_kalman_gains_are_those_of_the_riccati_equation():
    density, noise = 2.0, 1e-4
    A = np.array([[1.0, H], [0.0, 1.0]])
    G = np.array([[H**2 / 2], [H]]) * density / np.sqrt(H)
    C = np.array([[1.0, 0.0]])
    P = solve_discrete_are(A.T, C.T, G @ G.T, np.array([[noise**2]]))
    K = (P @ C.T / (C @ P @ C.T + noise**2)).ravel()

    class Still:
        """An arm that nothing moves."""

        def bias_force(self, q, v):
            return 0.0 * q

        def mass_matrix(self, q):
            return np.eye(1)

        def damping_matrix(self, v):
            return np.zeros((1, 1))

    it = Kalman(Still(), density, noise)
    zero = np.zeros(1)
    v, state = it.step(it.init(zero), np.ones(1), zero, H)
    np.testing.assert_allclose([state.q[0], v[0]], K, rtol=1e-6)


def test_the_law_settles_from_positions_alone():
    arm = load_arm("panda")
    resolution = 2 * np.pi / 2**20
    for estimator in (BackwardDifference(100.0), Levant(), ModelObserver(arm), Kalman(arm)):
        loop = ClosedLoop(
            arm,
            FTCF(arm, compensation="bias"),
            Constant(arm.home),
            q0=arm.home + 0.1,
            hardware=Hardware(Sensors(resolution, velocity=estimator)),
        )
        assert float(simulate(loop, 2.0).ote[-200:].max()) < 1e-3
