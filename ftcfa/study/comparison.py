"""`compare`: controllers under the same noise on the same robots, path by path.

Path i of every loop has the same random numbers, so differences are taken in pairs and most of
the noise cancels. All differences together hold with the requested confidence (Bonferroni).
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.checks import not_negative
from ftcfa.description.write import NOT_REBUILDABLE, differences, provenance
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.estimate import CONFIDENCE
from ftcfa.statistics.moments import Moments, paired_differences
from ftcfa.statistics.proportions import paired_difference
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.ensemble import ensemble
from ftcfa.study.metrics.compared import COMPARED
from ftcfa.study.progress import Interrupted, Progress
from ftcfa.study.summary import BOUNDS, QUANTILES

SMALLEST = 0.01
"""Smallest difference of interest, as a share of the first loop's mean: below it, two laws are the
same to an engineer, however many paths tell them apart."""
FEW = 25
"""Number of paths that, where they carry a mean difference, are too few for intervals which must
hold all together."""
BINARY = [name for name, metric in COMPARED.items() if metric.binary]


def compare(
    loops: Mapping[str, ClosedLoop],
    paths: int,
    duration: float,
    *,
    confidence: float = CONFIDENCE,
    smallest: float = SMALLEST,
    progress: Progress | None = None,
    **options: Any,
) -> xr.Dataset:
    """Run loops under common random numbers and compare each with the first.

    Args:
        loops: Loops by name; the others are compared with the first.
        paths: Number of paths of each loop.
        duration: Simulated time [s].
        confidence: Confidence of each interval of a mean, and of all differences together.
        smallest: Smallest difference of interest, as a share of the first loop's mean: a smaller
            one is never significant.
        progress: Called with the number of paths that are done and the number of all, over all
            loops.
        options: Options of `ensemble`: ``seed``, ``tolerance``, ``after``, ``threads``,
            ``chunk``, ``client``.

    Returns:
        A Dataset over ``loop``, ``metric``, ``bound`` (estimate, low, high) and ``quantile``:
        ``mean`` over the paths that did not diverge; ``quantiles`` over all, where a path that
        diverged counts as the worst; ``difference``, the mean difference from the first loop over
        the pairs of paths of which neither diverged; ``median_difference``, the median of the
        differences with the interval of the sign test; ``significant`` and
        ``median_significant``, whether the interval of the mean and of the median difference
        excludes zero and the difference is of interest; a mean that few paths carry
        (``carried_by_few``) is not judged; ``settled``, ``kept`` and ``diverged``, numbers of
        paths; ``values`` of every path;
        ``experiment``, the description of each loop as in the attributes of `ensemble`; and
        ``differs``, the parameters in which a loop differs from the first. A loop that is the same
        as an earlier one is not run again; the attribute ``same`` names both.

    The intervals of the medians and of the shares hold together with the confidence, whatever the
    distribution. Those of the means assume that the paths which carry the mean are among those that
    were run: ``scripts/coverage_table.py`` shows how often they cover where 1 % of the paths fail.

    Raises:
        ParameterError: If there are fewer than two loops, or their joints differ.
        Interrupted: At Ctrl-C. Its ``partial`` compares the loops all of whose paths are done, or
            is None if they are fewer than two.
    """
    _check(loops)
    not_negative("smallest", smallest)
    loops, same = _distinct(loops)
    runs: dict[str, xr.Dataset] = {}
    try:
        for loop_number, (name, loop) in enumerate(loops.items()):
            done = _progress_of_all(progress, loop_number * paths, len(loops) * paths)
            runs[name] = ensemble(
                loop, paths, duration, confidence=confidence, progress=done, **options
            )
    except KeyboardInterrupt:
        partial = _comparison(loops, runs, confidence, smallest, same) if len(runs) > 1 else None
        raise Interrupted("compare", partial) from None
    return _comparison(loops, runs, confidence, smallest, same)


def _check(loops: Any) -> None:
    """Raise ParameterError unless loops can be compared."""
    if not isinstance(loops, Mapping):
        raise ParameterError("compare", f"a {type(loops).__name__}", "loops by name, a dictionary")
    for name, loop in loops.items():
        if not isinstance(loop, ClosedLoop):
            raise ParameterError(f"compare '{name}'", f"a {type(loop).__name__}", "a ClosedLoop")
    if len(loops) < 2:
        raise ParameterError("compare", f"{len(loops)} loops", "two or more, by name")
    joints = {loop.arm.joint_names for loop in loops.values()}
    if len(joints) > 1:
        raise ParameterError("compare", "arms of different joints", "the same joints in all loops")


def _distinct(loops: Mapping[str, ClosedLoop]) -> tuple[dict[str, ClosedLoop], str]:
    """The loops that differ from all before them, and which others are the same as which."""
    names: dict[str, str] = {}
    distinct, same = {}, []
    for name, loop in loops.items():
        description = provenance(loop)
        first = names.setdefault(json.dumps(description), name)
        if first == name or NOT_REBUILDABLE in description:
            distinct[name] = loop
        else:
            same.append(f"{name} is the same as {first}")
    return distinct, "; ".join(same)


def _progress_of_all(progress: Progress | None, before: int, total: int) -> Progress | None:
    """What an ensemble calls for its progress: its paths come after those of earlier loops."""
    return None if progress is None else lambda done, _: progress(before + done, total)


def _comparison(
    loops: Mapping[str, ClosedLoop],
    runs: Mapping[str, xr.Dataset],
    confidence: float,
    smallest: float,
    same: str,
) -> xr.Dataset:
    """The Dataset of `compare` from the ensembles of loops, by name."""
    values = [
        [metric.values(run, loops[name].arm.effort_limit) for metric in COMPARED.values()]
        for name, run in runs.items()
    ]
    descriptions = [json.loads(run.attrs["experiment"]) for run in runs.values()]
    differs = [differences(descriptions[0], description) for description in descriptions]
    run = next(iter(runs.values()))
    rule = {"smallest": smallest, "same": same}
    copied = ("ftcfa_version", "hardware", "confidence", "duration", "seed", "tolerance", "after")
    return (
        _statistics(np.array(values), confidence, smallest)
        .assign(differs=("loop", differs))
        .assign(experiment=("loop", [run.attrs["experiment"] for run in runs.values()]))
        .assign_coords(loop=list(runs), path=run["path"])
        .assign_attrs({name: run.attrs[name] for name in copied} | rule)
    )


def _statistics(rows: Array, confidence: float, smallest: float) -> xr.Dataset:
    """Statistics of metrics, shape (loop, metric, path); NaN where a path diverged."""
    moments = [Moments.of(row.T).without_missing() for row in rows]
    mean = np.stack([np.stack(one.skewness_corrected(confidence)) for one in moments])
    together = 1.0 - (1.0 - confidence) / max(1, (len(rows) - 1) * rows.shape[1])
    pairs = [paired_differences(row.T, rows[0].T).without_missing() for row in rows]
    difference = np.stack(
        [_mean_difference(p, row, rows[0], together) for p, row in zip(pairs, rows, strict=True)]
    )
    median = np.stack([_median_difference(row, rows[0], together) for row in rows])
    quantiles = np.array([[_quantiles(values) for values in row] for row in rows])
    few = np.stack([pair.carried_by(FEW) for pair in pairs]) & ~np.isin(list(COMPARED), BINARY)
    middle = np.nan_to_num(quantiles[0, :, QUANTILES.index(0.5)], posinf=0.0)
    counted = {name: rows[:, list(COMPARED).index(name)] for name in BINARY}
    dims = ("loop", "bound", "metric")
    return xr.Dataset(
        {
            "mean": (dims, mean),
            "difference": (dims, difference),
            "median_difference": (dims, median),
            "significant": (("loop", "metric"), _apart(difference, smallest * mean[0, 0]) & ~few),
            "median_significant": (("loop", "metric"), _apart(median, smallest * middle)),
            "carried_by_few": (("loop", "metric"), few),
            "quantiles": (("loop", "metric", "quantile"), quantiles),
            "settled": ("loop", np.sum(counted["unsettled"] == 0, axis=1)),
            "kept": ("loop", np.sum(counted["failed"] == 0, axis=1)),
            "diverged": ("loop", np.sum(counted["diverged"] == 1, axis=1)),
            "values": (("loop", "metric", "path"), rows),
        },
        coords={
            "metric": list(COMPARED),
            "unit": ("metric", [metric.unit for metric in COMPARED.values()]),
            "meaning": ("metric", [metric.meaning for metric in COMPARED.values()]),
            "bound": list(BOUNDS),
            "quantile": list(QUANTILES),
        },
    )


def _apart(difference: Array, least: Array) -> npt.NDArray[np.bool_]:
    """Whether intervals (loop, bound, metric) exclude zero and differences are of interest."""
    excludes = (difference[:, 1] > 0) | (difference[:, 2] < 0)
    return excludes & (np.abs(difference[:, 0]) >= np.abs(np.nan_to_num(least)))


def _mean_difference(pairs: Moments, values: Array, first: Array, confidence: float) -> Array:
    """Mean differences of metrics, shape (metric, path), with intervals: (bound, metric)."""
    difference = np.stack(pairs.skewness_corrected(confidence))
    for name in BINARY:
        index = list(COMPARED).index(name)
        more, less = (int(np.sum(sign * (values[index] - first[index]) > 0)) for sign in (1, -1))
        difference[:, index] = paired_difference(more, less, values.shape[1], confidence)
    return difference


def _median_difference(values: Array, first: Array, confidence: float) -> Array:
    """Medians of the differences with the intervals of the sign test: (bound, metric).

    A path that diverged is larger than any that did not; two of them do not differ.
    """
    with np.errstate(invalid="ignore"):
        change = np.nan_to_num(values, nan=np.inf) - np.nan_to_num(first, nan=np.inf)
    change = np.where(np.isnan(change), 0.0, change)
    return np.array([np.stack(sample_quantile(row, 0.5, confidence)) for row in change]).T


def _quantiles(values: Array) -> Array:
    """Quantiles over paths; a path that diverged counts as the worst of all."""
    return sample_quantile(np.where(np.isnan(values), np.inf, values), QUANTILES).value
