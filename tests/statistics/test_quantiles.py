"""Quantiles by ranks: against SciPy and against the exact binomial coverage."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.quantiles import quantile_ranks, sample_quantile

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
ROUNDING = 1e-12


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 200),
    p=st.floats(0.01, 0.99),
    confidence=st.floats(0.5, 0.999),
)
def test_against_scipy(seed, n, p, confidence):
    x = np.random.default_rng(seed).standard_normal(n)
    value, low, high = sample_quantile(x, p, confidence)
    assert value == np.quantile(x, p, method="inverted_cdf")
    oracle = stats.quantile_test(x, p=p).confidence_interval(confidence)
    assert low == (-np.inf if np.isnan(oracle.low) else oracle.low)
    assert high == (np.inf if np.isnan(oracle.high) else oracle.high)


@settings(max_examples=100, deadline=None)
@given(n=st.integers(1, 500), p=st.floats(0.01, 0.99), confidence=st.floats(0.5, 0.999))
def test_exact_coverage_is_what_was_asked_or_more_on_both_sides(n, p, confidence):
    _, low, high = quantile_ranks(np.asarray(p), n, confidence)
    tail = (1 - confidence) / 2
    assert stats.binom.cdf(low - 1, n, p) <= tail + ROUNDING
    assert stats.binom.sf(high - 1, n, p) <= tail + ROUNDING
    assert stats.binom.cdf(low, n, p) > tail - ROUNDING  # and the ranks are the closest such
    assert high == low or stats.binom.sf(high - 2, n, p) > tail - ROUNDING


@pytest.mark.parametrize(
    ("n", "p", "documented"),
    [(20, 0.5, 0.959), (200, 0.5, 0.960), (20, 0.05, 0.984), (200, 0.05, 0.967)],
)
def test_the_documented_coverage(n, p, documented):
    _, low, high = quantile_ranks(np.asarray(p), n, 0.95)
    coverage = stats.binom.cdf(high - 1, n, p) - stats.binom.cdf(low - 1, n, p)
    assert coverage == pytest.approx(documented, abs=6e-4)


def test_too_few_paths_and_those_that_never_did():
    value, low, high = sample_quantile([3.0, 1.0, np.inf, 2.0], LEVELS)
    np.testing.assert_array_equal(value, [1.0, 1.0, 2.0, 3.0, np.inf])
    np.testing.assert_array_equal(low, [-np.inf, -np.inf, -np.inf, 1.0, 3.0])
    np.testing.assert_array_equal(high[3:], [np.inf, np.inf])


@pytest.mark.parametrize(
    ("values", "p", "confidence", "error", "text"),
    [
        ([], 0.5, 0.95, ShapeError, "shape (0,), expected shape (paths,), one or more"),
        ([[1.0]], 0.5, 0.95, ShapeError, "shape (1, 1), expected"),
        ([1.0, np.nan], 0.5, 0.95, ParameterError, "1 NaN, expected numbers; give +inf"),
        ([1.0], [0.5, 0.0], 0.95, ParameterError, "quantile: 0.0, expected a number between"),
        ([1.0], 95, 0.95, ParameterError, "quantile: 95.0, expected"),
        ([1.0], 0.5, 1.5, ParameterError, "confidence of a quantile: 1.5, expected"),
    ],
)
def test_errors(values, p, confidence, error, text):
    with pytest.raises(error) as caught:
        sample_quantile(values, p, confidence)
    assert text in str(caught.value)
