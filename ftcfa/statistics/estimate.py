"""An estimate: the value of a statistic with its confidence interval."""

from typing import NamedTuple

from ftcfa.arrays import Array

CONFIDENCE = 0.95
"""Default probability with which an interval covers the truth."""


class Estimate(NamedTuple):
    """A statistic and the ends of its confidence interval, arrays of one shape."""

    value: Array
    low: Array
    high: Array
