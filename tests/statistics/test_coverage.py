"""How often 95 % intervals cover a known truth, over 1,000 small ensembles.

The ensembles are the trailing axis, so that one call computes them all. Two processes have exact
transitions and known laws: Ornstein-Uhlenbeck from x = 1, and the oscillator shaken by white noise
from rest.
"""

import numpy as np
import pytest
from scipy import linalg, stats

from ftcfa.statistics.moments import Moments
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantile_sketch import QuantileSketch
from ftcfa.statistics.quantiles import quantile_ranks

ENSEMBLES = 1000
LEVELS = np.array([0.05, 0.25, 0.5, 0.75, 0.95])
STEPS, STEP = 10, 0.05
CONFIDENCE = 1 - 1e-6
"""Confidence of the checks on a thousand ensembles."""


def transition(A, B):
    """Exact step of x' = A x + B xi, unit white xi: matrix and root of covariance (Van Loan)."""
    n = len(A)
    E = linalg.expm(np.block([[-A, B @ B.T], [np.zeros((n, n)), A.T]]) * STEP)
    P = E[n:, n:].T
    return P, np.linalg.cholesky(P @ E[:n, n:])


def simulate(A, B, x0, paths, seed):
    """First state at the end, shape (paths, ensembles)."""
    P, L = transition(A, B)
    rng = np.random.default_rng(seed)
    x = np.broadcast_to(x0[:, None, None], (len(x0), paths, ENSEMBLES))
    for _ in range(STEPS):
        x = np.tensordot(P, x, 1) + np.tensordot(L, rng.standard_normal(x.shape), 1)
    return x[0]


def ornstein_uhlenbeck(paths, seed=0):
    """x' = -x + xi from 1: mean e^-t, variance (1 - e^-2t)/2."""
    x = simulate(-np.eye(1), np.eye(1), np.ones(1), paths, seed)
    t = STEPS * STEP
    return x, np.exp(-t), np.sqrt((1 - np.exp(-2 * t)) / 2)


def oscillator(paths, seed=0):
    """x'' + x' + 100 x = xi from rest (zeta = 0.05, w = 10): variance 0.0020343 after 0.5 s."""
    A = np.array([[0.0, 1.0], [-100.0, -1.0]])
    x = simulate(A, np.array([[0.0], [1.0]]), np.zeros(2), paths, seed)
    return x, 0.0, np.sqrt(0.0020343)


def coverage(estimate, truth):
    return np.mean((estimate.low <= truth) & (truth <= estimate.high), axis=-1)


@pytest.mark.parametrize("process", [ornstein_uhlenbeck, oscillator])
@pytest.mark.parametrize("paths", [20, 50, 200])
def test_means_and_mean_squares(process, paths):
    x, mean, deviation = process(paths)
    assert 0.93 <= coverage(Moments.of(x).student(), mean) <= 0.97
    square = mean**2 + deviation**2
    assert 0.93 <= coverage(Moments.of(x**2).skewness_corrected(), square) <= 0.97


def test_students_interval_of_a_mean_square_covers_too_rarely():
    """This is why the skewness is corrected."""
    x, _, deviation = oscillator(20)
    assert coverage(Moments.of(x**2).student(), deviation**2) < 0.91


@pytest.mark.parametrize("process", [ornstein_uhlenbeck, oscillator])
@pytest.mark.parametrize(("paths", "most"), [(20, 0.985), (200, 0.968), (1000, 0.96)])
def test_quantiles(process, paths, most):
    """As often as the binomial law of the ranks says: 95 % or more, whole numbers allow no less."""
    x, mean, deviation = process(paths)
    _, low, high = quantile_ranks(LEVELS, paths, 0.95)
    exact = stats.binom.cdf(high - 1, paths, LEVELS) - stats.binom.cdf(low - 1, paths, LEVELS)
    assert np.all((exact >= 0.95) & (exact <= most))
    truth = stats.norm.ppf(LEVELS, mean, deviation)[:, None]
    covered = coverage(QuantileSketch.of(x).quantile(LEVELS), truth)
    least, largest = stats.binom.interval(CONFIDENCE, ENSEMBLES, exact)
    assert np.all(covered * ENSEMBLES >= least)
    if paths < 1000:  # beyond, the width of a bin widens the interval and it covers more often
        assert np.all(covered * ENSEMBLES <= largest)


@pytest.mark.parametrize("process", [ornstein_uhlenbeck, oscillator])
def test_proportions_of_200_paths(process):
    """Share within one deviation of zero; the intervals are exact, so they cover a little more."""
    x, mean, deviation = process(200)
    law = stats.norm(mean, deviation)
    truth = law.cdf(deviation) - law.cdf(-deviation)
    counts = np.sum(np.abs(x) < deviation, axis=0)
    intervals = {k: proportion(int(k), 200) for k in np.unique(counts)}
    covers = {k: low <= truth <= high for k, (_, low, high) in intervals.items()}
    covered = np.mean([covers[k] for k in counts])
    assert 0.93 <= covered <= 0.97


def test_paired_and_unpaired_means_of_two_loops():
    """Common noise leaves the coverage as it is and narrows the interval."""
    x, mean, _ = ornstein_uhlenbeck(50)
    y = 0.9 * x + 0.05 * np.random.default_rng(1).standard_normal(x.shape)
    difference = Moments.of(x - y).student()
    assert 0.93 <= coverage(difference, 0.1 * mean) <= 0.97
    alone = Moments.of(x).student()
    assert np.all(difference.high - difference.low < 0.3 * (alone.high - alone.low))
