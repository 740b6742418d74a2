"""Random-phase synthesis: its power, its spectrum, its period, and what it is at any phase."""

import math

import numpy as np
import pytest
from scipy import signal, stats
from scipy.integrate import quad

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.spectra.spectrum import Spectrum
from ftcfa.vibration.spectra.standards import standard, standards
from ftcfa.vibration.synthesis import SpectralLines, spectral_lines

ROUNDING = 1e-9
"""Relative; sums of some hundred cosines of arguments known to 1e-13."""
SIGNIFICANCE = 1e-6
TRUCK = standard("mil_std_810g_highway_truck_vertical").spectrum


def phases(lines, seed=0):
    return np.random.default_rng(seed).uniform(0, 2 * np.pi, len(lines))


@pytest.mark.parametrize("name", standards())
@pytest.mark.parametrize("spacing", ["uniform", "equal_power"])
@pytest.mark.parametrize("count", [1, 7, 500])
def test_the_lines_carry_all_the_power(name, spacing, count):
    spectrum = standard(name).spectrum
    lines = spectral_lines(spectrum, count, spacing)
    assert lines.rms() == pytest.approx(spectrum.rms(), rel=ROUNDING)
    assert abs(len(lines) - count) <= 1
    assert np.all(np.diff(lines.frequencies) > 0)
    slack = 0.5 * (spectrum.band[1] - spectrum.band[0]) / count
    assert lines.frequencies[0] >= spectrum.band[0] - slack
    assert lines.frequencies[-1] <= spectrum.band[1] + slack


@pytest.mark.parametrize("name", standards())
def test_the_power_up_to_any_frequency(name):
    """Of 500 lines, the power below f differs from the integral by half a line's at most."""
    spectrum = standard(name).spectrum
    for spacing in ("uniform", "equal_power"):
        lines = spectral_lines(spectrum, 500, spacing)
        below = np.cumsum(0.5 * lines.amplitudes**2)
        half = 0.25 * lines.amplitudes**2
        exact = [
            quad(spectrum.density, spectrum.band[0], f, points=spectrum.frequencies, limit=400)[0]
            for f in np.clip(lines.frequencies[::50], *spectrum.band)
        ]
        middle = (below - half)[::50]
        assert np.all(np.abs(middle - exact) <= half[::50] * 1.01 + 1e-6 * spectrum.rms() ** 2)


def test_each_uniform_line_has_the_power_around_it():
    lines = spectral_lines(TRUCK, 490)
    np.testing.assert_allclose(np.diff(lines.frequencies), 1.0)
    for k in (1, 30, 200):
        f = lines.frequencies[k]
        power = quad(TRUCK.density, f - 0.5, f + 0.5, points=[40.0])[0]
        assert 0.5 * lines.amplitudes[k] ** 2 == pytest.approx(power)


def test_it_repeats_and_has_its_level_for_any_phases():
    lines = spectral_lines(TRUCK, 490)
    assert lines.period == pytest.approx(1.0)
    t = np.arange(2048) / 2048.0
    for seed in range(3):
        y = lines.evaluate(t, phases(lines, seed))
        np.testing.assert_allclose(
            lines.evaluate(t + 3.0, phases(lines, seed)), y, atol=1e-9 * TRUCK.rms()
        )
        assert np.sqrt(np.mean(y**2)) == pytest.approx(TRUCK.rms(), rel=ROUNDING)


def test_a_sum_by_hand():
    lines = SpectralLines(np.array([1.0, 2.5]), np.array([2.0, 3.0]), 2.0)
    phi = np.array([0.3, 1.0])
    t = 0.7
    exact = 2 * math.cos(2 * math.pi * t + 0.3) + 3 * math.cos(5 * math.pi * t + 1.0)
    assert lines.evaluate(t, phi) == pytest.approx(exact)
    assert lines.evaluate(np.array([[t, 0.0]]), phi).shape == (1, 2)
    assert lines.rms() == pytest.approx(math.sqrt((4 + 9) / 2))


@pytest.mark.parametrize("step", [1e-4, 0.01, 0.05])
def test_the_integral_over_a_step(step):
    lines = spectral_lines(TRUCK, 20)
    phi = phases(lines)
    for start in (0.0, 0.37, 12.0):
        nodes, weights = np.polynomial.legendre.leggauss(100)
        t = start + 0.5 * step * (1 + nodes)
        exact = 0.5 * step * weights @ lines.evaluate(t, phi)
        assert lines.integrate(start, step, phi) == pytest.approx(exact, rel=1e-7, abs=1e-10)
    joined = lines.integrate(np.array([0.0, step]), step, phi).sum()
    assert joined == pytest.approx(lines.integrate(0.0, 2 * step, phi), rel=1e-9, abs=1e-12)


def test_it_is_gaussian_over_random_phases():
    lines = spectral_lines(TRUCK, 400, "equal_power")
    rng = np.random.default_rng(5)
    angle = rng.uniform(0, 2 * np.pi, (4000, len(lines)))
    values = np.cos(angle) @ lines.amplitudes / lines.rms()
    assert stats.kstest(values, "norm").pvalue > SIGNIFICANCE


def test_its_welch_spectrum_is_the_table():
    """Windows of 0.25 s see some 30 lines each; the mean over the band is right to 5 %."""
    lines, rate = spectral_lines(TRUCK, 4 * 490), 2000.0
    y = lines.evaluate(np.arange(8 * 2000) / rate, phases(lines))
    f, estimate = signal.welch(y, rate, nperseg=500, detrend=False)
    band = (f > 30) & (f < 450)
    ratio = estimate[band] / TRUCK.density(f[band])
    assert ratio.mean() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("count", [0, -3, 2.5, "many"])
def test_a_number_of_lines(count):
    with pytest.raises(ParameterError, match=r"spectral_lines lines: .*, expected an integer >= 1"):
        spectral_lines(TRUCK, count)


def test_an_unknown_spacing():
    with pytest.raises(ParameterError) as refused:
        spectral_lines(TRUCK, 5, "logarithmic")
    assert str(refused.value) == (
        'spectral_lines spacing: \'logarithmic\', expected "uniform" or "equal_power"'
    )


def test_one_phase_a_line():
    lines = spectral_lines(Spectrum([1, 2], [1, 1]), 5, "equal_power")
    with pytest.raises(
        ShapeError, match=r"SpectralLines phases: shape \(4,\), expected shape \(5,\)"
    ):
        lines.evaluate(0.0, np.zeros(4))
