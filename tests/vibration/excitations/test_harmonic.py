"""Sinusoids: exact integrals, one phase for each path, steps that resolve them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from ftcfa import Harmonic, ParameterError, RandomPhase, ShapeError, simulate_paths

from ..masses import CONFIDENCE, check_engines, pushed, run_process

ROUNDING = 1e-9
"""Relative; some hundred thousand steps of 1e-16, and cancellation of two in w h."""
TRUCK = "mil_std_810g_highway_truck_vertical"


@pytest.mark.parametrize("step", [1e-5, 1e-3, 1.0 / 80.0])
@pytest.mark.parametrize("phase", [0.0, 1.3, -np.pi / 2])
def test_the_integral_of_a_sinusoid(step, phase):
    Y, *_ = run_process(Harmonic(2.5, 10.0, phase).process(1, step), 30)
    for k in range(30):
        exact = quad(
            lambda t: 2.5 * np.cos(2 * np.pi * 10.0 * t + phase), k * step, (k + 1) * step,
            epsabs=1e-15,
        )[0]  # fmt: skip
        assert Y[k, 0] == pytest.approx(exact, rel=1e-9, abs=1e-9 * step)


def test_the_velocity_of_a_mass_after_many_steps():
    loop = pushed(Harmonic([1.0, 3.0], [7.0, 31.0], [0.4, -2.0]), 2)
    v = simulate_paths(loop, 1, 100.0, record_every=100).v
    a, w, phase = np.array([1.0, 3.0]), 2 * np.pi * np.array([7.0, 31.0]), np.array([0.4, -2.0])
    exact = a / w * (np.sin(np.outer(v.time, w) + phase) - np.sin(phase))
    np.testing.assert_allclose(v.values[0], exact, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    "loop",
    [
        pushed(Harmonic(1.0, 20.0)),
        pushed(Harmonic(1.0, [20.0, 30.0], 0.3), 2, substeps=3),
        pushed(Harmonic(1.0, 20.0) + Harmonic(0.5, 40.0, 0.1)),
        pushed(RandomPhase(TRUCK, 7), substeps=4),
        pushed(RandomPhase((TRUCK, "astm_d4169_truck_low"), 20), 2, period=2.5e-4),
    ],
)
def test_the_engines_agree(loop):
    check_engines(loop)


def test_a_phase_of_every_path_s_own():
    v = simulate_paths(pushed(Harmonic(1.0, 20.0)), 2000, 0.001).v.values[:, 1, 0]
    largest = 2 * np.sin(np.pi * 20.0 * 1e-3) / (2 * np.pi * 20.0)
    cosine = v / largest  # of a uniform phase: the arcsine law
    assert stats.kstest(cosine, "arcsine", args=(-1, 2)).pvalue > 1 - CONFIDENCE
    fixed = simulate_paths(pushed(Harmonic(1.0, 20.0, 0.7)), 3, 0.001).v.values
    assert np.ptp(fixed[:, 1]) == 0.0


def test_a_step_must_resolve_the_highest_frequency():
    message = r"integration step: 1 ms, for frequencies up to 130 Hz.*take substeps=2 of the period"
    with pytest.raises(ParameterError, match=message):
        pushed(Harmonic(1.0, [20.0, 130.0]), 2)
    pushed(Harmonic(1.0, [20.0, 125.0]), 2)
    with pytest.raises(ParameterError, match="take substeps=4"):
        pushed(RandomPhase(TRUCK))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1.0, 10.0), r"Harmonic amplitude: -1.0, expected numbers >= 0 \[m/s\^2\]"),
        (([1.0, np.nan], 10.0), r"Harmonic amplitude: \[1.0, nan\], expected numbers >= 0"),
        (("loud", 10.0), "Harmonic amplitude: 'loud', expected numbers >= 0"),
        (
            (np.ones((2, 2)), 10.0),
            r"Harmonic amplitude: shape \(2, 2\), expected a number or a list",
        ),
        (([], 10.0), r"Harmonic amplitude: shape \(0,\), expected a number or a list of numbers"),
        ((1.0, 0.0), r"Harmonic frequency: 0.0, expected a number > 0 \[Hz\]"),
        ((1.0, -5.0), r"Harmonic frequency: -5.0, expected a number > 0 \[Hz\]"),
        ((1.0, None), "Harmonic frequency: None, expected a number > 0"),
        ((1.0, 5.0, np.inf), r"Harmonic phase: inf, expected finite numbers \[rad\]"),
    ],
)
def test_what_is_no_sinusoid(arguments, message):
    with pytest.raises((ParameterError, ShapeError), match=message):
        Harmonic(*arguments)


def test_a_wrong_number_of_channels():
    with pytest.raises(ShapeError, match=r"Harmonic frequency: shape \(2,\), expected a number or"):
        pushed(Harmonic(1.0, [10.0, 20.0]), 3)
    with pytest.raises(ShapeError, match="RandomPhase: 1 channels, expected 2 channels"):
        pushed(RandomPhase(TRUCK), 2, period=2.5e-4)


def test_a_hundred_thousand_steps_of_the_recurrence():
    """Against the closed form of the angle, for slow and fast lines."""
    f, h, steps = np.array([0.01, 0.7, 31.0, 124.0]), 1e-3, 100_000
    process = Harmonic(1.0, f, 0.3).process(4, h)
    summed = replace(process, counts=(4,))  # the same lines in one channel: one sum, not four
    state, nothing = process.init(np.zeros(0)), np.zeros(0)
    for _ in range(steps):
        _, state = summed.advance(state, nothing, nothing)
    w = 2 * np.pi * f
    angle = 2 * np.pi * np.mod(f * (h * steps), 1.0) + 0.3
    W, U = process.integrals(state, nothing)
    np.testing.assert_allclose(W * w, np.sin(angle), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(U * w**2, -np.cos(angle), rtol=0, atol=ROUNDING)
