"""What a specification becomes: the loop's own numbers, and the spectrum that they have."""

import numpy as np
import pytest
from scipy import integrate, signal, stats

from ftcfa import (
    ParameterError,
    RandomPhase,
    Record,
    RecordedAcceleration,
    ShapedNoise,
    ShapeError,
    WhiteNoise,
    estimate_spectrum,
    realise,
    simulate,
    standard,
)
from ftcfa.study.realised_spectrum import realise_standard
from ftcfa.vibration.spectra.section_fit import DB, DB_TOLERANCE

from .masses import AGREEMENT, CONFIDENCE, pushed

TRUCK = "mil_std_810g_highway_truck_vertical"
FAMILIES = (TRUCK, "gevs_qualification", "astm_d4169_truck_low")
HANN = 2
"""Half of the width of a Hann window's main lobe, in frequencies of the estimate."""
RIPPLE_DB = 0.05
"""Curvature of a table over the main lobe, fifty lines from 0 Hz."""
SUM_OF_LINES = 0.01
"""Share of the rms that three periods, rounded to steps, and the mean over a step take away."""


def recorded():
    values = np.random.default_rng(0).standard_normal((300, 2))
    values = signal.sosfilt(signal.butter(4, 50.0, fs=1e3, output="sos"), values, axis=0)
    return RecordedAcceleration(Record(1e-3, values))


EXCITATIONS = {
    "white": (WhiteNoise([0.1, 0.4]), 1e-3),
    "shaped": (ShapedNoise.from_psd(TRUCK, "astm_d4169_truck_low"), 2.5e-4),
    "recorded": (recorded(), 1e-3),
    "random phase": (RandomPhase((TRUCK, TRUCK), 20), 2.5e-4),
    "sum": (WhiteNoise(0.1) + recorded(), 1e-3),
}


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
@pytest.mark.parametrize("name", EXCITATIONS)
def test_it_is_what_shakes_a_loop(name, engine):
    """A free unit mass, v_{k+1} - v_k = Y_k, past the chunks in which noise is drawn."""
    excitation, step = EXCITATIONS[name]
    steps = 5000 if engine == "compiled" else 200
    loop = pushed(excitation, 2, period=step)
    v = simulate(loop, steps * step, seed=3, path=5, engine=engine).v.values
    values = realise(excitation, 2, steps * step, step, seed=3, path=5)
    assert values.shape == (steps, 2)
    np.testing.assert_allclose(np.diff(v, axis=0) / step, values, rtol=0, atol=AGREEMENT / step)


def test_substeps_are_steps():
    excitation, _ = EXCITATIONS["shaped"]
    v = simulate(pushed(excitation, 2, substeps=4), 0.1).v.values
    values = realise(excitation, 2, 0.1, 2.5e-4).reshape(100, 4, 2).sum(axis=1) * 2.5e-4
    np.testing.assert_allclose(np.diff(v, axis=0), values, atol=AGREEMENT)


@pytest.mark.parametrize("name", ["white", "recorded", "random phase"])
def test_seeds_and_paths_differ(name):
    excitation, step = EXCITATIONS[name]
    runs = [
        realise(excitation, 2, 20 * step, step, seed=seed, path=path)
        for seed, path in ((0, 0), (0, 1), (1, 0))
    ]
    assert not any(np.allclose(runs[i], runs[j]) for i, j in ((0, 1), (0, 2), (1, 2)))


@pytest.mark.parametrize(
    ("changes", "error", "text"),
    [
        ({"channels": 2}, ShapeError, "ShapedNoise: 1 channels, expected 2 channels"),
        ({"channels": 0}, ParameterError, "channels: 0, expected an integer >= 1"),
        ({"duration": 0.0}, ParameterError, "duration: 0.0, expected a number > 0"),
        ({"step": 1e-3}, ParameterError, "up to 500 Hz"),
        ({"step": -1e-3}, ParameterError, "step: -0.001, expected a number > 0"),
        ({"seed": -1}, ParameterError, "seed: -1"),
        ({"path": 0.5}, ParameterError, "path: 0.5"),
    ],
)
def test_bad_arguments(changes, error, text):
    arguments = {"channels": 1, "duration": 0.1, "step": 2.5e-4, "seed": 0, "path": 0, **changes}
    with pytest.raises(error, match=text):
        realise(ShapedNoise(TRUCK), **arguments)


def test_the_estimate_of_noise_of_known_density():
    """Independent values of variance one have the density 2 h: mean and scatter over channels."""
    channels, step, length = 2000, 0.1, 64
    values = np.random.default_rng(1).standard_normal((10 * length, channels))
    found = estimate_spectrum(values, step, 1.0 / (length * step))
    k = int(np.argmin(np.abs(found.frequencies * step - 1 / 4)))
    exact = 2 * step / np.sinc(1 / 4) ** 2
    ratio = found.densities[k] / exact
    freedom = 2 * channels / found.standard_error**2
    low, high = stats.chi2.interval(CONFIDENCE, freedom) / np.float64(freedom)
    assert low < ratio.mean() < high
    scatter = ratio.std(ddof=1) / found.standard_error  # a chi2 has the kurtosis 3 + 6 error^2
    assert abs(scatter - 1.0) < 5 * np.sqrt((2 + 6 * found.standard_error**2) / 4 / channels)
    np.testing.assert_allclose(found.rms, np.sqrt(np.mean(values**2, axis=0)))
    assert found.segments == 37  # (640 - 64)/16 + 1
    np.testing.assert_allclose(np.diff(found.frequencies), found.frequencies[0])
    assert found.frequencies[0] == pytest.approx(1 / 6.4)


def test_the_estimate_of_a_sine():
    """Amplitude 3 at 50 Hz: 4.5 of power, whatever the mean over a step takes away."""
    step, f = 1 / 400, 50.0
    t = step * np.arange(4000)
    means = 3.0 * (np.sin(2 * np.pi * f * (t + step)) - np.sin(2 * np.pi * f * t))
    found = estimate_spectrum((means / (2 * np.pi * f * step))[:, None], step, 1.0)
    near = np.abs(found.frequencies - f) < 3.5
    assert found.densities[near, 0].sum() == pytest.approx(4.5, rel=0.01)  # at the middle's sinc
    assert found.densities[~near, 0].sum() < 1e-6


@pytest.mark.parametrize(
    ("values", "resolution", "error", "text"),
    [
        (np.zeros(100), 100.0, ShapeError, r"realised values: shape \(100,\)"),
        (np.zeros((100, 1)), 1.0, ParameterError, "segments of 1000 steps, expected .* 8 to 100"),
        (np.zeros((100, 1)), 200.0, ParameterError, "segments of 5 steps"),
        (np.zeros((100, 1)), 0.0, ParameterError, "resolution: 0.0"),
    ],
)
def test_estimates_that_cannot_be(values, resolution, error, text):
    with pytest.raises(error, match=text):
        estimate_spectrum(values, 1e-3, resolution)


@pytest.fixture(scope="module")
def families():
    return {name: realise_standard(standard(name), seed=1) for name in FAMILIES}


def band_of(one, estimate):
    """Frequencies of an estimate in the band, and its densities there."""
    low, high = one.standard.spectrum.band
    inside = (estimate.frequencies >= low) & (estimate.frequencies <= high)
    return estimate.frequencies[inside], estimate.densities[inside, 0]


@pytest.mark.parametrize("name", FAMILIES)
def test_the_realised_spectrum_is_the_specified_one(families, name):
    """Within 1.5 dB, the resolution, and the error that the estimate states."""
    one = families[name]
    f, S = band_of(one, one.shaped)
    assert len(f) >= 190
    near = HANN * np.linspace(-1, 1, 81) * one.shaped.frequencies[0]
    specified = one.standard.spectrum.density(
        np.clip(f[:, None] + near, *one.standard.spectrum.band)
    )
    freedom = 2 / one.shaped.standard_error**2
    bins = 1 - (1 - CONFIDENCE) / len(f)
    low, high = DB * np.log(stats.chi2.interval(bins, freedom) / np.float64(freedom))
    assert high < 2.5  # it does state something
    assert np.all(DB * np.log(S / specified.max(axis=1)) < DB_TOLERANCE + high)
    assert np.all(DB * np.log(S / specified.min(axis=1)) > -DB_TOLERANCE + low)


@pytest.mark.parametrize("name", FAMILIES)
def test_the_realised_level_is_the_filters(families, name):
    """Mean square of T seconds of Gaussian noise: variance integral of S^2 over T."""
    one = families[name]
    f = np.geomspace(one.standard.spectrum.band[0] / 100, 40 / one.step, 100_000)
    S = one.fit.filter.density(f)[:, 0] * np.sinc(f * one.step) ** 2
    power, square = integrate.trapezoid(S, f), integrate.trapezoid(S**2, f)
    deviation = one.shaped.rms[0] ** 2 - power
    assert abs(deviation) < 5 * np.sqrt(square / one.duration)
    assert np.sqrt(square / one.duration) < 0.05 * power


@pytest.mark.parametrize("name", FAMILIES)
def test_the_spectrum_of_lines_has_no_ripple(families, name):
    """As many segments of every phase of the period: where the table is smooth, it is met."""
    one = families[name]
    f, S = band_of(one, one.tones)
    ends, df = one.standard.spectrum.frequencies, one.tones.frequencies[0]
    smooth = np.all(np.abs(f[:, None] - ends) > 5 * df, axis=1) & (f > 50 * df)
    deviation = DB * np.log(S / one.standard.spectrum.density(f))
    assert smooth.sum() > 20
    assert np.abs(deviation[smooth]).max() < RIPPLE_DB


@pytest.mark.parametrize("name", FAMILIES)
def test_the_sum_of_lines_has_the_specified_level(families, name):
    one = families[name]
    f = np.linspace(*one.standard.spectrum.band, 100_000)
    S = one.standard.spectrum.density(f) * np.sinc(f * one.step) ** 2
    assert one.tones.rms[0] == pytest.approx(np.sqrt(integrate.trapezoid(S, f)), rel=SUM_OF_LINES)
