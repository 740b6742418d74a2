"""Shaped noise of every standard: its level, its spectrum, stationary from the first sample."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal, stats
from scipy.integrate import quad

from ftcfa import (
    TRUCK,
    LinearFilter,
    ParameterError,
    Road,
    ShapedNoise,
    Spectrum,
    simulate_paths,
    standard,
    standards,
)
from ftcfa.vibration.excitations import shaped_noise
from ftcfa.vibration.spectra.spectrum import step_limit

from ..masses import CONFIDENCE, check_engines, pushed

HIGHWAY = "mil_std_810g_highway_truck_vertical"
LEVEL = 0.04
"""The fit's 3 % of the rms, and 1 % for how sinc weighs what lies outside the band."""
SEGMENT = 16_384
WELCH_DB = 1.25
"""Five standard deviations of Welch's estimate: 64 paths of 7 half-overlapping Hann segments count
as some 280 independent ones, 0.26 dB."""
FIT_DB = 1.5


def limit(name):
    return step_limit(standard(name).spectrum.band[1])


@pytest.mark.parametrize("name", standards())
def test_the_level_of_the_integrals(name):
    """E[Y^2] against the table's integral of S(f) h^2 sinc(f h)^2."""
    step, spectrum = limit(name), standard(name).spectrum
    sampled = ShapedNoise(name).process(1, step).filter
    P = sampled.root @ sampled.root.T
    variance = (sampled.C @ P @ sampled.C.T + sampled.D @ sampled.D.T)[0, 0]
    exact = sum(
        quad(lambda f: spectrum.density(f) * (step * np.sinc(f * step)) ** 2, low, high)[0]
        for low, high in zip(spectrum.frequencies[:-1], spectrum.frequencies[1:], strict=True)
    )
    assert np.sqrt(variance / exact) == pytest.approx(1.0, abs=LEVEL)


@pytest.mark.parametrize("name", standards())
def test_it_is_stationary_from_the_first_sample(name):
    """The covariance of the state by one step more, and the variance over paths."""
    step, paths = limit(name), 2000
    sampled = ShapedNoise(name).process(1, step).filter
    P = sampled.root @ sampled.root.T
    after = sampled.A @ P @ sampled.A.T + sampled.B @ sampled.B.T
    size = np.sqrt(np.diag(P))
    np.testing.assert_allclose(after / np.outer(size, size), P / np.outer(size, size), atol=1e-9)
    v = simulate_paths(pushed(ShapedNoise(name), period=step), paths, 50 * step).v.values
    Y = np.diff(v[:, :, 0], axis=1)
    exact = (sampled.C @ P @ sampled.C.T + sampled.D @ sampled.D.T)[0, 0]
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    for k in (0, 1, 49):
        assert low < np.mean(Y[:, k] ** 2) / exact < high


@pytest.mark.parametrize("name", standards())
def test_the_realised_spectrum(name):
    """Welch over 64 paths, against the table and, more closely, the filter's own density."""
    step, spectrum = limit(name), standard(name).spectrum
    noise = ShapedNoise(name)
    loop = pushed(noise, period=step)
    v = simulate_paths(loop, 64, (4 * SEGMENT + 0.5) * step).v.values[:, :, 0]
    f, density = signal.welch(np.diff(v, axis=1) / step, 1 / step, nperseg=SEGMENT)
    bin = f[1]
    low, high = spectrum.band
    inside = (f > low + 3 * bin) & (f < high - 3 * bin)
    f, density = f[inside], density.mean(axis=0)[inside] / np.sinc(f[inside] * step) ** 2
    own = noise.filters[0].density(f)[:, 0]
    assert np.abs(10 * np.log10(density / own)).max() < WELCH_DB
    assert np.abs(10 * np.log10(density / spectrum.density(f))).max() < FIT_DB + WELCH_DB


def test_a_name_a_spectrum_a_filter_and_a_road_side_by_side():
    lags = LinearFilter(-np.diag([3.0, 40.0]), np.eye(2), np.eye(2))
    noise = ShapedNoise((HIGHWAY, lags, Road("C", 20.0, TRUCK), standard(HIGHWAY).spectrum))
    assert [one.outputs for one in noise.filters] == [1, 2, 1, 1]
    assert len(noise.fits) == 2
    assert noise.fits[0] is noise.fits[1]  # the same points
    road = Road("C", 20.0, TRUCK).filter()
    np.testing.assert_array_equal(noise.filters[2].C, road.C)
    loop = pushed(noise, 5, period=2.5e-4)
    integrable = [loop.process.why_no_integrals(k) == "" for k in range(5)]
    assert integrable == [True, False, False, False, True]
    check_engines(loop)


def test_one_axis_needs_no_brackets():
    lag = LinearFilter([[-3.0]], [[1.0]], [[1.0]])
    for axis in (HIGHWAY, standard(HIGHWAY), standard(HIGHWAY).spectrum, lag, Road("A", 10.0)):
        noise = ShapedNoise(axis)
        assert noise.axes == (axis,) == ShapedNoise.from_psd(axis).axes == ShapedNoise([axis]).axes
        sampled = noise.process(1, 2.5e-4).filter
        assert sampled.A.shape == (noise.filters[0].order,) * 2


def test_a_fit_is_made_once():
    assert ShapedNoise(HIGHWAY).fits[0] is ShapedNoise.from_psd(standard(HIGHWAY)).fits[0]


def test_a_fit_that_does_not_fit_warns_with_its_own_sentence():
    cliff = Spectrum([10.0, 20.0, 20.001, 40.0], [1.0, 1.0, 1e-4, 1e-4])
    noise = ShapedNoise(cliff)
    with pytest.warns(UserWarning, match=r"shaping filter of order .*: NOT within the tolerance"):
        noise.process(1, 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        noise.process(1, 1e-3)
        ShapedNoise(HIGHWAY).process(1, 2.5e-4)


def test_a_step_too_long_is_refused_before_anything_is_fitted():
    wild = Spectrum(np.geomspace(1.0, 990.0, 40), 10.0 ** (np.arange(40) % 2))
    with pytest.raises(ParameterError, match="up to 990 Hz"):
        pushed(ShapedNoise(wild))


@pytest.mark.parametrize("axes", [(), []])
def test_no_axes(axes):
    with pytest.raises(ParameterError, match="ShapedNoise axes: none, expected a spectrum"):
        ShapedNoise(axes)


def test_a_fit_within_only_the_tolerance_of_edges_warns_too(monkeypatch):
    fit = replace(ShapedNoise(HIGHWAY).fits[0], worst_db=2.0, edge_db=1.0)
    monkeypatch.setattr(shaped_noise, "_fitted", lambda spectrum: fit)  # noqa: ARG005
    with pytest.warns(UserWarning, match="within, if frequency may be off by 2 %"):
        assert ShapedNoise(HIGHWAY).fits == (fit,)


def resonance(f):
    w = 2 * np.pi * f
    return LinearFilter([[0.0, 1.0], [-(w**2), -0.02 * w]], [[0.0], [1.0]], [[0.0, 1.0]])


def test_a_step_too_long_for_a_filter_warns():
    """A resonance of little damping is held as a tone is: 8 steps a period, 125 Hz at 1 ms."""
    message = "integration step: 1 ms, within which a filter's output changes; take substeps=4 of"
    with pytest.warns(UserWarning, match=message):
        ShapedNoise(resonance(400.0)).process(1, 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ShapedNoise(resonance(400.0)).process(1, 2.5e-4)
        ShapedNoise(resonance(115.0)).process(1, 1e-3)
        ShapedNoise(Road("C", 20.0, TRUCK)).process(1, 1e-3)
