"""Tracking from positions alone, beside Riccati equations and a filter written with matrices."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse
from scipy.linalg import solve_continuous_are, solve_discrete_are

from ftcfa import ClosedLoop, Hardware, PositionFeedback, Sensors, Sinusoid, load_arm, simulate
from ftcfa.control.protocol import Desired, Measured
from ftcfa.errors import ParameterError

from .arms import Mass

PERIOD = 1e-3
F = np.array([[1.0, PERIOD], [0.0, 1.0]])
G = np.array([PERIOD**2 / 2.0, PERIOD])
AT_REST = Desired(np.zeros(1), np.zeros(1), np.zeros(1))


def test_the_feedback_solves_the_riccati_equation_of_its_cost():
    a1, a2 = 3.0, 11.0
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    cost = solve_continuous_are(A, B, np.diag([(a1 * a2) ** 2, a1**2 + a2**2]), np.eye(1))
    law = PositionFeedback(Mass(), a1, a2)
    measured = Measured(np.array([0.3]), np.array([np.nan]))
    state = law.init(measured, AT_REST)._replace(dz1=np.array([0.2]), P12=np.zeros(()))
    signals, _ = law.step(state, measured, AT_REST, PERIOD)
    np.testing.assert_allclose(signals["u"], -(B.T @ cost @ [0.3, 0.2]), rtol=1e-12)


def test_the_estimate_is_that_of_a_kalman_filter():
    law = PositionFeedback(Mass(), acceleration=2.0, noise=1e-3, speed=0.5)
    rng = np.random.default_rng(4)
    q = rng.normal(0.1, 1e-2, 200)
    state = law.init(Measured(q[:1], np.zeros(1)), AT_REST)
    x, P = np.array([q[0], 0.0]), np.diag([1.0, 0.25])
    for reading in q:
        measured = Measured(np.array([reading]), np.zeros(1))
        signals, state = law.step(state, measured, AT_REST, PERIOD)
        K = P[:, 0] / (P[0, 0] + 1e-6)
        x = x + K * (reading - x[0])
        P = (np.eye(2) - np.outer(K, [1.0, 0.0])) @ P
        np.testing.assert_allclose([signals["z1"][0], signals["dz1"][0]], x, rtol=1e-7, atol=1e-9)
        x, P = F @ x + G * signals["u"], F @ P @ F.T + 4.0 / PERIOD * np.outer(G, G)
    np.testing.assert_allclose([state.P11, state.P12, state.P22], [P[0, 0], P[0, 1], P[1, 1]], 1e-7)


def test_its_covariance_settles_at_the_riccati_equation_and_is_that_of_its_errors():
    """4,000 masses at once, driven by white noise and read with noise: the law as an array."""
    density, noise, paths = 3.0, 2e-3, 4000
    rng = np.random.default_rng(5)
    truth = np.stack([np.zeros(paths), rng.normal(0.0, 0.4, paths)])
    reading = truth[0] + rng.normal(0.0, noise, paths)
    desired = Desired(*np.zeros((3, paths)))

    class Masses(Mass):
        n = paths

        def mass_matrix(self, q):
            return scipy.sparse.eye_array(paths)

        def damping_matrix(self, v):
            return scipy.sparse.csr_array((paths, paths))

        def bias_force(self, q, v):
            return np.zeros(paths)

    law = PositionFeedback(Masses(), 8.0, 20.0, acceleration=density, noise=noise, speed=0.4)
    state = law.init(Measured(reading, reading), desired)
    for _ in range(600):
        signals, state = law.step(state, Measured(reading, reading), desired, PERIOD)
        push = signals["u"] + rng.normal(0.0, density / np.sqrt(PERIOD), paths)
        truth = F @ truth + np.outer(G, push)
        reading = truth[0] + rng.normal(0.0, noise, paths)
    W = density**2 / PERIOD * np.outer(G, G)
    P = solve_discrete_are(F.T, np.array([[1.0], [0.0]]), W, [[noise**2]])
    np.testing.assert_allclose([state.P11, state.P12, state.P22], [P[0, 0], P[0, 1], P[1, 1]], 1e-6)
    errors = np.cov(truth - np.stack([state.z1, state.dz1]))
    np.testing.assert_allclose(errors, P, rtol=4.0 * np.sqrt(2.0 / paths))


def test_it_never_looks_at_a_measured_velocity():
    arm = load_arm("panda")
    loop = ClosedLoop(
        arm,
        PositionFeedback(arm),
        Sinusoid(0.2, offset=arm.home),
        q0=arm.home + 0.02,
        hardware=Hardware(Sensors(resolution=1e-5)),
    )
    noisy = Hardware(Sensors(resolution=1e-5, velocity_noise=5.0))
    runs = [simulate(each, 1.5) for each in (loop, replace(loop, hardware=noisy))]
    np.testing.assert_array_equal(*(run.q for run in runs))
    assert runs[0].ote[-100:].max() < 1e-3


@pytest.mark.parametrize("name", ["acceleration", "noise", "speed", "position_rate"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, "fast", True])
def test_wrong_parameters_are_refused(name, value):
    with pytest.raises(ParameterError, match=rf"PositionFeedback {name}: .*, expected"):
        PositionFeedback(Mass(), **{name: value})
