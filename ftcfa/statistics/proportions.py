"""Shares of paths with exact intervals (Clopper and Pearson, Biometrika 26, 1934).

They cover with at least the requested probability, whatever the share; more often where the share
is near 0 or 1 or paths are few, because counts are whole numbers. They hold for a number of paths
fixed beforehand; for a decision while paths come in, use `ftcfa.statistics.sequential_test`.
"""

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftcfa.checks import counting, probability
from ftcfa.errors import ParameterError
from ftcfa.portable import rounded
from ftcfa.statistics.estimate import CONFIDENCE, Estimate


def proportion(successes: npt.ArrayLike, trials: int, confidence: float = CONFIDENCE) -> Estimate:
    """Share of successes with its two-sided interval.

    The ends are quantiles of beta distributions, 0 without a success and 1 without a failure.

    Args:
        successes: One number of successes or many, shape (...).
        trials: Number of trials of each.
        confidence: Confidence of each interval.

    Raises:
        ParameterError: If there are no trials, more successes than trials, or the confidence is
            not between 0 and 1.
    """
    counting("trials", trials)
    probability("confidence of a proportion", confidence)
    k, n = np.asarray(successes), trials
    if not (np.issubdtype(k.dtype, np.integer) and np.all((k >= 0) & (k <= n))):
        raise ParameterError("successes", repr(successes), f"an integer from 0 to {n}")
    tail = (1 - confidence) / 2
    low = np.where(k > 0, stats.beta.ppf(tail, np.maximum(k, 1), n - k + 1), 0.0)
    high = np.where(k < n, stats.beta.isf(tail, k + 1, np.maximum(n - k, 1)), 1.0)
    return Estimate(k / np.asarray(n), rounded(low), rounded(high))


def paired_difference(more: int, less: int, pairs: int, confidence: float = CONFIDENCE) -> Estimate:
    """Difference of two shares over the same paths, from the pairs that differ.

        p = more/pairs - less/pairs

    Both shares of differing pairs have Clopper and Pearson's interval at 1 - (1 - c)/2, and the
    ends are subtracted, so that the interval covers with probability c at least, however many pairs
    differ: in 99.8 % of the cases or more for c = 95 % and 20 to 500 pairs
    (``scripts/coverage_table.py``). Without a pair that differs it is as wide as the number of
    pairs allows, not zero.

    Args:
        more: Number of pairs in which the first path alone is a success.
        less: Number of pairs in which the second path alone is one.
        pairs: Number of all pairs.
        confidence: c.
    """
    each = 1.0 - (1.0 - confidence) / 2.0
    up, down = (proportion(count, pairs, each) for count in (more, less))
    return Estimate(up.value - down.value, up.low - down.high, up.high - down.low)
