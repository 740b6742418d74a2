"""The stochastic plant against exact variances, its strong order, and energy."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_lyapunov

from ftcfa import BaseAcceleration, PaperPendulum, Vibration, WhiteNoise, load_arm
from ftcfa.loop.plant import INTEGRATORS, euler_maruyama, semi_implicit_euler

OMEGA, ZETA, VARPI = 10.0, 0.05, 1.0
STEP = 1e-3
PATHS = 10_000
CONFIDENCE = 1.0 - 1e-6
"""Of each two-sided interval for a sample variance of normal numbers (chi-squared)."""
INTEGRATORS_OF = pytest.mark.parametrize("name", list(INTEGRATORS))


@dataclass(frozen=True)
class Oscillators:
    """x'' + 2 zeta w x' + w^2 x = xi on unit masses, many at once: q of shape (paths, 1, 1).

    The first axis is one that the plant knows nothing of: its operations treat each 1 x 1 system
    alone. Damping stands in the bias, so that Euler-Maruyama is what the textbook calls it.
    """

    implicit_damping: bool

    def mass_matrix(self, q):
        return np.ones_like(q)

    def damping_matrix(self, v):
        return np.full_like(v, 2.0 * ZETA * OMEGA if self.implicit_damping else 0.0)

    def bias_force(self, q, v):
        return 2.0 * ZETA * OMEGA * v + OMEGA**2 * q


def shaken(integrator, duration, paths=PATHS, implicit_damping=False):
    """Positions and velocities of oscillators that start at rest, shape (2, paths)."""
    arm = Oscillators(implicit_damping)
    rng = np.random.default_rng(2024)
    q = v = np.zeros((paths, 1, 1))
    still = np.zeros_like(q)
    for _ in range(round(duration / STEP)):
        impulse = math.sqrt(VARPI * STEP) * rng.standard_normal(q.shape)
        q, v = integrator(arm, q, v, still, impulse, STEP)
    return np.stack([q.ravel(), v.ravel()])


def variance_from_rest(t):
    """Of the exact solution, in closed form."""
    wd = OMEGA * math.sqrt(1.0 - ZETA**2)
    bracket = wd**2 + 2.0 * (ZETA * OMEGA * math.sin(wd * t)) ** 2
    bracket += ZETA * OMEGA * wd * math.sin(2.0 * wd * t)
    decay = math.exp(-2.0 * ZETA * OMEGA * t)
    return VARPI / (4.0 * ZETA * OMEGA**3) * (1.0 - decay * bracket / wd**2)


def recursion(name):
    """x+ = A x + B n of the two textbook schemes on the oscillator."""
    h, k, d = STEP, OMEGA**2, 2.0 * ZETA * OMEGA
    velocity, kick = np.array([-h * k, 1.0 - h * d]), math.sqrt(VARPI * h)
    if name == "euler-maruyama":
        return np.array([[1.0, h], velocity]), kick * np.array([0.0, 1.0])
    return np.array([[1.0, 0.0] + h * velocity, velocity]), kick * np.array([h, 1.0])


def assert_variance(samples, variance):
    """A sample variance about the known mean zero lies where chi-squared says."""
    n = samples.size
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = stats.chi2.ppf([tail, 1.0 - tail], n) / n
    assert low < np.mean(samples**2) / variance < high


def test_the_closed_form_of_the_transient_variance():
    """0.0020343 at t = 0.5, and on to varpi/(4 zeta w^3) = 0.005; against numerical quadrature."""
    assert variance_from_rest(0.5) == pytest.approx(0.0020343, abs=5e-8)
    assert variance_from_rest(50.0) == pytest.approx(0.005)
    wd = OMEGA * math.sqrt(1.0 - ZETA**2)
    s = np.linspace(0.0, 0.5, 20_001)
    response = np.exp(-ZETA * OMEGA * s) * np.sin(wd * s) / wd
    assert np.trapezoid(response**2, s) == pytest.approx(variance_from_rest(0.5), rel=1e-6)


@INTEGRATORS_OF
def test_transient_variance_of_the_shaken_oscillator(name):
    """At t = 0.5, against the exact one of the scheme, which is near that of the equation."""
    A, B = recursion(name)
    P = np.zeros((2, 2))
    for _ in range(500):
        P = A @ P @ A.T + np.outer(B, B)
    q, v = shaken(INTEGRATORS[name], 0.5)
    assert_variance(q, P[0, 0])
    assert_variance(v, P[1, 1])
    discretisation = {"euler-maruyama": 0.03, "semi-implicit": 0.003}[name]
    assert P[0, 0] == pytest.approx(0.0020343, rel=discretisation)


@pytest.mark.parametrize("t", [0.1, 0.3, 0.5])
def test_semi_implicit_variance_is_that_of_the_equation(t):
    """Its own error, at most 1.4 %, widens the interval."""
    q, _ = shaken(semi_implicit_euler, t)
    ratio = np.mean(q**2) / variance_from_rest(t)
    sampling = stats.norm.isf((1.0 - CONFIDENCE) / 2.0) * math.sqrt(2.0 / PATHS)
    assert abs(ratio - 1.0) < sampling + 0.02


@INTEGRATORS_OF
def test_stationary_variance_of_the_shaken_oscillator(name):
    """varpi/(4 zeta w^3) = 0.005, for Euler-Maruyama times 1/(1 - h w/(2 zeta)) = 1.11."""
    A, B = recursion(name)
    P = solve_discrete_lyapunov(A, np.outer(B, B))
    inflation = 1.0 / (1.0 - STEP * OMEGA / (2.0 * ZETA)) if name == "euler-maruyama" else 1.0
    assert P[0, 0] == pytest.approx(0.005 * inflation, rel=0.01)
    q, v = shaken(INTEGRATORS[name], 8.0, paths=2000)  # e^(-2 zeta w t) = 3e-4 of the transient
    assert_variance(q, P[0, 0])
    assert_variance(v, P[1, 1])


def test_implicit_damping_deflates_the_variance_no_more_than_its_order():
    """Friction taken at the end of the step: first order again, and the other way."""
    h, k, d = STEP, OMEGA**2, 2.0 * ZETA * OMEGA
    gain = 1.0 / (1.0 + h * d)
    A = np.array([[1.0, h], [-h * k * gain, gain]])
    P = solve_discrete_lyapunov(A, VARPI * h * gain**2 * np.diag([0.0, 1.0]))
    q, v = shaken(euler_maruyama, 8.0, paths=2000, implicit_damping=True)
    assert_variance(q, P[0, 0])
    assert_variance(v, P[1, 1])


FINE, COARSE = 1024, (8, 16, 32, 64)
BROWNIAN_PATHS = 40
ORDER_ACCURACY = 0.1
"""Three standard errors of the slope from 40 paths, as repetitions with other seeds show."""


@pytest.fixture(scope="module")
def brownian_ends():
    """Ends (q, v) of the true arm, shape (paths, 4), by integrator and number of steps.

    A path's coarse increments are the sums of its fine ones. The torque held balances gravity at
    the start: all that happens, and all of the error, is the noise's doing.
    """
    arm = load_arm("double_pendulum", gravity=9.8)
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(3.0))
    fine = np.random.default_rng(1).standard_normal((BROWNIAN_PATHS, FINE, 2))
    start = np.array([0.8, -0.4])
    tau = arm.potential_force(start)

    def end(name, normals):
        steps = len(normals)
        q, v, h = start, np.zeros(2), 0.25 / steps
        process = vibration.process(arm, h)
        still = vibration.init(process, np.zeros(0))
        for k in range(steps):
            impulse, _ = vibration.impulse(process, arm, q, v, still, normals[k], np.zeros(0), h)
            q, v = INTEGRATORS[name](arm, q, v, tau, impulse, h)
        return np.concatenate([q, v])

    def ends(name, steps):
        ratio = FINE // steps
        sums = fine.reshape(BROWNIAN_PATHS, steps, ratio, 2).sum(axis=2) / math.sqrt(ratio)
        return np.array([end(name, normals) for normals in sums])

    return {(name, steps): ends(name, steps) for name in INTEGRATORS for steps in (*COARSE, FINE)}


@INTEGRATORS_OF
def test_strong_order_is_one_with_torque_held(brownian_ends, name):
    """The mean distance of paths, E|X_h - X|, is proportional to h."""
    exact = brownian_ends[name, FINE]
    errors = [np.mean(np.linalg.norm(brownian_ends[name, k] - exact, axis=1)) for k in COARSE]
    slope = np.polyfit(np.log(COARSE), np.log(errors), 1)[0]
    assert -slope == pytest.approx(1.0, abs=ORDER_ACCURACY)


def test_both_integrators_have_one_limit(brownian_ends):
    first, second = (brownian_ends[name, FINE] for name in INTEGRATORS)
    spread = np.std(second, axis=0)
    assert np.all(np.mean(np.abs(first - second), axis=0) < 0.01 * spread)


@INTEGRATORS_OF
def test_without_noise_it_solves_the_differential_equation(name):
    """Order one against a high-order solver, with all of Coriolis, gravity, torque and friction."""
    arm = load_arm("z1")  # damping 2 and friction 2 on every joint
    tau = np.full(6, 5.0)
    start = np.concatenate([arm.home, np.full(6, 0.5)])

    def rate(_, x):
        return np.concatenate([x[6:], arm.forward_dynamics(x[:6], x[6:], tau)])

    duration = 0.02
    exact = solve_ivp(rate, (0, duration), start, "LSODA", rtol=1e-9, atol=1e-10).y[:, -1]
    errors = []
    for steps in (400, 800):
        q, v = np.split(start, 2)
        for _ in range(steps):
            q, v = INTEGRATORS[name](arm, q, v, tau, np.zeros(6), duration / steps)
        errors.append(np.linalg.norm(np.concatenate([q, v]) - exact))
    assert errors[1] < 0.02 * np.linalg.norm(exact - start)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15)


def energy(q, v):
    """Kinetic plus potential energy of the two point masses."""
    x = np.array([0.8 * np.sin(q[0]), -0.8 * np.cos(q[0])])
    dx = 0.8 * v[0] * np.array([np.cos(q[0]), np.sin(q[0])])
    y = x + np.array([1.2 * np.sin(q[1]), -1.2 * np.cos(q[1])])
    dy = dx + 1.2 * v[1] * np.array([np.cos(q[1]), np.sin(q[1])])
    return 0.5 * 0.6 * dx @ dx + 0.5 * 0.8 * dy @ dy + 9.8 * (0.6 * x[1] + 0.8 * y[1])


@pytest.mark.parametrize("arm", [PaperPendulum(), None], ids=["closed form", "urdf"])
@INTEGRATORS_OF
def test_energy_is_conserved_to_first_order(arm, name):
    """A free swing of two seconds keeps its energy up to an error that halves with the step."""
    arm = load_arm("double_pendulum", gravity=9.8) if arm is None else arm
    drifts = []
    for h in (1e-3, 5e-4):
        q, v = np.array([1.0, 0.5]), np.zeros(2)
        start = energy(q, v)
        worst = 0.0
        for _ in range(round(2.0 / h)):
            q, v = INTEGRATORS[name](arm, q, v, np.zeros(2), np.zeros(2), h)
            worst = max(worst, abs(energy(q, v) - start))
        drifts.append(worst)
    swing = 9.8 * (1.4 * 0.8 * (1 - math.cos(1.0)) + 0.8 * 1.2 * (1 - math.cos(0.5)))
    assert drifts[1] < 0.02 * swing
    assert drifts[0] / drifts[1] == pytest.approx(2.0, rel=0.1)


XARM = load_arm("xarm7")


@given(
    v=st.lists(st.floats(-10, 10), min_size=7, max_size=7), step=st.sampled_from([1e-4, 1e-3, 1e-2])
)
def test_friction_only_ever_takes_energy(v, step):
    """xarm7 has 1 N m of friction on a last link of 1e-4 kg m^2: 1e4 rad/s^2 if explicit."""
    arm = XARM
    v = np.array(v)
    q = arm.home
    balance = arm.bias_force(q, v) - arm.friction_force(v)  # hold all but friction
    _, after = euler_maruyama(arm, q, v, balance, np.zeros(7), step)
    M = arm.mass_matrix(q)
    assert after @ M @ after <= v @ M @ v
