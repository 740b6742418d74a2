"""Break-point spectra: exact integrals, what is refused, and the step that a band asks for."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad

from ftcfa.errors import ParameterError
from ftcfa.vibration.spectra.spectrum import (
    STANDARD_GRAVITY,
    Spectrum,
    check_step,
    step_limit,
    substeps_needed,
)

QUADRATURE = 1e-9
"""Relative accuracy of scipy.integrate.quad."""
TRUCK = ([10, 40, 500], [0.015, 0.015, 0.00015])
SI_TRUCK = Spectrum.from_g(*TRUCK)

ratios = st.lists(st.floats(1.01, 5.0), min_size=1, max_size=8)
logs = st.lists(st.floats(-3.0, 3.0), min_size=9, max_size=9)


def made(ratios, logs, first=2.0):
    f = first * np.cumprod([1.0, *ratios])
    return Spectrum(f, 10.0 ** np.array(logs[: len(f)]))


def log_line(f, points):
    """The straight line in log-log through neighbouring break points, by hand."""
    for (f1, s1), (f2, s2) in pairwise(points):
        if f1 <= f <= f2:
            return s1 * (f / f1) ** (math.log(s2 / s1) / math.log(f2 / f1))
    return 0.0


@given(ratios, logs, st.floats(0.5, 30.0))
def test_density_is_a_straight_line_in_log_log(ratios, logs, f):
    spectrum = made(ratios, logs)
    points = list(zip(spectrum.frequencies, spectrum.densities, strict=True))
    assert spectrum.density(f) == pytest.approx(log_line(f, points), rel=1e-9)
    np.testing.assert_allclose(spectrum.density(spectrum.frequencies), spectrum.densities)


def test_density_is_zero_outside_the_band():
    np.testing.assert_array_equal(SI_TRUCK.density([0.0, 1.0, 9.999, 500.001, 1e6]), np.zeros(5))


@given(ratios, logs)
def test_power_is_the_integral_of_the_density(ratios, logs):
    spectrum = made(ratios, logs)
    total = 0.0
    for low, high in pairwise(spectrum.frequencies):
        total += quad(spectrum.density, low, high, epsrel=QUADRATURE)[0]
        assert spectrum.power(high) == pytest.approx(total, rel=10 * QUADRATURE)
    assert spectrum.rms() == pytest.approx(math.sqrt(total), rel=10 * QUADRATURE)
    middle = math.sqrt(spectrum.band[0] * spectrum.frequencies[1])
    part = quad(spectrum.density, spectrum.band[0], middle, epsrel=QUADRATURE)[0]
    assert spectrum.power(middle) == pytest.approx(part, rel=10 * QUADRATURE)


@pytest.mark.parametrize("slope", [-1.0, -1.0 + 1e-13, -1.0 - 1e-9, 0.0, -2.0, 3.0])
def test_power_around_the_slope_of_one_over_f(slope):
    spectrum = Spectrum([10.0, 100.0], [1.0, 10.0**slope])
    exact = (
        10.0 * math.log(10.0)
        if abs(slope + 1) < 1e-6
        else 10 * (10 ** (slope + 1) - 1) / (slope + 1)
    )
    assert spectrum.power(100.0) == pytest.approx(exact, rel=1e-8)


def test_units_and_level():
    assert SI_TRUCK.density(20.0) == pytest.approx(0.015 * 9.80665**2)
    assert SI_TRUCK.g_rms() == pytest.approx(SI_TRUCK.rms() / STANDARD_GRAVITY)
    assert SI_TRUCK.scaled(2.0).rms() == pytest.approx(2.0 * SI_TRUCK.rms())
    assert str(SI_TRUCK) == "1.04 g rms from 10 to 500 Hz"


@pytest.mark.parametrize(
    ("f", "S", "message"),
    [
        (
            [10, 40],
            [0.1, -0.1],
            "Spectrum density 2: -0.1, expected a number > 0; outside the band the density "
            "is zero anyway: leave such points out; or check the sign",
        ),
        ([10, 40], [0.0, 0.1], "Spectrum density 1: 0, expected a number > 0; outside the band"),
        ([10, 40], [np.nan, 0.1], "Spectrum density 1: nan, expected a number > 0"),
        ([10, 40], [np.inf, 0.1], "Spectrum density 1: inf, expected a number > 0"),
        (
            [0, 40],
            [0.1, 0.1],
            "Spectrum frequency 1: 0, expected a number > 0 Hz; the logarithmic axis has no zero; "
            "begin the band above it",
        ),
        ([-1, 40], [0.1, 0.1], "Spectrum frequency 1: -1, expected"),
        (
            [10, 40, 20],
            [0.1, 0.1, 0.1],
            "Spectrum frequencies 2 and 3: 40 then 20 Hz, expected rising frequencies; sort them",
        ),
        (
            [10, 40, 40],
            [0.1, 0.1, 0.2],
            "Spectrum frequencies 2 and 3: 40 then 40 Hz (duplicate), expected rising frequencies; "
            "part the two sides of a step by a small difference",
        ),
        (
            [10],
            [0.1],
            "Spectrum: frequencies of shape (1,), densities of shape (1,), expected two break "
            "points or more, one density for each frequency; a single tone is a harmonic",
        ),
        ([], [], "Spectrum: frequencies of shape (0,), densities of shape (0,), expected two"),
        ([10, 40], [0.1], "Spectrum: frequencies of shape (2,), densities of shape (1,)"),
        ([[10, 40]], [[0.1, 0.1]], "Spectrum: frequencies of shape (1, 2)"),
        (["ten", 40], [0.1, 0.1], "Spectrum frequencies: ['ten', 40], expected numbers"),
    ],
)
def test_what_is_no_spectrum_is_refused(f, S, message):
    for build in (Spectrum, Spectrum.from_g):
        with pytest.raises(ParameterError) as refused:
            build(f, S)
        assert str(refused.value).startswith(message)


def test_a_table_in_the_wrong_unit_is_questioned():
    with pytest.raises(ParameterError) as refused:
        Spectrum.from_g([20, 2000], [100.0, 100.0])
    assert str(refused.value) == (
        "Spectrum densities: 445 g rms overall when read as g^2/Hz, expected at most 60 g rms; if "
        "they are in (m/s^2)^2/Hz, build Spectrum(frequencies, densities) or state unit = "
        '"(m/s^2)^2/Hz" in a table; if the level is meant, give plausible_g_rms = 1000'
    )
    assert Spectrum([20, 2000], [100.0, 100.0]).g_rms() == pytest.approx(445 / 9.80665, rel=1e-3)
    assert Spectrum.from_g([20, 2000], [1e2, 1e2], plausible_g_rms=1000).g_rms() > 400


@pytest.mark.parametrize("factor", [0, -1.0, np.nan, "two"])
def test_a_factor_is_positive(factor):
    with pytest.raises(ParameterError, match=r"Spectrum factor: .*, expected a number > 0"):
        SI_TRUCK.scaled(factor)


def test_a_spectrum_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        SI_TRUCK.densities[0] = 1.0


def test_the_step_that_500_hz_ask_for():
    assert step_limit(500.0) == 0.25e-3
    assert substeps_needed(500.0, 1e-3) == 4
    check_step(500.0, 0.25e-3)
    with pytest.raises(ParameterError) as refused:
        check_step(500.0, 0.5e-3)
    assert str(refused.value) == (
        "integration step: 0.5 ms, for frequencies up to 500 Hz, expected at most 0.25 ms (8 steps "
        "in the shortest period); take substeps=2 of the period 0.5 ms, or a shorter period"
    )


@given(st.floats(1e-5, 1.0), st.floats(20.0, 5000.0))
def test_the_substeps_needed_are_the_least_that_pass(period, highest):
    needed = substeps_needed(highest, period)
    check_step(highest, period / needed)
    assert period / needed <= step_limit(highest) * (1 + 1e-9)
    assume(needed > 1)
    with pytest.raises(ParameterError):
        check_step(highest, period / (needed - 1))
