"""What every statistic hands over: a value and the interval that covers the truth."""

from numbers import Real
from typing import NamedTuple

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError

CONFIDENCE = 0.95
"""Probability with which an interval covers the truth, unless asked otherwise."""


class Estimate(NamedTuple):
    """A statistic and its confidence interval; arrays of one shape."""

    value: Array
    low: Array
    high: Array


def probability(subject: str, value: float) -> None:
    """Raise ParameterError unless a value lies strictly between 0 and 1."""
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not (number and 0 < value < 1):
        remedy = f"give {value / 100:g} for {value:g} percent" if number and 1 < value < 100 else ""
        raise ParameterError(subject, repr(value), "a number between 0 and 1", remedy)
