"""How often the intervals that `ensemble` gives cover a known truth, over 1,000 small ensembles.

`test_coverage.py` asks the same of the statistics alone and tells where 95 % is not quite what one
gets: quantiles and proportions count paths, whole numbers, and so cover a little more. Here the
whole chain is tested, from the random streams to the Dataset. An ensemble of 25 independent
oscillators is 25 ensembles; all have the same truth.

The truth is that of the discrete loop: with the torque u = -k q - d v held over a period h, a step
is linear, x+ = A x + b n with a standard normal n, so that the covariance is the sum of
A^i b b^T A^i^T; as h vanishes it becomes the closed form of the continuous oscillator.
"""

import numpy as np
import pytest
from scipy import stats
from small_loops import oscillators

from ftcfa import ensemble
from ftcfa.statistics.proportions import proportion

JOINTS, RUNS, PATHS = 25, 40, 200
ENSEMBLES = JOINTS * RUNS
DURATION, PERIOD = 0.5, 1e-2
OSCILLATOR = (100.0, 1.0)
"""x'' + x' + 100 x = xi: w = 10 rad/s, zeta = 0.05."""
ORNSTEIN_UHLENBECK = (0.0, 1.0)
"""v' = -v + xi, seen as the torque u = -v."""
TORQUE = 0.1
"""Two thirds of all first torques are smaller [N]."""
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
CONFIDENCE = 1 - 1e-6
"""Of what a thousand ensembles show."""


def covariance(k, d, period=PERIOD):
    """Of (x, v) at the end, from rest under Euler-Maruyama."""
    A = np.array([[1.0, period], [-k * period, 1.0 - d * period]])
    b = np.array([[0.0], [np.sqrt(period)]])
    P = np.zeros((2, 2))
    for _ in range(round(DURATION / period)):
        P = A @ P @ A.T + b @ b.T
    return P


def test_the_truth_tends_to_the_continuous_one():
    """Closed forms: EQUATIONS of the oscillator from rest, and (1 - e^-2t)/2."""
    x = covariance(*OSCILLATOR, period=1e-5)[0, 0]
    assert x == pytest.approx(0.0020343, rel=1e-3)
    v = covariance(*ORNSTEIN_UHLENBECK, period=1e-5)[1, 1]
    assert v == pytest.approx((1 - np.exp(-2 * DURATION)) / 2, rel=1e-3)


def run(gains, duration=DURATION):
    """Datasets of some seeds."""
    loop = oscillators(JOINTS, *gains, period=PERIOD)
    every = round(duration / PERIOD)
    options = {"chunk": 64, "record_every": every}
    return [ensemble(loop, PATHS, duration, seed=seed, **options) for seed in range(RUNS)]


def at_end(datasets, name):
    """A statistic at the end, shape (seed, bound, ..., joint)."""
    return np.array([dataset[name].isel(time=-1).values for dataset in datasets])


@pytest.fixture(scope="module")
def oscillator():
    return run(OSCILLATOR)


@pytest.fixture(scope="module")
def ornstein_uhlenbeck():
    return run(ORNSTEIN_UHLENBECK)


def covered(bounds, truth):
    """Share of intervals (seed, bound, joint) that cover."""
    return np.mean((bounds[:, 1] <= truth) & (truth <= bounds[:, 2]), axis=(0, -1))


def check(datasets, name, variance):
    """Means and mean squares between 93 and 97 %, quantiles as the binomial law of ranks says."""
    deviation = np.sqrt(variance)
    assert 0.93 <= covered(at_end(datasets, f"{name}_mean"), 0.0) <= 0.97
    assert 0.93 <= covered(at_end(datasets, f"{name}_mean_square"), variance) <= 0.97
    for i, p in enumerate(LEVELS):
        low, high = stats.binom.ppf(0.025, PATHS, p), stats.binom.isf(0.025, PATHS, p) + 1
        exact = stats.binom.cdf(high - 1, PATHS, p) - stats.binom.cdf(low - 1, PATHS, p)
        assert 0.95 <= exact <= 0.97
        least, most = stats.binom.interval(CONFIDENCE, ENSEMBLES, exact)
        bounds = at_end(datasets, f"{name}_quantile")[:, :, i]
        share = covered(bounds, stats.norm.ppf(p, 0.0, deviation))
        assert least <= share * ENSEMBLES <= most


def test_an_oscillator(oscillator):
    k, d = OSCILLATOR
    P = covariance(k, d)
    check(oscillator, "error", P[0, 0])
    gains = np.array([k, d])
    check(oscillator, "u", gains @ P @ gains)


def test_an_ornstein_uhlenbeck_process(ornstein_uhlenbeck):
    check(ornstein_uhlenbeck, "u", covariance(*ORNSTEIN_UHLENBECK)[1, 1])


def test_the_overall_error(oscillator):
    """|x|^2 of 25 oscillators is chi-squared: its mean is known."""
    truth = JOINTS * covariance(*OSCILLATOR)[0, 0]
    bounds = at_end(oscillator, "ote_mean_square")
    hits = np.sum((bounds[:, 1] <= truth) & (truth <= bounds[:, 2]))
    least, most = stats.binom.interval(CONFIDENCE, RUNS, 0.95)
    assert least <= hits <= most


def test_proportions():
    """Share of joints whose largest torque stays below a limit, in runs of one period.

    The torque after it is -d v with v = sqrt(h) n.
    """
    datasets = run(ORNSTEIN_UHLENBECK, duration=PERIOD)
    truth = 2 * stats.norm.cdf(TORQUE / np.sqrt(PERIOD)) - 1
    counts = np.concatenate([np.sum(t["peak_torque"].values < TORQUE, axis=0) for t in datasets])
    intervals = {k: proportion(int(k), PATHS) for k in range(PATHS + 1)}
    covers = np.array([low <= truth <= high for _, low, high in intervals.values()])
    exact = np.sum(stats.binom.pmf(np.arange(PATHS + 1), PATHS, truth)[covers])
    assert 0.95 <= exact <= 0.97
    least, most = stats.binom.interval(CONFIDENCE, ENSEMBLES, exact)
    assert least <= np.sum(covers[counts]) <= most
