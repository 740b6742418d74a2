"""Quantiles of a sample and their distribution-free intervals, by ranks.

Among n independent values, the number of those not above the p-quantile is binomial (n, p),
whatever the distribution. So the order statistics x_(l) and x_(u) with

    P(B < l) <= alpha/2,   P(B >= u) <= alpha/2,   B ~ Bin(n, p)

hold the quantile between them with probability 1 - alpha at least (David and Nagaraja, Order
Statistics, 3rd ed. 2003, section 7.1). Because ranks are whole numbers, the intervals of few
paths cover more often than required: 95 % intervals cover the median in 95.9 % of the cases for
n = 20 and 96.0 % for n = 200, the 5 % quantile in 98.4 and 96.7 %.
"""

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftcfa.arrays import Array
from ftcfa.checks import probability
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.estimate import CONFIDENCE, Estimate

Ranks = npt.NDArray[np.int64]


def quantile_ranks(p: Array, n: npt.ArrayLike, confidence: float) -> tuple[Ranks, Ranks, Ranks]:
    """Ranks, from 1, of a quantile among n values and of the ends of its confidence interval.

    Args:
        p: Probabilities, a shape that broadcasts with n.
        n: Numbers of values.
        confidence: Confidence of the interval.

    Returns:
        Rank ceil(n p) of the quantile; lower rank, 0 where the smallest value is not below the
        quantile with this confidence; upper rank, n + 1 where the largest is not above it.

    Raises:
        ParameterError: If a probability is not between 0 and 1.
    """
    probability("confidence of a quantile", confidence)
    for value in p.flat:
        probability("quantile", float(value))
    n = np.asarray(n)
    tail = (1 - confidence) / 2
    middle = np.maximum(np.ceil(n * p), 1)
    low, high = stats.binom.ppf(tail, n, p), stats.binom.isf(tail, n, p) + 1
    return middle.astype(np.int64), low.astype(np.int64), high.astype(np.int64)


def sample_quantile(
    values: npt.ArrayLike, p: npt.ArrayLike, confidence: float = CONFIDENCE
) -> Estimate:
    """Quantiles over paths with distribution-free intervals.

    Args:
        values: One number for each path, shape (paths,); +inf is a value like others (never
            settled, diverged).
        p: Probabilities, shape (...).
        confidence: Confidence of each interval.

    Returns:
        Quantile inf{x: F(x) >= p}, lower and upper end, shape (...). An end is infinite where
        there are too few paths for it.

    Raises:
        ParameterError: If a probability is not between 0 and 1, or a value is NaN.
        ShapeError: If there are no values, or more than one axis.
    """
    x = np.asarray(values, dtype=float)
    if x.ndim != 1 or x.size == 0:
        raise ShapeError("values of a quantile", f"shape {x.shape}", "shape (paths,), one or more")
    if np.any(np.isnan(x)):
        remedy = "give +inf for what never happened, or leave the path out"
        raise ParameterError(
            "values of a quantile", f"{np.sum(np.isnan(x))} NaN", "numbers", remedy
        )
    ordered = np.concatenate([[-np.inf], np.sort(x), [np.inf]])
    ranks = quantile_ranks(np.asarray(p, dtype=float), len(x), confidence)
    return Estimate(*(ordered[rank] for rank in ranks))
