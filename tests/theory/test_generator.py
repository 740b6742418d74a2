"""The generator against the paper's own formulas, Ito's formula, and Theorem 1 at any state."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Gains,
    PaperPendulum,
    ParameterError,
    ShapedNoise,
    Sinusoid,
    Vibration,
    WhiteNoise,
    bounds,
    load_arm,
    printed,
    simulate_paths,
)
from ftcfa.control.network import RBFNetwork
from ftcfa.study.reproduction import FINITE_TIME, closed_loop
from ftcfa.theory.generator import STATE_SIGNALS, generator, with_filter_state
from ftcfa.theory.premises import theorem_paths

CONFIDENCE = 1 - 1e-6
ROUNDING = 1e-9
"""Relative to the largest term of LV."""
STATES = 200


def sig(x, a):
    return np.sign(x) * np.abs(x) ** a


def cube(x):
    """Gradient of |x|^4/4."""
    return (x @ x) * x


def by_hand(x, desired, theta, weight, intensity):
    """LV and phihat of the paper's pendulum from (4), (6) to (11), (13) without abar's noise.

    Also the largest term of LV, for rounding.
    """
    g, arm = Gains(), PaperPendulum()
    q, v, psi1, psi2, s1, s2, rho = x[:14].reshape(7, 2)
    estimate = x[14]
    q_d, dq_d, _ = desired.reshape(3, 2)
    v1, v2 = q - q_d - s1, v - psi1 - s2 - rho
    alpha = -g.c1 * sig(v1, g.kappa) - 0.75 * (1 + g.k1) * v1 + dq_d - rho
    zeta = -750.0 * sig(psi1 - alpha, 0.5) + psi2
    B = RBFNetwork().basis(q, v)
    M = arm.mass_matrix(q)
    a = -g.c2 * sig(v2, g.kappa) - (0.75 * g.k2 + 1.25) * v2 - estimate * v2 * (B @ B) / 4 - rho
    u = M @ a
    ds1 = -g.k1 * s1 - g.c1 * sig(s1, g.kappa) + psi1 - alpha + s2
    ds2 = -g.k2 * s2 - g.c2 * sig(s2, g.kappa)
    drho = -rho + np.linalg.solve(M, 15 * np.tanh(u / 15) - u)
    destimate = -g.iota * estimate + (v2 @ v2) ** 2 * (B @ B) / 4
    force = np.clip(u, -15, 15) - arm.coriolis_matrix(q, v) @ v - arm.potential_force(q)
    phi = np.linalg.solve(M, BaseAcceleration("xz").matrix(arm, q)) * np.sqrt(intensity)
    terms = [
        cube(v1) @ (v - dq_d - ds1),
        cube(v2) @ (np.linalg.solve(M, force) - zeta - ds2 - drho),
        -(theta - estimate) * destimate,
        weight * (cube(s1) @ ds1),
        weight * (cube(s2) @ ds2),
        np.trace(phi.T @ (2 * np.outer(v2, v2) + (v2 @ v2) * np.eye(2)) @ phi) / 2,
    ]
    phihat = v2 @ (np.linalg.solve(M, -arm.bias_force(q, v)) - zeta) + 1.5 * np.sum(phi**2)
    return sum(terms), max(abs(term) for term in terms), phihat


def pendulum(intensity=0.1, **changes):
    arm = load_arm("double_pendulum", gravity=9.8)
    reference = Sinusoid([1.5, 1.0], [1.0, 2.0])
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(intensity))
    return ClosedLoop(arm, printed(FTCF(arm)), reference, vibration, **changes)


def states(n, scale, rng, count=STATES):
    """Random states, large and small, with a positive estimate of theta."""
    x = scale * rng.standard_normal((count, 7 * n + 1)) * 10 ** rng.uniform(-2, 1, (count, 1))
    x[:, -1] = np.abs(x[:, -1])
    return x, rng.standard_normal((count, 3 * n))


def test_generator_is_that_of_the_papers_formulas():
    """So the drift, which is the limit of the sampled law's step, is the continuous law."""
    x, desired = states(2, 1.0, np.random.default_rng(0))
    values = generator(pendulum(0.3)).at(x, desired, theta=2.0, weight=1.7)
    for k in range(STATES):
        LV, scale, phihat = by_hand(x[k], desired[k], 2.0, 1.7, 0.3)
        assert abs(values.LV[k] - LV) < ROUNDING * scale
        assert abs(values.demand[k] - phihat) < ROUNDING * max(scale, abs(phihat), 1.0)


def test_filter_on_its_input_has_the_integral_part_as_rate():
    """psi1 = alpha exactly, where the implicit step is 0/0 at a vanishing period."""
    loop = pendulum()
    x, desired = np.zeros(15), np.array([0.2, -0.1, 0.5, 0.3, 0.0, 0.0])
    g = Gains()
    x[4:6] = -g.c1 * sig(-desired[:2], g.kappa) + 0.75 * (1 + g.k1) * desired[:2] + desired[2:4]
    x[6:8] = 3.0, -2.0
    LV, scale, _ = by_hand(x, desired, 0.0, 1.0, 0.1)
    assert abs(generator(loop).at(x, desired).LV - LV) < 1e-6 * scale  # alpha has rounding


def test_itos_formula():
    """E V(T) - V(0) = E integral of LV, and not without 1/2 Tr(Phi^T V_xx Phi)."""
    loop = pendulum(20.0, period=2e-5, q0=[0.1, -0.1], v0=[-0.5, 4.2])  # v2 is (0.1, 0.1)
    paths, steps = 2000, 100
    run = simulate_paths(with_filter_state(loop), paths, steps * loop.period, signals=STATE_SIGNALS)
    quiet = replace(loop, vibration=None)
    gaps = []
    for each in (loop, quiet):
        along = generator(each).along(loop, run)
        gaps.append(along.V[:, -1] - along.V[:, 0] - loop.period * along.LV[:, :-1].sum(axis=1))
    right, wrong = gaps
    error = stats.norm.ppf(0.5 + CONFIDENCE / 2) * right.std(ddof=1) / np.sqrt(paths)
    assert abs(right.mean()) < error
    assert abs(wrong.mean()) > 5 * error


@pytest.mark.parametrize(("robot", "scale"), [("double_pendulum", 1.0), ("ur5", 0.5)])
@pytest.mark.parametrize("kappa", [0.3, 0.6, 0.9, 1.0])
def test_theorem_1_at_any_state(robot, scale, kappa):
    """LV <= -Delta V^p + Gamma, with the premises that the state needs.

    All repaired steps of the proof at once, at random states and gains. Weak motors, so that the
    saturation term does not hide the others.
    """
    rng = np.random.default_rng(1)
    arm, failures = load_arm(robot, effort_limit=0.05), 0
    gains = Gains(
        kappa=kappa, k1=rng.uniform(2, 5), k2=rng.uniform(0.4, 2), c1=rng.uniform(0.5, 20),
        c2=rng.uniform(0.5, 50), iota=rng.uniform(0.5, 100), lambda_=rng.uniform(0.1, 10),
    )  # fmt: skip
    loop = ClosedLoop(
        arm, printed(FTCF(arm, gains)), Sinusoid(np.zeros(arm.n)),
        Vibration(BaseAcceleration("xyz"), WhiteNoise(0.1)),
    )  # fmt: skip
    bound, made, n = bounds(loop), generator(loop), arm.n
    assert bound.applies
    x, desired = states(n, scale, rng)
    for k in range(STATES):
        q, s1, rho = x[k, :n], x[k, 4 * n : 5 * n], x[k, 6 * n : 7 * n]
        v1 = q - desired[k, :n] - s1
        alpha = -gains.c1 * sig(v1, kappa) - 0.75 * (1 + gains.k1) * v1 - rho
        alpha += desired[k, n : 2 * n]
        gap = 0.1 * rng.standard_normal(n)
        x[k, 2 * n : 3 * n], pi1 = alpha + gap, float(np.linalg.norm(gap))
        v2 = x[k, n : 2 * n] - alpha - gap - x[k, 5 * n : 6 * n] - rho
        x[k, 3 * n : 4 * n] = -rng.uniform(0, 300) * v2 / np.linalg.norm(v2)  # abar runs away
        demand = max(0.0, float(made.at(x[k], desired[k]).demand))
        for eps, holds in ((demand, True), (0.0, False)):
            supplied = replace(bound, eps=eps, pi1=pi1)
            values = made.at(x[k], desired[k], 0.0, supplied.weight)
            excess = values.LV + supplied.Delta * values.V**supplied.p - supplied.Gamma
            if holds:
                assert excess <= ROUNDING * (abs(values.LV) + supplied.Gamma)
            failures += not holds and excess > 0
    assert failures > 0  # without the premise it is not true


def test_theta_covers_what_eps_does():
    """phihat <= sqrt(theta B^T B) is enough: (25) at the states of a path."""
    loop = closed_loop(FINITE_TIME)
    paths = theorem_paths(loop, bounds(loop), 4, 0.3)
    theta = float(np.max(paths.values.needed_theta))
    enough = bounds(loop, theta=theta, pi1=float(paths.filter_error.max()))
    again = theorem_paths(loop, enough, 4, 0.3)
    assert theta > 0
    assert np.max(again.missing_eps) < ROUNDING * np.max(again.values.demand)
    needed = again.values.LV + enough.Delta * again.values.V**enough.p
    assert np.max(needed) <= enough.Gamma


def test_inequality_along_the_papers_study():
    """E[LV] <= -Delta E[V^p] + Gamma at every sample, at the upper end of its interval."""
    loop = closed_loop(FINITE_TIME)
    paths = theorem_paths(loop, bounds(loop), 32, 2.0)
    needed = paths.needed_Gamma
    high = needed.student(1 - 1e-6 / len(paths.time)).high
    assert np.max(high) < bounds(loop).Gamma
    assert np.max(needed.mean) > 1e3  # the beginning; theta = 0 is far from true there
    assert np.max(np.abs(needed.mean[-500:])) < 1.0


def test_a_diverged_path_is_not_averaged_away():
    loop = pendulum(1e10)
    paths = theorem_paths(loop, bounds(loop), 4, 0.5)
    assert np.isnan(paths.values.V[:, -1]).any()
    assert np.isnan(paths.needed_Gamma.mean[-1])


def test_only_white_noise_has_a_generator():
    arm = load_arm("double_pendulum")
    noise = ShapedNoise.from_psd(*["mil_std_810g_highway_truck_vertical"] * 2)
    loop = ClosedLoop(
        arm,
        printed(FTCF(arm)),
        Sinusoid(np.zeros(2)),
        Vibration(BaseAcceleration("xz"), noise),
        substeps=4,
    )
    with pytest.raises(ParameterError, match="ShapedNoise through BaseAcceleration, expected Wh"):
        generator(loop)


def test_recording_the_filter_changes_nothing():
    loop = pendulum()
    plain, seen = (simulate_paths(each, 3, 0.1) for each in (loop, with_filter_state(loop)))
    np.testing.assert_array_equal(plain.q, seen.q)
