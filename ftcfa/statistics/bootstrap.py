"""Paired bootstrap: intervals of differences of any statistic over the same paths.

The paths are drawn anew, with replacement, and the same ones for all rows, so that what rows have
in common cancels as it does in the differences (Efron and Tibshirani, An Introduction to the
Bootstrap, 1993, chapters 8 and 13). `scripts/coverage_table.py` shows how often intervals of the
difference of two 95 % quantiles cover: in 95.6 to 97.4 % of the cases for 100 paths and more, in
85 to 91 % for 20.
"""

from collections.abc import Callable, Mapping

import numpy as np

from ftcfa.arrays import Array
from ftcfa.statistics.estimate import CONFIDENCE

RESAMPLES = 1000
"""Number of times that the paths are drawn."""


def paired_bootstrap(
    statistic: Callable[[Mapping[str, Array]], Array],
    values: Mapping[str, Array],
    row: int,
    confidence: float = CONFIDENCE,
) -> tuple[Array, Array]:
    """Ends of intervals of the statistic of each row less that of one row, shape (rows,) each.

    Args:
        statistic: Takes numbers of shape (..., paths) by name to a number of shape (...).
        values: Numbers by name, shape (rows, paths) each.
        row: The row that is subtracted.
        confidence: Confidence of each interval.

    Returns:
        The lower and the upper ends, infinite where a difference of infinite numbers is in doubt.
    """
    count = next(iter(values.values())).shape[1]
    drawn = np.random.default_rng(0).integers(count, size=(RESAMPLES, count))
    found = np.stack(
        [
            statistic({name: rows[i][drawn] for name, rows in values.items()})
            for i in range(len(next(iter(values.values()))))
        ]
    )
    with np.errstate(invalid="ignore"):
        differences = found - found[row]
    tail, doubtful = (1.0 - confidence) / 2.0, np.isnan(differences)
    return (
        np.quantile(np.where(doubtful, -np.inf, differences), tail, axis=1, method="lower"),
        np.quantile(np.where(doubtful, np.inf, differences), 1.0 - tail, axis=1, method="higher"),
    )
