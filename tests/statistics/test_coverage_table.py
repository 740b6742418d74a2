"""How often the intervals cover, by ``scripts/coverage_table.py``: what their docstrings claim."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

SCRIPT = Path(__file__).parents[2] / "scripts" / "coverage_table.py"
CONFIDENCE = 1 - 1e-6
"""Of a check; there are some two hundred."""
EXACT = (
    "quantile 0.05", "quantile 0.5", "quantile 0.95", "quantile 0.05, over time",
    "quantile 0.5, over time", "quantile 0.95, over time", "share", "lower bound, all looks",
    "upper bound, all looks", "settling time, 0.05", "settling time, 0.5", "settling time, 0.95",
    "median difference", "difference of shares", "median difference, together",
    "difference of shares, together",
)  # fmt: skip
"""They cover in 95 % of the cases or more, whatever the distribution and however few the paths."""
CLAIMED = {
    "mean, Student": {"normal": (0.95, 0.95, 0.95), "chi-square": (0.89, 0.93, 0.945)},
    "mean, skewness corrected": {
        "normal": (0.945, 0.945, 0.945),
        "chi-square": (0.94, 0.945, 0.945),
        "lognormal": (0.91, 0.93, 0.945),
    },
    "upper bound (97.5 %)": {"chi-square": (0.95, 0.97, 0.97), "lognormal": (0.92, 0.955, 0.97)},
    "difference of 95 % quantiles, bootstrap": dict.fromkeys(
        ("normal", "chi-square", "lognormal", "1 % fail"), (0.82, 0.94, 0.94)
    ),
    "mean difference": dict.fromkeys(("normal", "lognormal", "1 % fail"), (0.94, 0.94, 0.94)),
    "mean difference, together": dict.fromkeys(
        ("normal", "chi-square", "lognormal", "1 % fail"), (0.93, 0.93, 0.93)
    ),
}
"""What the others cover with 20, 100 and 500 paths."""
TOGETHER = 12
FEWER = 6


def least(share, interval, ensembles):
    """The smallest coverage that so many ensembles would show if the true one is a share."""
    if "together" in interval:
        ensembles //= TOGETHER
    if "settling" in interval:
        ensembles //= FEWER
    if "bootstrap" in interval:
        ensembles //= 2 * FEWER
    return stats.binom.isf(CONFIDENCE, ensembles, share) / ensembles


def check(table, ensembles, sizes):
    for interval, row in table.items():
        for name, shares in row.items():
            claimed = CLAIMED.get(interval, {}).get(name, (np.nan,) * 3)
            claims = (0.95,) * 3 if interval in EXACT else claimed
            for share, claim, size in zip(shares, claims[: len(sizes)], sizes, strict=True):
                if not np.isnan(claim):
                    assert share >= least(claim, interval, ensembles), (interval, name, size)
    assert table.keys() >= {*EXACT, *CLAIMED}


def test_intervals_of_20_paths():
    ensembles = 240
    check(runpy.run_path(str(SCRIPT))["study"](ensembles, (20,)), ensembles, (20,))


@pytest.mark.slow
def test_intervals_of_20_100_and_500_paths():
    script = runpy.run_path(str(SCRIPT))
    ensembles, sizes = script["ENSEMBLES"], script["SIZES"]
    check(script["study"](ensembles), ensembles, sizes)


def test_a_mean_that_fails_to_cover_is_warned_of_or_unseen():
    """1 % of 100 paths fail: a third of the samples have none, and nothing can be known of it."""
    table = runpy.run_path(str(SCRIPT))["study"](240, (100,))
    unseen = 0.99**100
    warned = table["warned: few paths carry it"]["1 % fail"][0]
    low, high = stats.binom.interval(CONFIDENCE, 240, 1 - unseen)
    assert low <= 240 * warned <= high + 20  # and some without a failure whose squares are skewed
    assert table["mean, skewness corrected"]["1 % fail"][0] < 0.7
