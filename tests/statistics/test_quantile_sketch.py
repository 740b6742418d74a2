"""The sketch of quantiles: its accuracy, its independence of chunks, paths that diverged."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.quantile_sketch import MISSING, RELATIVE_ACCURACY, QuantileSketch
from ftcfa.statistics.quantiles import sample_quantile

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
SMALLEST, LARGEST = 2.0**-30, 2.0**30
SINGLE = 2.0**-23
"""Relative rounding of single precision, by which a bin's edge may be off."""


def close(read, exact):
    return np.all(np.abs(read - exact) <= RELATIVE_ACCURACY * np.abs(exact) + SMALLEST)


@settings(max_examples=100, deadline=None)
@given(
    x=st.lists(st.floats(-LARGEST / 2, LARGEST / 2), min_size=1, max_size=50),
    p=st.floats(0.01, 0.99),
)
def test_against_the_sorted_sample(x, p):
    exact = sample_quantile(x, p)
    read = QuantileSketch.of(x).quantile(p)
    assert close(read.value, exact.value)
    for wide, sharp, outwards in ((read.low, exact.low, -1), (read.high, exact.high, 1)):
        if np.isinf(sharp):
            assert wide == sharp
        else:  # by one bin at most
            size = abs(sharp)
            assert (wide - sharp) * outwards >= -SINGLE * size
            assert abs(wide - sharp) <= 2 * ((RELATIVE_ACCURACY + SINGLE) * size + SMALLEST)


@pytest.mark.parametrize("magnitude", [1e-9, 1e-6, 0.3, 1.0, 50.0, 1e5, 1e9])
def test_the_range_holds_angles_and_torques(magnitude):
    x = magnitude * np.linspace(0.95, 1.05, 1001)[:, None] * [1.0, -1.0]
    value = QuantileSketch.of(x).quantile(LEVELS).value
    exact = np.quantile(x, LEVELS, axis=0, method="inverted_cdf")
    assert np.all(np.abs(value / exact - 1) <= RELATIVE_ACCURACY)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), cuts=st.lists(st.integers(0, 60), max_size=5))
def test_any_chunking_gives_the_same_bits(seed, cuts):
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((60, 3, 2)) * np.exp(10 * rng.standard_normal((60, 3, 2)))
    x[rng.random(x.shape) < 0.1] = np.nan
    whole, added = QuantileSketch.of(x), QuantileSketch.empty((3, 2))
    for part in np.split(x, sorted(cuts)):
        added.add(np.asfortranarray(part))
    np.testing.assert_array_equal(added.counts, whole.counts)
    np.testing.assert_array_equal(whole.paths, np.full((3, 2), 60))


def test_shapes():
    sketch = QuantileSketch.of(np.random.default_rng(0).standard_normal((50, 4, 3)))
    for estimate in sketch.quantile(LEVELS):
        assert estimate.shape == (5, 4, 3)
    for estimate in sketch.quantile(0.5):
        assert estimate.shape == (4, 3)
    for estimate in QuantileSketch.of([1.0, 2.0]).quantile(0.5):
        assert estimate.shape == ()


def test_a_path_that_diverged_is_larger_than_all_others():
    x = np.array([1.0] * 6 + [np.nan, np.nan, np.inf, -np.inf])
    sketch = QuantileSketch.of(x)
    assert (sketch.counts[MISSING], sketch.paths) == (4, 10)
    assert close(sketch.quantile(0.6).value, 1.0)
    assert sketch.quantile(0.61).value == np.inf
    assert np.isnan(QuantileSketch.empty(()).quantile(0.5).value)


def test_zeros_and_what_is_beyond_the_bins():
    sketch = QuantileSketch.of(np.array([-1e12, -1e-12, -0.0, 1e-12, 1e12]))
    value = sketch.quantile((0.1, 0.5, 0.9)).value
    np.testing.assert_array_equal(value, [-np.inf, 0.0, np.inf])
    assert sketch.counts[MISSING] == 0
    assert QuantileSketch.of([1e12] * 20).quantile(0.5).low == LARGEST


def test_errors():
    sketch = QuantileSketch.empty((3,))
    with pytest.raises(ShapeError, match=r"shape \(5, 2\), expected \(paths, 3\)"):
        sketch.add(np.ones((5, 2)))
    with pytest.raises(ParameterError, match=r"quantile: 1\.0, expected a number between 0 and 1"):
        sketch.quantile(1.0)
