"""Moments over paths: against NumPy on the whole array, and how often their intervals cover."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.moments import Moments, paired_differences

ROUNDING = 1e-10
"""Relative; sums of some hundred numbers in another order."""
FIELDS = ("count", "missing", "average", "M2", "M3")


def chunks(values, cuts):
    parts = np.split(values, sorted(cuts))
    merged = Moments.of(parts[0])
    for part in parts[1:]:
        merged = merged.merge(Moments.of(part))
    return merged


def scale(values, k):
    """Size of the terms of the k-th central power sum."""
    return 1e-300 + np.nansum(np.abs(values - np.nanmean(values, axis=0)) ** k, axis=0)


def test_against_numpy_and_scipy():
    x = np.random.default_rng(0).gamma(2.0, size=(50, 4, 3))
    moments = Moments.of(x)
    np.testing.assert_allclose(moments.mean, x.mean(0), rtol=ROUNDING)
    np.testing.assert_allclose(moments.variance, x.var(0, ddof=1), rtol=ROUNDING)
    np.testing.assert_allclose(moments.M3 / 50, stats.moment(x, 3), rtol=ROUNDING)
    oracle = stats.ttest_1samp(x, 0.0).confidence_interval(0.9)
    value, low, high = moments.student(0.9)
    np.testing.assert_allclose(low, oracle.low, rtol=ROUNDING)
    np.testing.assert_allclose(high, oracle.high, rtol=ROUNDING)
    np.testing.assert_array_equal(value, moments.mean)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    cuts=st.lists(st.integers(0, 40), max_size=5),
    offset=st.sampled_from([0.0, 1.0, -1e4]),
    missing=st.booleans(),
)
def test_any_chunking_gives_the_same(seed, cuts, offset, missing):
    rng = np.random.default_rng(seed)
    x = offset + rng.standard_exponential((40, 3))
    if missing:
        x[rng.random(x.shape) < 0.3] = np.nan
    whole, merged = Moments.of(x), chunks(x, cuts)
    np.testing.assert_array_equal(merged.count, whole.count)
    np.testing.assert_array_equal(merged.missing, whole.missing)
    assert np.all(np.abs(merged.average - whole.average) <= ROUNDING * (1 + abs(offset)))
    assert np.all(np.abs(merged.M2 - whole.M2) <= ROUNDING * (1 + abs(offset)) * scale(x, 2))
    assert np.all(np.abs(merged.M3 - whole.M3) <= ROUNDING * (1 + abs(offset)) * scale(x, 3))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.tuples(*[st.integers(1, 30)] * 3))
def test_merging_is_associative_and_commutative(seed, sizes):
    rng = np.random.default_rng(seed)
    x = [rng.standard_exponential((size, 2)) for size in sizes]
    a, b, c = map(Moments.of, x)
    left, right, turned = a.merge(b).merge(c), a.merge(b.merge(c)), c.merge(b).merge(a)
    for k, name in enumerate(FIELDS):
        slack = ROUNDING * (1 + scale(np.concatenate(x), max(k - 1, 1)))
        for other in (right, turned):
            assert np.all(np.abs(getattr(left, name) - getattr(other, name)) <= slack)


def test_the_same_chunks_give_the_same_bits():
    x = np.random.default_rng(1).standard_normal((300, 7, 2))
    first, second = chunks(x, [100, 200]), chunks(x.copy(), [100, 200])
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_an_offset_does_not_drown_the_spread():
    x = 1e6 + np.random.default_rng(2).standard_normal((1000, 1)) * 1e-3
    exact = np.var(x - 1e6, axis=0, ddof=1)
    np.testing.assert_allclose(chunks(x, [10, 500]).variance, exact, rtol=1e-6)


def test_paths_that_diverged_are_counted_and_make_the_mean_undefined():
    x = np.array([[1.0, 1.0], [3.0, np.nan], [8.0, 5.0], [4.0, np.inf]])
    moments = Moments.of(x)
    np.testing.assert_array_equal(moments.missing, [0, 2])
    np.testing.assert_array_equal(moments.mean, [4.0, np.nan])
    for statistic in (moments.variance, *moments.skewness_corrected()):
        np.testing.assert_array_equal(np.isnan(statistic), [False, True])
    np.testing.assert_allclose(moments.without_missing().mean, [4.0, 3.0])


def test_no_path_with_a_value():
    moments = Moments.of(np.full((3, 1), np.nan)).merge(Moments.of(np.full((2, 1), np.nan)))
    assert np.isnan(moments.without_missing().mean)
    assert np.all(np.isnan(moments.without_missing().student()))
    merged = moments.merge(Moments.of([[2.0], [4.0]])).without_missing()
    np.testing.assert_allclose(merged.mean, [3.0])
    np.testing.assert_allclose(merged.variance, [2.0])


def test_one_path_has_no_interval_and_equal_paths_a_point():
    assert np.isnan(Moments.of([2.0]).student().low)
    assert Moments.of([2.0]).mean == 2.0
    for estimate in (Moments.of([2.0] * 5).student(), Moments.of([2.0] * 5).skewness_corrected()):
        np.testing.assert_array_equal(estimate, [2.0, 2.0, 2.0])


def test_the_correction_is_students_interval_for_a_symmetric_sample():
    x = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
    np.testing.assert_allclose(Moments.of(x).skewness_corrected(), Moments.of(x).student())


def test_the_correction_inverts_halls_cubic():
    """T + (a/3) T^2 + (a^2/27) T^3 + a/6 is Student's t, T = (average - mean) sqrt(n)/s."""
    x = np.random.default_rng(3).standard_exponential(30)
    a = stats.skew(x) / np.sqrt(30)
    _, low, high = Moments.of(x).skewness_corrected(0.9)
    for end, t in ((low, stats.t.ppf(0.95, 29)), (high, stats.t.ppf(0.05, 29))):
        T = (x.mean() - end) * np.sqrt(30) / x.std(ddof=1)
        assert T + a / 3 * T**2 + a**2 / 27 * T**3 + a / 6 == pytest.approx(t)


def test_paired_differences_against_scipy():
    rng = np.random.default_rng(4)
    noise = rng.standard_normal((30, 2))
    a, b = noise + 0.1 * rng.standard_normal((30, 2)), noise - 0.5
    oracle = stats.ttest_rel(a, b).confidence_interval(0.95)
    value, low, high = paired_differences(a, b).student()
    np.testing.assert_allclose(value, np.mean(a - b, axis=0))
    np.testing.assert_allclose([low, high], [oracle.low, oracle.high])
    unpaired = stats.ttest_ind(a, b).confidence_interval(0.95)
    assert np.all(high - low < 0.2 * (unpaired.high - unpaired.low))
    a[3, 0], b[3, 0] = np.inf, np.inf
    np.testing.assert_array_equal(paired_differences(a, b).missing, [1, 0])


@pytest.mark.parametrize(
    ("act", "error", "text"),
    [
        (lambda: Moments.of(3.0), ShapeError, "a single number, expected shape (paths, ...)"),
        (
            lambda: Moments.of(np.ones((3, 2))).merge(Moments.of(np.ones((3, 4)))),
            ShapeError,
            "Moments: shape (4,), expected (2,)",
        ),
        (
            lambda: paired_differences(np.ones(3), np.ones(4)),
            ShapeError,
            "shapes (3,) and (4,), expected equal shapes",
        ),
        (
            lambda: Moments.of([1.0, 2.0]).student(95),
            ParameterError,
            "Moments confidence: 95, expected a number between 0 and 1; give 0.95 for 95 percent",
        ),
        (
            lambda: Moments.of([1.0, 2.0]).skewness_corrected(1.0),
            ParameterError,
            "Moments confidence: 1.0, expected a number between 0 and 1",
        ),
    ],
)
def test_errors(act, error, text):
    with pytest.raises(error) as caught:
        act()
    assert text in str(caught.value)
