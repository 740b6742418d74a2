"""The stationary integrals of an excitation: W of xi, U of W, both of mean zero."""

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import expm

from ftcfa import (
    TRUCK,
    Harmonic,
    LinearFilter,
    RandomPhase,
    Record,
    RecordedAcceleration,
    Road,
    ShapedNoise,
    SineSweep,
    Stacked,
    WhiteNoise,
    standard,
    standards,
)
from ftcfa.vibration.spectra.spectrum import step_limit

from .masses import run_process

SUMMED = 1e-9
"""Of W_{k+1} - W_k - Y_k, relative to the largest Y."""
TRAPEZOID = 0.12
"""Of U_{k+1} - U_k - h (W_k + Y_k/2), relative to the largest: h^2 w^2/12 with w h up to pi/4, and
2 theta''/theta'^2 of the sweep."""
QUADRATURE = 1e-5
"""Relative accuracy of the trapezoid rule on a density, refined at every resonance."""


def record(samples=400, axes=2):
    sections = signal.butter(4, 50.0, fs=1e3, output="sos")
    values = np.random.default_rng(0).standard_normal((samples, axes))
    return RecordedAcceleration(Record(1e-3, signal.sosfilt(sections, values, axis=0) + 3.0))


def limit(name):
    return step_limit(standard(name).spectrum.band[1])


CASES = [
    *((ShapedNoise(name), 1, limit(name) / cut) for name in standards() for cut in (1, 30)),
    *((RandomPhase(name, 30), 1, limit(name) / 1.1) for name in standards()),
    (Harmonic([1.0, 2.0], [10.0, 0.01]), 2, 1e-3),
    (SineSweep([1.0, 2.0], 5.0, 50.0, 2.0), 2, 1e-3),
    (record(), 2, 1e-3),
    (record() + Harmonic(1.0, 20.0), 2, 1e-3),
    (Stacked((record(), Harmonic(1.0, 20.0)), (2, 1)), 3, 1e-3),
]


@pytest.mark.parametrize(("excitation", "channels", "step"), CASES)
def test_the_integrals_add_up(excitation, channels, step):
    """W by Y exactly, and U by W: the trapezoid rule is off by its own error only."""
    process = excitation.process(channels, step)
    assert not any(process.why_no_integrals(channel) for channel in range(channels))
    rng = np.random.default_rng(2)
    steps = 500  # more than the record has
    normals = rng.standard_normal((steps, process.normals))
    initial = rng.standard_normal(process.initial_normals)
    Y, W, U = run_process(process, steps, normals, initial, first=123)
    error = np.abs(np.diff(W, axis=0) - Y).max(axis=0)
    assert np.all(error <= SUMMED * np.abs(Y).max(axis=0))
    moved = step * (W[:-1] + Y / 2)
    error = np.abs(np.diff(U, axis=0) - moved).max(axis=0)
    assert np.all(error <= TRAPEZOID * np.abs(moved).max(axis=0))


def power(filter, frequencies, times):
    """Integral of S(f)/(2 pi f)^(2 times): an integral's variance, from the density alone."""
    near = np.outer(frequencies, 1.0 + np.sinh(np.linspace(-6.8, 6.8, 401)) * 2e-3).ravel()
    grid = np.unique(np.concatenate([np.geomspace(1e-3, 1e6, 40_000), near[near > 0]]))
    S = filter.density(grid)[:, 0] / (2 * np.pi * grid) ** (2 * times)
    return np.trapezoid(S, grid) + S[0] * grid[0]  # below, U's is flat and W's next to nothing


@pytest.mark.parametrize("name", standards())
def test_the_variances_are_stationary_and_the_density_s(name):
    excitation = ShapedNoise(name)
    (filter,) = excitation.filters
    sampled = excitation.process(1, limit(name)).filter
    resonances = np.abs(np.linalg.eigvals(filter.A)) / (2 * np.pi)
    exact = [power(filter, resonances, times) for times in (1, 2)]
    P = sampled.root @ sampled.root.T
    for _ in range(3):
        for _ in range(300):
            P = sampled.A @ P @ sampled.A.T + sampled.B @ sampled.B.T
        found = [(x @ P @ x.T)[0, 0] for x in (sampled.E, sampled.F)]
        assert found == pytest.approx(exact, rel=QUADRATURE)


def test_the_angle_of_a_filter_is_the_integral_of_its_rate():
    """Without noise, U(t) - U(0) = E A^-1 (e^(A t) - 1) x, and U vanishes in the end."""
    (filter,) = ShapedNoise("astm_d4169_truck_low").filters
    sampled = filter.discretise(1e-3)
    x = np.random.default_rng(0).standard_normal(filter.order)
    moved = sampled.E @ np.linalg.solve(filter.A, expm(filter.A * 0.1) @ x - x)
    np.testing.assert_allclose(sampled.F @ (expm(filter.A * 0.1) @ x - x), moved, rtol=1e-9)


@pytest.mark.parametrize("step", [1e-3, 3e-4])
def test_the_integrals_of_a_record_have_no_mean_and_repeat(step):
    """A record of 3 m/s^2 on average: gravity does not turn a base."""
    process = record().process(2, step)
    for x in run_process(process, len(process.rows)):
        one = x[: len(process.rows)]
        assert np.all(np.abs(one.mean(axis=0)) <= 1e-12 * np.abs(one).max(axis=0))
        np.testing.assert_array_equal(x[len(process.rows) :], one[: len(x) - len(one)])


def test_the_rate_of_tones_has_no_mean_over_a_period():
    process = RandomPhase("astm_d4169_truck_low", 50).process(1, 1 / 3.98 / 800)
    (period,) = RandomPhase("astm_d4169_truck_low", 50).period
    assert period == pytest.approx(1 / 3.98)
    initial = np.random.default_rng(0).standard_normal(process.initial_normals)
    _, *both = run_process(process, 800, initial=initial)
    for x in both:
        assert abs(x[:-1].mean()) < 1e-12 * np.abs(x).max()


def oscillator(w, zeta, output):
    """x'' + 2 zeta w x' + w^2 x = xi, states (x, x')."""
    return LinearFilter([[0.0, 1.0], [-(w**2), -2 * zeta * w]], [[0.0], [1.0]], output)


@pytest.mark.parametrize("size", [[1.0, 1.0], [1e-9, 1e9], [1e12, 1e-6]])
def test_only_what_has_no_gain_at_rest_is_integrable(size):
    """The velocity of an oscillator has, its position has not; W of the velocity is x."""
    size = np.array(size)
    filter = oscillator(30.0, 0.1, np.eye(2))
    filter = LinearFilter(
        filter.A * size[:, None] / size, filter.B * size[:, None], filter.C / size
    )
    E, integrable = filter.integral()
    np.testing.assert_array_equal(integrable, [False, True])
    np.testing.assert_allclose(E * size, [[0.0, 0.0], [1.0, 0.0]], atol=1e-12)
    assert all(ShapedNoise(filter).process(2, 1e-3).why_no_integrals(k) for k in (0, 1))


@pytest.mark.parametrize("size", [[1.0, 1.0, 1.0], [1e-9, 1e9, 1.0], [1e12, 1e-6, 1e3]])
def test_only_a_double_zero_at_rest_has_both_integrals(size):
    """Outputs that vanish like s, s^2 and s^2 + 1e-3 s, of three poles."""
    size, poles = np.array(size), np.poly([-30.0, -4.0 + 20.0j, -4.0 - 20.0j]).real
    A, B = np.eye(3, k=1), np.eye(3)[:, [2]]
    A[2] = -poles[:0:-1]
    C = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1e-3, 1.0]])
    filter = LinearFilter(A * size[:, None] / size, B * size[:, None], C / size)
    process = ShapedNoise(filter).process(3, 1e-3)
    assert [process.why_no_integrals(k) == "" for k in range(3)] == [False, True, False]
    sampled = filter.discretise(1e-3)
    np.testing.assert_allclose(sampled.F[1] * size, [1.0, 0.0, 0.0], atol=1e-9)


def test_a_little_gain_at_rest_is_gain():
    assert list(oscillator(30.0, 0.1, [[1e-3, 1.0]]).integral()[1]) == [False]
    assert list(oscillator(30.0, 0.1, [[1e-15, 1.0]]).integral()[1]) == [True]


def test_a_mixed_filter_has_the_same_integral_in_other_coordinates():
    rng = np.random.default_rng(0)
    shaping = ShapedNoise("astm_d4169_truck_low").filters[0]
    T = np.linalg.qr(rng.standard_normal(shaping.A.shape))[0]
    mixed = LinearFilter(T @ shaping.A @ T.T, T @ shaping.B, shaping.C @ T.T)
    E, integrable = mixed.integral()
    assert list(integrable) == [True]
    np.testing.assert_allclose(E @ T, shaping.integral()[0], rtol=1e-6)


def test_white_noise_and_a_road_have_not_both():
    for excitation in (WhiteNoise(0.1), ShapedNoise((Road("C", 20.0), Road("E", 5.0, TRUCK)))):
        assert all(excitation.process(2, 1e-3).why_no_integrals(k) for k in (0, 1))
