"""The stationary integral W of an excitation: W_{k+1} = W_k + Y_k, and of mean zero."""

import numpy as np
import pytest

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
from ftcfa.vibration.spectrum import band_step_limit

from .masses import run_process

SUMMED = 1e-9
"""Of W_{k+1} - W_k - Y_k, relative to the largest Y."""
QUADRATURE = 1e-5
"""Relative accuracy of the trapezoid rule on a density, refined at every resonance."""


def record(samples=400, axes=2):
    values = np.random.default_rng(0).standard_normal((samples, axes)) + 3.0
    return RecordedAcceleration(Record(1e-3, values))


def limit(name):
    return band_step_limit(standard(name).spectrum)


CASES = [
    *((ShapedNoise(name), 1, limit(name) / cut) for name in standards() for cut in (1, 30)),
    *((RandomPhase(name, 30), 1, limit(name) / 1.1) for name in standards()),
    (ShapedNoise((Road("C", 20.0), Road("E", 5.0, TRUCK))), 2, 1e-3),
    (Harmonic([1.0, 2.0], [10.0, 0.01]), 2, 1e-3),
    (SineSweep([1.0, 2.0], 5.0, 50.0, 0.1), 2, 1e-3),
    (record(), 2, 1e-3),
    (record() + Harmonic(1.0, 20.0), 2, 1e-3),
    (Stacked((record(), Harmonic(1.0, 20.0)), (2, 1)), 3, 1e-3),
]


@pytest.mark.parametrize(("excitation", "channels", "step"), CASES)
def test_the_integrals_add_up_to_the_rate(excitation, channels, step):
    process = excitation.process(channels, step)
    assert process.integrable == set(range(channels))
    rng = np.random.default_rng(2)
    steps = 500  # more than the record has
    normals = rng.standard_normal((steps, process.normals))
    initial = rng.standard_normal(process.initial_normals)
    Y, W = run_process(process, steps, normals, initial, first=123)
    error = np.abs(np.diff(W, axis=0) - Y).max(axis=0)
    assert np.all(error <= SUMMED * np.abs(Y).max(axis=0))


def velocity_power(filter, frequencies):
    """Integral of S(f)/(2 pi f)^2: the variance of the integral, from the density alone."""
    near = np.outer(frequencies, 1.0 + np.sinh(np.linspace(-6.8, 6.8, 401)) * 2e-3).ravel()
    grid = np.unique(np.concatenate([np.geomspace(1e-4, 1e6, 40_000), near[near > 0]]))
    return np.trapezoid(filter.density(grid)[:, 0] / (2 * np.pi * grid) ** 2, grid)


@pytest.mark.parametrize("name", standards())
def test_the_variance_of_the_rate_is_stationary_and_the_density_s(name):
    excitation = ShapedNoise(name)
    (filter,) = excitation.filters
    process = excitation.process(1, limit(name))
    resonances = np.abs(np.linalg.eigvals(filter.A)) / (2 * np.pi)
    exact = velocity_power(filter, resonances)
    P = process.root @ process.root.T
    for _ in range(3):
        for _ in range(300):
            P = process.A @ P @ process.A.T + process.B @ process.B.T
        assert (process.E @ P @ process.E.T)[0, 0] == pytest.approx(exact, rel=QUADRATURE)
    W = process.rate(process.init(np.eye(process.initial_normals)[0]), np.zeros(0))
    assert W.shape == (1,)


@pytest.mark.parametrize("step", [1e-3, 3e-4])
def test_the_rate_of_a_record_has_no_mean_and_repeats(step):
    """A record of 3 m/s^2 on average: gravity does not turn a base, nor does resampling."""
    process = record().process(2, step)
    Y, W = run_process(process, len(process.rows))
    largest = np.abs(W).max(axis=0)
    assert np.all(np.abs(Y.mean(axis=0)) <= 1e-12 * largest)
    assert np.all(np.abs(W[:-1].mean(axis=0)) <= 1e-12 * largest)
    np.testing.assert_allclose(W[-1], W[0], atol=1e-12 * largest.max())


def test_the_rate_of_tones_has_no_mean_over_a_period():
    process = RandomPhase("astm_d4169_truck_low", 50).process(1, 1 / 3.98 / 800)
    (period,) = RandomPhase("astm_d4169_truck_low", 50).period
    assert period == pytest.approx(1 / 3.98)
    initial = np.random.default_rng(0).standard_normal(process.initial_normals)
    _, W = run_process(process, 800, initial=initial)
    assert abs(W[:-1].mean()) < 1e-12 * np.abs(W).max()


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
    process = ShapedNoise(filter).process(2, 1e-3)
    assert process.integrable == {1}


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


def test_white_noise_has_no_stationary_integral():
    process = WhiteNoise(0.1).process(2, 1e-3)
    assert process.integrable == frozenset()
    with pytest.raises(NotImplementedError, match="WhiteProcess has no integrable channel"):
        process.rate((), np.zeros(0))
