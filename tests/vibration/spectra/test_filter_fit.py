"""Shaping filters fitted to break-point tables: how well, how steady, how honest."""

import math

import numpy as np
import pytest
from scipy import signal, stats

from ftcfa.errors import ParameterError
from ftcfa.vibration.spectra.filter_fit import fit_filter
from ftcfa.vibration.spectra.section_fit import DB_TOLERANCE, RMS_TOLERANCE, Sections
from ftcfa.vibration.spectra.spectrum import Spectrum, step_limit
from ftcfa.vibration.spectra.standards import standard, standards

HIGHEST_ORDER = 14
"""The standards need 12 at most; another machine's rounding may need one pair more."""
GRID = 0.02
"""A grid of one's own may find a slightly larger deviation between the points of the report's
[dB]."""
TRAPEZOID = 1e-3
"""Relative accuracy of the trapezoid rule on 20,000 frequencies a decade."""
SIGNIFICANCE = 1e-6
"""A right spectrum leaves its bounds, in any of its bins, one time in a million."""
LEAKAGE = 0.03
"""What a Hann window smears, relative, at a resolution of some 2 Hz where spectra are smooth."""


@pytest.fixture(scope="module")
def fits():
    return {name: fit_filter(one.spectrum) for name, one in standards().items()}


def density_by_modes(filter, f):
    """2 |sum_i (C v_i) (w_i B)/(2 pi i f - lambda_i)|^2, from the eigenvectors of A."""
    values, V = np.linalg.eig(filter.A)
    weight = (filter.C @ V)[0] * np.linalg.solve(V, filter.B.astype(complex))[:, 0]
    return 2.0 * np.abs(np.sum(weight / (2j * np.pi * f[:, None] - values), axis=1)) ** 2


@pytest.mark.parametrize("name", standards())
def test_every_standard_is_met(fits, name):
    fit, spectrum = fits[name], standard(name).spectrum
    assert fit.within_tolerance
    assert fit.filter.order <= HIGHEST_ORDER
    low, high = spectrum.band
    f = np.unique(np.concatenate([np.geomspace(low, high, 5000)[1:-1], spectrum.frequencies]))
    deviation = 10.0 * np.log10(density_by_modes(fit.filter, f) / spectrum.density(f))
    assert np.abs(deviation).max() <= min(DB_TOLERANCE, abs(fit.worst_db) + GRID)
    assert abs(fit.edge_db) <= abs(fit.worst_db)


@pytest.mark.parametrize("name", standards())
def test_the_level_of_a_fit(fits, name):
    fit, spectrum = fits[name], standard(name).spectrum
    low, high = spectrum.band
    f = np.geomspace(low / 100, high * 100, 120_000)
    density = density_by_modes(fit.filter, f)
    overall = math.sqrt(np.trapezoid(density, f))
    inside = (f >= low) & (f <= high)
    assert overall == pytest.approx(float(fit.filter.rms()[0]), rel=TRAPEZOID)
    assert math.sqrt(np.trapezoid(density[inside], f[inside])) == pytest.approx(
        spectrum.rms(), rel=TRAPEZOID
    )
    assert fit.rms_error == pytest.approx(overall / spectrum.rms() - 1.0, abs=TRAPEZOID)
    assert abs(overall / spectrum.rms() - 1.0) <= RMS_TOLERANCE + TRAPEZOID
    assert fit.outside == pytest.approx(1.0 - (spectrum.rms() / overall) ** 2, abs=2 * TRAPEZOID)


@pytest.mark.parametrize("name", standards())
def test_velocity_and_displacement_stay_bounded(fits, name):
    """The density falls as f^4 towards zero: displacement has a finite one there."""
    f = standard(name).spectrum.band[0] * np.array([1e-3, 1e-4])
    first, second = fits[name].filter.density(f)[:, 0]
    assert first / second == pytest.approx(1e4, rel=1e-3)


def simulated(filter, step, paths, steps, seed):
    """Y/h of independent stationary paths, shape (paths, steps)."""
    sampled, rng = filter.discretise(step), np.random.default_rng(seed)
    x = sampled.root @ rng.standard_normal((filter.order, paths))
    means = np.empty((steps, paths))
    for k in range(steps):
        n = rng.standard_normal((sampled.normals, paths))
        means[k] = (sampled.C @ x + sampled.D @ n)[0] / step
        x = sampled.A @ x + sampled.B @ n
    return means.T


@pytest.mark.parametrize(
    "name", ["mil_std_810g_highway_truck_vertical", "gevs_acceptance", "astm_d4169_truck_high"]
)
def test_the_realised_spectrum_of_a_simulation(fits, name):
    """Welch's estimate of 256 paths, one window a path: a chi-squared of 512 degrees a bin.

    The mean over a step has the density S(f) sinc(f h)^2; at 8 steps in the shortest period what
    folds back from beyond the Nyquist frequency is far below it.
    """
    spectrum, filter, paths = standard(name).spectrum, fits[name].filter, 256
    step, (low, high) = step_limit(spectrum.band[1]), spectrum.band
    steps = 2 ** math.ceil(math.log2(20.0 / (low * step)))
    means = simulated(filter, step, paths, steps, seed=1)
    f, estimate = signal.welch(means, 1.0 / step, nperseg=steps, detrend=False, axis=1)
    band = (f > 1.2 * low) & (f < high / 1.2)
    f, estimate = f[band], estimate.mean(axis=0)[band]
    error = stats.chi2(2 * paths).isf(SIGNIFICANCE / len(f)) / (2 * paths) - 1.0
    held = np.sinc(f * step) ** 2
    exact = filter.density(f)[:, 0] * held
    assert np.abs(estimate / exact - 1.0).max() <= error + LEAKAGE
    deviation = 10.0 * np.log10(estimate / (spectrum.density(f) * held))
    assert np.abs(deviation).max() <= DB_TOLERANCE + 10.0 * np.log10(1.0 + error + LEAKAGE)


def test_a_simulation_is_stationary_from_its_first_sample(fits):
    filter, step, paths = fits["mil_std_810g_highway_truck_longitudinal"].filter, 0.25e-3, 20_000
    variance = filter.discretise(step).covariance(0)[0, 0] / step**2
    means = simulated(filter, step, paths, 60, seed=2)
    for k in (0, 1, 10, 59):
        chi = np.sum(means[:, k] ** 2) / variance
        assert SIGNIFICANCE < stats.chi2(paths).cdf(chi) < 1 - SIGNIFICANCE


def test_a_fit_is_the_same_every_time():
    spectrum = standard("mil_std_810g_highway_truck_transverse").spectrum
    one, two = fit_filter(spectrum), fit_filter(spectrum)
    for name in "ABC":
        np.testing.assert_array_equal(getattr(one.filter, name), getattr(two.filter, name))


def test_a_higher_order_fits_better():
    spectrum = standard("mil_std_810g_highway_truck_vertical").spectrum
    worst = [abs(fit_filter(spectrum, order=order).worst_db) for order in (4, 6, 8, 12)]
    assert [fit_filter(spectrum, order=order).filter.order for order in (4, 8)] == [4, 8]
    assert worst[0] > worst[1] > worst[3]


def test_a_step_that_no_filter_can_follow_is_reported():
    """20 dB within a hundred-thousandth of the frequency: half of it remains on either side."""
    fit = fit_filter(Spectrum([20, 100, 100.001, 500], [1, 1, 100, 100]))
    assert not fit.within_tolerance
    assert abs(fit.worst_db) == pytest.approx(10.0, abs=0.5)
    assert fit.worst_frequency == pytest.approx(100.0, rel=1e-3)
    assert abs(fit.edge_db) < abs(fit.worst_db)
    assert str(fit).endswith("NOT within the tolerance of 1.5 dB and 3 %")


@pytest.mark.xfail(
    strict=False,
    reason="without AVX-512 the search ends at 4.8 %: it rounds to GRID at its end, not at each "
    "solution; doing so changes the bits of half of the standards",
)
def test_a_step_that_no_filter_can_follow_keeps_the_level():
    fit = fit_filter(Spectrum([20, 100, 100.001, 500], [1, 1, 100, 100]))
    assert abs(fit.rms_error) <= RMS_TOLERANCE


def test_a_low_order_says_that_it_does_not_fit():
    fit = fit_filter(standard("astm_d4169_truck_low").spectrum, max_order=6)
    assert fit.filter.order <= 6
    assert not fit.within_tolerance
    assert "NOT within" in str(fit)


def test_the_text_of_a_fit(fits):
    fit = fits["mil_std_810g_highway_truck_vertical"]
    assert str(fit).startswith(
        f"shaping filter of order 6: {float(fit.filter.rms()[0]) / 9.80665:.4g} g rms against "
        f"1.043 ({100 * fit.rms_error:+.1f} %), {100 * fit.outside:.1f} % of the variance outside "
        "the band, largest deviation"
    )
    assert str(fit).endswith(
        "if frequency may be off by 2 %): within the tolerance of 1.5 dB and 3 %"
    )


@pytest.mark.parametrize("level", [1e-30, 1.0, 1e8])
@pytest.mark.parametrize("band", [(1e-3, 1e-2), (1.0, 1e4), (10.0, 100.0)])
def test_bands_and_levels_of_any_size(level, band):
    fit = fit_filter(Spectrum(band, [level, level]))
    assert fit.within_tolerance
    assert fit.filter.order <= 8


def test_partial_fractions_against_the_product_of_sections():
    rng = np.random.default_rng(0)
    poles = np.log(
        np.vstack([2 * np.pi * np.array([3.0, 11.0, 20.0, 70.0]), [0.4, 0.01, 0.1, 0.9]])
    )
    zeros = np.log(np.vstack([2 * np.pi * np.array([8.0, 33.0]), [0.05, 2.0]]))
    sections = Sections(2 * np.pi, -1.3, poles, zeros)
    f = np.exp(rng.uniform(np.log(0.1), np.log(1000.0), 200))
    w = 2 * np.pi * f[:, None]
    s = 1j * w / np.exp(zeros[0])
    product = np.prod(np.abs(s**2 + 2 * np.exp(zeros[1]) * s + 1) ** 2, axis=1)
    s = 1j * w / np.exp(poles[0])
    product /= np.prod(np.abs(s**2 + 2 * np.exp(poles[1]) * s + 1) ** 2, axis=1)
    product *= np.exp(-1.3) * f**4
    np.testing.assert_allclose(np.exp(sections.log_density(f)[0]), product, rtol=1e-10)
    np.testing.assert_allclose(sections.realised().density(f)[:, 0], product, rtol=1e-8)


def test_the_derivatives_of_the_log_density():
    sections = Sections(
        6.0, 0.2, np.log([[60.0, 300.0, 90.0], [0.3, 0.02, 0.5]]), np.log([[150.0], [0.1]])
    )
    f, vector = np.array([5.0, 20.0, 24.0, 100.0]), sections.vector
    derivatives = sections.log_density(f)[1]
    for k in range(len(vector)):
        nudge = 1e-6 * np.eye(len(vector))[k]
        above, below = (sections.moved(vector + sign * nudge) for sign in (1, -1))
        slope = (above.log_density(f)[0] - below.log_density(f)[0]) / 2e-6
        np.testing.assert_allclose(derivatives[:, k], slope, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("order", [3, 2, 5.0, "six", True, 0])
def test_an_order_is_even(order):
    spectrum = Spectrum([10, 100], [1, 1])
    with pytest.raises(
        ParameterError, match=r"fit_filter order: .*, expected an even integer >= 4"
    ):
        fit_filter(spectrum, order=order)
    with pytest.raises(
        ParameterError, match=r"fit_filter .*order: .*, expected an even integer >= 4"
    ):
        fit_filter(spectrum, max_order=order)
