"""How often does each interval that ftcfa gives cover the truth?

    python scripts/coverage_table.py [--out FOLDER] [--quick]

All are asked for 95 %. Ensembles of 20, 100 and 500 paths are drawn from four distributions whose
truth is known: normal; chi-square (squares of normal values, as in mean squares); lognormal; and
squares of normal values of which 1 % fail and are 100. The script takes three minutes, prints a
table and writes coverage.json.

"Together" are twelve comparisons at once, as in `ftcfa.compare`: its mean differences, where those
that few paths carry are not judged, its medians and its shares.
"""

import argparse
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from scipy import stats

from ftcfa.arrays import Array
from ftcfa.files import make_folder, write_whole
from ftcfa.report.terminal import print_line, print_table
from ftcfa.statistics.bootstrap import paired_bootstrap
from ftcfa.statistics.estimate import CONFIDENCE, Estimate
from ftcfa.statistics.kaplan_meier import settling_distribution
from ftcfa.statistics.moments import Moments
from ftcfa.statistics.proportions import paired_difference, proportion
from ftcfa.statistics.quantile_sketch import QuantileSketch
from ftcfa.statistics.quantiles import quantile_ranks
from ftcfa.statistics.sequential_test import log_evidence
from ftcfa.study.comparison import FEW

SIZES = (20, 100, 500)
"""Numbers of paths of an ensemble."""
ENSEMBLES, QUICK_ENSEMBLES = 6000, 240
FEWER = 6
"""One ensemble of so many is taken where each needs Python of its own."""
TOGETHER = 12
"""Number of differences of a comparison: three laws against the first, four metrics."""
LEVELS = (0.05, 0.5, 0.95)
END = 0.97
"""Share of the paths that could settle and have done so when the runs end."""
FAILING, FAILED = 0.01, 100.0
"""Share of the paths that fail, and their value."""
THRESHOLD = 0.9
"""Share of the paths that succeed, unless some fail."""


class Distribution(NamedTuple):
    """A distribution of the paths' values, and what is known of it."""

    draw: Callable[[np.random.Generator, tuple[int, ...]], Array]
    mean: float
    quantile: Callable[[float], float]
    settling: Callable[[float], float]
    """Quantile of the settling time, which is the size of the value; infinite if never."""
    failing: float = 0.0


def _with_failures(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    fails = rng.random(shape) < FAILING
    return np.where(fails, FAILED, rng.standard_normal(shape) ** 2)


def _of_the_others(p: float) -> float:
    """Quantile of the distribution with failures, which are beyond all others."""
    return FAILED if p > 1 - FAILING else float(stats.chi2.ppf(p / (1 - FAILING), 1))


DISTRIBUTIONS = {
    "normal": Distribution(
        lambda rng, shape: rng.standard_normal(shape), 0.0, stats.norm.ppf,
        lambda p: stats.norm.ppf((1 + p) / 2),
    ),
    "chi-square": Distribution(
        lambda rng, shape: rng.standard_normal(shape) ** 2, 1.0,
        lambda p: stats.chi2.ppf(p, 1), lambda p: stats.chi2.ppf(p, 1),
    ),
    "lognormal": Distribution(
        lambda rng, shape: np.exp(rng.standard_normal(shape)), np.exp(0.5),
        lambda p: np.exp(stats.norm.ppf(p)), lambda p: np.exp(stats.norm.ppf(p)),
    ),
    "1 % fail": Distribution(
        _with_failures, 1 - FAILING + FAILING * FAILED, _of_the_others, _of_the_others, FAILING
    ),
}  # fmt: skip
"""The distributions by name."""


def covers(estimate: Estimate, truth: Any) -> float:
    """Share of intervals, along the last axis, that cover."""
    return float(np.mean((estimate.low <= truth) & (truth <= estimate.high)))


def means(x: Array, one: Distribution) -> dict[str, float]:
    """Intervals of the mean; values have the shape (paths, ensembles)."""
    moments = Moments.of(x)
    corrected, few = moments.skewness_corrected(), moments.carried_by()
    inside = (corrected.low <= one.mean) & (one.mean <= corrected.high)
    return {
        "mean, Student": covers(moments.student(), one.mean),
        "mean, skewness corrected": float(np.mean(inside)),
        "the same, no warning": float(np.mean(inside[~few])) if np.any(~few) else float("nan"),
        "warned: few paths carry it": float(np.mean(few)),
        "upper bound (97.5 %)": float(np.mean(one.mean <= corrected.high)),
    }


def quantiles(x: Array, one: Distribution) -> dict[str, float]:
    """Intervals of quantiles, by ranks and by the sketch over time."""
    ordered = np.concatenate([[np.full(x.shape[1], -np.inf)], np.sort(x, axis=0),
                              [np.full(x.shape[1], np.inf)]])  # fmt: skip
    sketch = QuantileSketch.of(x).quantile(np.array(LEVELS), CONFIDENCE)
    found = {}
    for k, p in enumerate(LEVELS):
        _, low, high = (int(rank) for rank in quantile_ranks(np.array(p), len(x), CONFIDENCE))
        ranks = Estimate(ordered[low], ordered[low], ordered[high])
        found[f"quantile {p:g}"] = covers(ranks, one.quantile(p))
        found[f"quantile {p:g}, over time"] = covers(
            Estimate(*(end[k] for end in sketch)), one.quantile(p)
        )
    return found


def shares(x: Array, one: Distribution) -> dict[str, float]:
    """Intervals of a share of paths: at one time, and at all looks of a sequential test."""
    p = 1.0 - one.failing if one.failing else THRESHOLD
    good = x < (FAILED if one.failing else one.quantile(THRESHOLD))
    S = np.cumsum(good, axis=0)
    F = np.arange(1, len(x) + 1)[:, None] - S
    table = Estimate(*np.array([proportion(k, len(x)) for k in range(len(x) + 1)]).T)
    beta = 1.0 - CONFIDENCE
    limit = -np.log(beta)
    return {
        "share": covers(Estimate(*(end[S[-1]] for end in table)), p),
        "lower bound, all looks": float(np.mean(np.max(log_evidence(S, F, p), axis=0) < limit)),
        "upper bound, all looks": float(np.mean(np.max(log_evidence(F, S, 1 - p), axis=0) < limit)),
    }


def settling(x: Array, one: Distribution) -> dict[str, float]:
    """Intervals of the quantiles of the settling time, some paths of which never settle."""
    times = np.abs(x[:, ::FEWER])
    end = one.settling(END * (1 - one.failing))
    found = np.zeros((len(LEVELS), times.shape[1]))
    for i, t in enumerate(times.T):
        distribution = settling_distribution(np.where(t <= end, t, np.nan), end)
        for k, p in enumerate(LEVELS):
            interval = distribution.quantile(p)
            found[k, i] = interval.low <= one.settling(p) <= interval.high
    means = found.mean(axis=1)
    return {f"settling time, {p:g}": float(c) for p, c in zip(LEVELS, means, strict=True)}


def differences(x: Array, y: Array, one: Distribution) -> dict[str, float]:
    """Paired differences of two laws of one distribution: none differs from the other."""
    found = {}
    for words, number in (("", 1), (", together", TOGETHER)):
        confidence = 1.0 - (1.0 - CONFIDENCE) / number
        wrong = wrong_verdicts(x, y, one, confidence)
        for name, verdicts in wrong.items():
            families = verdicts[: verdicts.size // number * number].reshape(-1, number)
            found[f"{name}{words}"] = 1.0 - float(np.mean(np.any(families, axis=1)))
    return found


def wrong_verdicts(
    x: Array, y: Array, one: Distribution, confidence: float
) -> Mapping[str, np.ndarray]:
    """Where `ftcfa.compare` would take two laws apart that are equal, shape (ensembles,)."""
    n = len(x)
    moments = Moments.of(x - y)
    mean = moments.skewness_corrected(confidence)
    apart = (mean.low > 0) | (mean.high < 0)
    _, low, high = (int(r) for r in quantile_ranks(np.array(0.5), n, confidence))
    ordered = np.sort(x - y, axis=0)
    above = ordered[low - 1] > 0 if low > 0 else np.zeros(x.shape[1], dtype=bool)
    below = ordered[high - 1] < 0 if high <= n else np.zeros(x.shape[1], dtype=bool)
    limit = FAILED if one.failing else one.quantile(THRESHOLD)
    more, less = (np.sum(pair, axis=0) for pair in ((x >= limit) & (y < limit),
                                                    (x < limit) & (y >= limit)))  # fmt: skip
    counts, which = np.unique([more, less], axis=1, return_inverse=True)
    pairs = np.array([paired_difference(int(a), int(b), n, confidence) for a, b in counts.T])
    pairs = pairs[which.ravel()]
    return {
        "mean difference": apart & ~moments.carried_by(FEW),
        "median difference": above | below,
        "difference of shares": (pairs[:, 1] > 0) | (pairs[:, 2] < 0),
    }


def quantile_differences(x: Array, y: Array) -> dict[str, float]:
    """Paired bootstrap of the difference of two 95 % quantiles: none differs from the other."""
    found = []
    for pair in zip(x.T[:: 2 * FEWER], y.T[:: 2 * FEWER], strict=True):
        low, high = paired_bootstrap(
            lambda values: np.quantile(values["x"], 0.95, axis=-1, method="higher"),
            {"x": np.stack(pair)},
            0,
        )
        found.append(low[1] <= 0.0 <= high[1])
    return {"difference of 95 % quantiles, bootstrap": float(np.mean(found))}


def study(ensembles: int, sizes: tuple[int, ...] = SIZES) -> dict[str, dict[str, list[float]]]:
    """Coverage by interval and distribution, one number for each size."""
    table: dict[str, dict[str, list[float]]] = {}
    rng = np.random.default_rng(0)
    for name, one in DISTRIBUTIONS.items():
        for n in sizes:
            x, y = one.draw(rng, (n, ensembles)), one.draw(rng, (n, ensembles))
            found = means(x, one) | quantiles(x, one) | shares(x, one) | settling(x, one)
            found |= differences(x, y, one) | quantile_differences(x, y)
            for interval, share in found.items():
                table.setdefault(interval, {}).setdefault(name, []).append(share)
    return table


def main() -> None:
    """Print the table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the record")
    parser.add_argument("--quick", action="store_true", help="few ensembles: seconds")
    options = parser.parse_args()
    make_folder(options.out)
    ensembles = QUICK_ENSEMBLES if options.quick else ENSEMBLES
    table = study(ensembles)
    console = Console(highlight=False)
    sizes = ", ".join(map(str, SIZES))
    title = f"Coverage of 95 % intervals [%], {ensembles} ensembles of {sizes} paths"
    print_line(title, console, "bold")
    rows = [
        [interval, *(" ".join(f"{100 * x:.3g}" for x in row[name]) for name in DISTRIBUTIONS)]
        for interval, row in table.items()
    ]
    print_table(["interval", *DISTRIBUTIONS], rows, console, "fr")
    record = {"ensembles": ensembles, "sizes": SIZES, "coverage": table}
    write_whole(options.out / "coverage.json", json.dumps(record, indent=1).encode())


if __name__ == "__main__":
    main()
