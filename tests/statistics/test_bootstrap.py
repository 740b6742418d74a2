"""Paired bootstrap: against the exact interval of a mean, and what pairs are for."""

import numpy as np
import pytest

from ftcfa.statistics.bootstrap import paired_bootstrap


def mean(values):
    return values["x"].mean(axis=-1)


def high(values):
    return np.quantile(values["x"], 0.95, axis=-1, method="higher")


@pytest.fixture
def rows():
    rng = np.random.default_rng(1)
    common = rng.lognormal(size=400)
    return np.stack([common, common + 0.1 + 0.02 * rng.standard_normal(400)])


def test_the_interval_of_a_mean_is_that_of_student(rows):
    low, top = paired_bootstrap(mean, {"x": rows}, 0)
    difference = rows[1] - rows[0]
    half = 1.966 * difference.std(ddof=1) / 20.0  # Student, 399 degrees of freedom
    assert low[1] == pytest.approx(difference.mean() - half, abs=0.15 * half)
    assert top[1] == pytest.approx(difference.mean() + half, abs=0.15 * half)


def test_what_rows_have_in_common_cancels(rows):
    low, top = paired_bootstrap(high, {"x": rows}, 0)
    assert 0.05 < low[1] < 0.1 < top[1] < 0.15  # a quantile of 400 lognormals alone has +-0.8
    assert low[0] == top[0] == 0.0


def test_diverged_paths_are_in_doubt_not_equal():
    rows = np.ones((2, 40))
    rows[:, :10] = np.inf
    low, top = paired_bootstrap(high, {"x": rows}, 0)
    assert low[1] == -np.inf
    assert top[1] == np.inf
    rows[1] = 1.0
    assert paired_bootstrap(high, {"x": rows}, 0)[1][1] == -np.inf  # surely less
