"""What every statistic hands over: a value and the interval that covers the truth."""

from typing import NamedTuple

from ftcfa.arrays import Array

CONFIDENCE = 0.95
"""Probability with which an interval covers the truth, unless asked otherwise."""


class Estimate(NamedTuple):
    """A statistic and its confidence interval; arrays of one shape."""

    value: Array
    low: Array
    high: Array
