"""Exact intervals of a share: their defining equations and their exact coverage."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ftcfa.errors import ParameterError
from ftcfa.statistics.proportions import proportion

EQUATION = 1e-6
"""Tolerance of a tail probability, where SciPy finds the bound as a root."""


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 300), st.data(), st.floats(0.5, 0.999))
def test_bounds_solve_the_tail_equations(n, data, confidence):
    """Clopper-Pearson: at a bound, the count or a more extreme one has the tail probability."""
    k = data.draw(st.integers(0, n))
    value, low, high = proportion(k, n, confidence)
    assert value == k / n
    tail = (1 - confidence) / 2
    assert low == 0 if k == 0 else stats.binom.sf(k - 1, n, low) == pytest.approx(tail, EQUATION)
    assert high == 1 if k == n else stats.binom.cdf(k, n, high) == pytest.approx(tail, EQUATION)


@pytest.mark.parametrize(("n", "most"), [(20, 0.995), (50, 0.98), (200, 0.97), (1000, 0.96)])
def test_exact_coverage_never_falls_below_95_percent(n, most):
    """Summed over all outcomes. Counts are whole, so for few paths it is above 95 % by design."""
    estimates = np.array([proportion(k, n) for k in range(n + 1)])
    for share in np.linspace(0.1, 0.9, 81):
        covers = (estimates[:, 1] <= share) & (share <= estimates[:, 2])
        coverage = stats.binom.pmf(np.arange(n + 1), n, share) @ covers
        assert 0.95 <= coverage <= most


@pytest.mark.parametrize(
    ("successes", "trials", "confidence", "text"),
    [
        (0, 0, 0.95, "trials: 0, expected an integer >= 1"),
        (3, 2, 0.95, "successes: 3, expected an integer from 0 to 2"),
        (-1, 2, 0.95, "successes: -1, expected an integer from 0 to 2"),
        (0.5, 2, 0.95, "successes: 0.5, expected an integer from 0 to 2"),
        (1, 2, 95.0, "confidence of a proportion: 95.0, expected a number between 0 and 1"),
    ],
)
def test_errors(successes, trials, confidence, text):
    with pytest.raises(ParameterError, match=text.replace("(", r"\(")):
        proportion(successes, trials, confidence)
