"""Random phases: the power of the tables, uniform phases, the period, what is refused."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from ftcfa import (
    ParameterError,
    RandomPhase,
    Spectrum,
    UnknownNameError,
    simulate_paths,
    standard,
    standards,
)
from ftcfa.vibration.excitations.random_phase import spectral_lines

from ..masses import CONFIDENCE, pushed, run_process

ROUNDING = 1e-9
"""Relative; sums of some hundred cosines of arguments known to 1e-13, or some hundred thousand
steps of 1e-16 and cancellation of two in w h."""
TRUCK = "mil_std_810g_highway_truck_vertical"
TRUCK_SPECTRUM = standard(TRUCK).spectrum


@pytest.mark.parametrize("name", standards())
@pytest.mark.parametrize("count", [1, 7, 500])
def test_the_lines_carry_all_the_power(name, count):
    spectrum = standard(name).spectrum
    lines = spectral_lines(spectrum, count)
    power = 0.5 * np.sum(lines.amplitudes**2)
    assert power == pytest.approx(spectrum.rms() ** 2, rel=ROUNDING)
    assert abs(len(lines.frequencies) - count) <= 1
    assert np.all(np.diff(lines.frequencies) > 0)
    slack = 0.5 * (spectrum.band[1] - spectrum.band[0]) / count
    assert lines.frequencies[0] >= spectrum.band[0] - slack
    assert lines.frequencies[-1] <= spectrum.band[1] + slack


@pytest.mark.parametrize("name", standards())
def test_the_power_up_to_any_frequency(name):
    """Of 500 lines, the power below f differs from the integral by half a line's at most."""
    spectrum = standard(name).spectrum
    lines = spectral_lines(spectrum, 500)
    below = np.cumsum(0.5 * lines.amplitudes**2)
    half = 0.25 * lines.amplitudes**2
    exact = [
        quad(spectrum.density, spectrum.band[0], f, points=spectrum.frequencies, limit=400)[0]
        for f in np.clip(lines.frequencies[::50], *spectrum.band)
    ]
    middle = (below - half)[::50]
    assert np.all(np.abs(middle - exact) <= half[::50] * 1.01 + 1e-6 * spectrum.rms() ** 2)


def test_each_line_has_the_power_around_it():
    lines = spectral_lines(TRUCK_SPECTRUM, 490)
    np.testing.assert_allclose(np.diff(lines.frequencies), 1.0)
    for k in (1, 30, 200):
        f = lines.frequencies[k]
        power = quad(TRUCK_SPECTRUM.density, f - 0.5, f + 0.5, points=[40.0])[0]
        assert 0.5 * lines.amplitudes[k] ** 2 == pytest.approx(power)


def test_it_is_gaussian_over_random_phases():
    lines = spectral_lines(TRUCK_SPECTRUM, 400)
    angle = np.random.default_rng(5).uniform(0, 2 * np.pi, (4000, len(lines.frequencies)))
    values = np.cos(angle) @ lines.amplitudes / TRUCK_SPECTRUM.rms()
    assert stats.kstest(values, "norm").pvalue > 1 - CONFIDENCE


@pytest.mark.parametrize("count", [0, -3, 2.5, "many"])
def test_a_number_of_lines(count):
    with pytest.raises(ParameterError, match=r"spectral_lines lines: .*, expected an integer >= 1"):
        spectral_lines(TRUCK_SPECTRUM, count)


def angles(process, paths, seed=0):
    """Phases at time zero of many paths, shape (paths, lines)."""
    normals = np.random.default_rng(seed).standard_normal((paths, process.initial_normals))
    W, Y = np.array([process.init(own) for own in normals]).transpose(1, 0, 2)
    turn, s = process.w * 1e-3, W / process.sizes
    c = (Y / process.sizes + (1 - np.cos(turn)) * s) / np.sin(turn)
    np.testing.assert_allclose(c**2 + s**2, 1.0, rtol=1e-12)
    return np.mod(np.arctan2(s, c), 2 * np.pi)


@pytest.mark.parametrize("lines", [4, 5])
def test_random_phases_are_uniform_and_independent(lines):
    phases = angles(RandomPhase(Spectrum([10.0, 20.0], [1.0, 1.0]), lines).process(1, 1e-3), 5000)
    count = phases.shape[1]
    turn = 2 * np.pi
    for i in range(count):
        assert stats.kstest(phases[:, i] / turn, "uniform").pvalue > 1 - CONFIDENCE
        for j in range(i):  # sums and differences of independent uniform phases are uniform
            for combined in (phases[:, i] + phases[:, j], phases[:, i] - phases[:, j]):
                share = np.mod(combined, turn) / turn
                assert stats.kstest(share, "uniform").pvalue > 1 - CONFIDENCE
            table = np.histogram2d(phases[:, i], phases[:, j], 5, [[0, turn], [0, turn]])[0]
            assert stats.chisquare(table.ravel()).pvalue > 1 - CONFIDENCE


@pytest.mark.parametrize("name", standards())
def test_random_phases_carry_the_power_of_the_table(name):
    """Over a period, by Parseval: the overall level, and the power of each line's interval."""
    spectrum, lines = standard(name).spectrum, 50
    excitation = RandomPhase(name, lines)
    (period,) = excitation.period
    low, high = spectrum.band
    steps = 2 * int(5 * (high + (high - low) / lines) * period)  # ten a shortest period
    h = period / steps
    process = excitation.process(1, h)
    initial = np.random.default_rng(1).standard_normal(process.initial_normals)
    Y, *_ = run_process(process, steps, initial=initial)
    f = np.fft.rfftfreq(steps, h)
    amplitudes = 2 * np.abs(np.fft.rfft(Y[:, 0])) / steps / (h * np.sinc(f * h))
    powers = 0.5 * amplitudes**2
    assert np.sqrt(powers.sum()) / 9.80665 == pytest.approx(spectrum.g_rms(), rel=ROUNDING)
    np.testing.assert_allclose(
        np.sqrt(powers.sum()) / 9.80665, standard(name).nominal_g_rms, rtol=0.05
    )
    df = 1 / period
    inside = np.flatnonzero((f > low + df) & (f < high - df))
    for k in inside[::5]:
        ends = f[k] - df / 2, f[k] + df / 2
        corners = [x for x in spectrum.frequencies if ends[0] < x < ends[1]]
        power = quad(spectrum.density, *ends, points=corners or None)[0]
        assert powers[k] == pytest.approx(power, rel=1e-6)
    np.testing.assert_allclose(powers[f > high + df], 0.0, atol=ROUNDING * powers.max())


def test_it_repeats_after_its_period_and_every_path_has_its_level():
    excitation = RandomPhase(TRUCK, 49)
    assert excitation.period == pytest.approx([0.1])  # 490 Hz in 49 parts
    loop = pushed(excitation, period=2.5e-4)
    Y = np.diff(simulate_paths(loop, 5, 0.2).v.values[:, :, 0], axis=1)
    np.testing.assert_allclose(Y[:, :400], Y[:, 400:], atol=1e-9 * np.abs(Y).max())
    level = np.sqrt(np.mean(Y[:, :400] ** 2, axis=1))
    np.testing.assert_allclose(level, level[0], rtol=1e-9)


def test_what_random_phases_refuse():
    with pytest.raises(UnknownNameError, match="gevs_acceptance"):
        RandomPhase("highway")
    with pytest.raises(ParameterError, match="spectrum: 3, expected a standard's"):
        RandomPhase((TRUCK, 3))
    with pytest.raises(ParameterError, match="RandomPhase axes: none, expected a spectrum"):
        RandomPhase(())
    with pytest.raises(ParameterError, match="RandomPhase lines: 0, expected an integer >= 1"):
        RandomPhase(TRUCK, 0)
