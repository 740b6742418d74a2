"""Shares of paths with exact intervals (Clopper and Pearson, Biometrika 26, 1934).

They cover with the probability asked at least, whatever the share; more where the share is near 0
or 1 or paths are few, because counts are whole numbers. They hold for a number of paths fixed
beforehand: to look while paths come in, use `ftcfa.statistics.sequential_test`.
"""

from numbers import Integral
from typing import Literal

import numpy as np
from scipy import stats

from ftcfa.checks import counting, probability
from ftcfa.errors import ParameterError
from ftcfa.statistics.estimate import CONFIDENCE, Estimate


def proportion(successes: int, trials: int, confidence: float = CONFIDENCE) -> Estimate:
    """Share of successes with its two-sided interval.

    Raises:
        ParameterError: If there are no trials, more successes than trials, or the confidence is
            not between 0 and 1.
    """
    low, high = _interval(successes, trials, confidence, "two-sided")
    return Estimate(np.array(successes / trials), np.array(low), np.array(high))


def at_least(successes: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """The share that is surpassed with a given confidence: the one-sided lower bound.

    Raises:
        ParameterError: As `proportion`.
    """
    return _interval(successes, trials, confidence, "greater")[0]


def at_most(successes: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """The share that is not reached with a given confidence: the one-sided upper bound.

    Raises:
        ParameterError: As `proportion`.
    """
    return _interval(successes, trials, confidence, "less")[1]


def _interval(
    successes: int,
    trials: int,
    confidence: float,
    side: Literal["two-sided", "greater", "less"],
) -> tuple[float, float]:
    counting("trials", trials)
    probability("confidence of a proportion", confidence)
    if not (isinstance(successes, Integral) and 0 <= successes <= trials):
        raise ParameterError("successes", repr(successes), f"an integer from 0 to {trials}")
    low, high = stats.binomtest(int(successes), int(trials), alternative=side).proportion_ci(
        confidence, method="exact"
    )
    return float(low), float(high)
