"""Kaplan-Meier of settling times: published data, closed forms, and how often the band covers."""

import numpy as np
import pytest
from scipy import stats

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.kaplan_meier import settling_distribution

NAN = np.nan
FREIREICH = (6, 6, 6, 7, 10, 13, 16, 22, 23, 6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35)
"""Remission of 21 patients on 6-MP [weeks]; the first nine are complete (Freireich et al. 1963)."""
PUBLISHED = {6: 0.857, 7: 0.807, 10: 0.753, 13: 0.690, 16: 0.627, 22: 0.538, 23: 0.448}
"""Kaplan-Meier survival of these data in Kalbfleisch and Prentice, section 1.1.2."""


def test_published_estimate():
    seen = np.array(FREIREICH, dtype=float)
    settled = np.where(np.arange(21) < 9, seen, NAN)
    result = settling_distribution(settled, seen)
    assert (result.settled, result.censored, result.diverged) == (9, 12, 0)
    for time, survival in PUBLISHED.items():
        share = result.share.value[result.time == time]
        assert share == pytest.approx(1 - survival, abs=6e-4)
    median = result.quantile(0.5)  # R's survfit(conf.type = "log-log"): 23 (13, NA)
    assert (median.value, median.low, median.high) == (23.0, 13.0, np.inf)


def test_without_censoring_it_is_the_empirical_distribution():
    t = np.random.default_rng(0).permutation(np.arange(1.0, 101.0))
    result = settling_distribution(t, 200.0)
    np.testing.assert_allclose(result.share.value, np.arange(101) / 100)
    assert np.all(result.share.low <= result.share.value)
    assert np.all(result.share.high >= result.share.value)
    assert np.all(np.diff(result.share.low) >= 0)
    assert np.all(np.diff(result.share.high) >= 0)
    for p in (0.05, 0.5, 0.95, 0.99):
        assert result.quantile(p).value == np.quantile(t, p, method="inverted_cdf")


def test_greenwood_at_a_time_by_hand():
    """Share settled 40 of 100: log(-log S) -+ z sqrt(F/(n S)) / |log S|."""
    t = np.where(np.arange(100) < 40, 1.0, NAN)
    result = settling_distribution(t, np.full(100, 5.0), confidence=0.9)
    S, z = 0.6, stats.norm.ppf(0.95)
    width = z * np.sqrt(0.4 / (100 * S)) / abs(np.log(S))
    np.testing.assert_array_equal(result.time, [0.0, 1.0, 5.0])
    assert result.share.low[1] == pytest.approx(1 - S ** np.exp(-width))
    assert result.share.high[1] == pytest.approx(1 - S ** np.exp(width))


def test_a_path_that_diverged_never_settles():
    settled_at = np.array([1.0, 2.0, NAN, NAN, NAN, NAN, 3.0, 4.0])
    ends = np.array([5.0, 5.0, 0.5, 5.0, 5.0, 1.5, 5.0, 5.0])
    diverged = np.arange(8) == 2
    result = settling_distribution(settled_at, ends, diverged)
    assert (result.settled, result.censored, result.diverged) == (4, 3, 1)
    by_hand = 1 - np.cumprod([7 / 8, 1, 5 / 6, 4 / 5, 3 / 4, 1])  # at risk: 8, -, 6, 5, 4, -
    np.testing.assert_array_equal(result.time, [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0])
    np.testing.assert_allclose(result.share.value, [0.0, *by_hand])
    assert result.quantile(0.9).value == np.inf


def test_nobody_and_everybody_settles():
    never = settling_distribution([NAN] * 5, 2.0)
    none = 1 - 0.025**0.2  # nobody of five: Clopper-Pearson
    np.testing.assert_allclose(never.share, [[0.0, 0.0], [0.0, 0.0], [none, none]])
    assert never.quantile(0.5).value == np.inf
    always = settling_distribution([1.0] * 5, 2.0)
    np.testing.assert_allclose(always.share, [[0.0, 1.0], [0.0, 1 - none], [none, 1.0]])
    assert always.quantile(0.5).value == 1.0


def test_a_small_quantile_may_lie_before_the_first_path():
    """Of 20 paths none is among the fastest 5 % in 36 % of the cases; of 200, in 3e-5."""
    t = 1.0 + np.random.default_rng(0).standard_exponential(200)
    few, many = (settling_distribution(t[:n], 100.0).quantile(0.05) for n in (20, 200))
    assert (few.low, few.value) == (0.0, t[:20].min())
    assert many.low >= t.min()


@pytest.mark.parametrize(
    ("paths", "together", "least", "most"),
    [(50, False, 0.93, 0.97), (200, False, 0.93, 0.97), (50, True, 0.94, 0.98)],
)
def test_coverage_of_the_band_and_of_quantiles(paths, together, least, most):
    """1,000 ensembles of exponential settling times, a third of them not settled at the end."""
    rng, ensembles = np.random.default_rng(1), 1000
    end = np.log(3.0)
    share = quantile = 0
    for _ in range(ensembles):
        t = rng.standard_exponential(paths)
        ends = end if together else np.full(paths, end)
        result = settling_distribution(np.where(t <= end, t, NAN), ends)
        i = np.searchsorted(result.time, 0.5, side="right") - 1
        share += result.share.low[i] <= 1 - np.exp(-0.5) <= result.share.high[i]
        _, low, high = result.quantile(0.5)
        quantile += low <= np.log(2.0) <= high
    assert least <= share / ensembles <= most
    assert least <= quantile / ensembles <= most


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        (([], 1.0), ShapeError, "settled_at: shape (0,), expected shape (paths,), one or more"),
        (([1.0], [1.0, 2.0]), ShapeError, "end: shape (2,), expected a scalar or shape (1,)"),
        (([1.0], NAN), ParameterError, "end: nan, expected finite times [s]"),
        (
            ([1.0, 3.0], 2.0),
            ParameterError,
            "settled_at: path 1 at 3 s, its run ended at 2 s, expected times within the run",
        ),
        (([1.0], 2.0, False, 1.0), ParameterError, "confidence of the settling times: 1.0"),
    ],
)
def test_errors(arguments, error, text):
    with pytest.raises(error) as caught:
        settling_distribution(*arguments)
    assert text in str(caught.value)


def test_error_of_a_quantile():
    with pytest.raises(ParameterError, match="quantile of the settling time: 50"):
        settling_distribution([1.0], 2.0).quantile(50)
