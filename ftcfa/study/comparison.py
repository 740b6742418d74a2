"""`compare`: controllers under the same noise on the same robots, path by path.

Path i of every loop has the same random numbers, so differences are taken in pairs and most of
the noise cancels. All differences together hold with the requested confidence (Bonferroni).
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.description.write import differences
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.estimate import CONFIDENCE
from ftcfa.statistics.moments import Moments, paired_differences
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.ensemble import ensemble
from ftcfa.study.metrics.compared import COMPARED
from ftcfa.study.progress import Interrupted, Progress
from ftcfa.study.summary import BOUNDS, QUANTILES

BINARY = [name for name, metric in COMPARED.items() if metric.binary]


def compare(
    loops: Mapping[str, ClosedLoop],
    paths: int,
    duration: float,
    *,
    confidence: float = CONFIDENCE,
    progress: Progress | None = None,
    **options: Any,
) -> xr.Dataset:
    """Run loops under common random numbers and compare each with the first.

    Args:
        loops: Loops by name; the others are compared with the first.
        paths: Number of paths of each loop.
        duration: Simulated time [s].
        confidence: Confidence of each interval of a mean, and of all differences together.
        progress: Called with the number of paths that are done and the number of all, over all
            loops.
        options: Options of `ensemble`: ``seed``, ``tolerance``, ``after``, ``threads``,
            ``chunk``, ``client``.

    Returns:
        A Dataset over ``loop``, ``metric``, ``bound`` (estimate, low, high) and ``quantile``:
        ``mean`` over the paths that did not diverge; ``quantiles`` over all, where a path that
        diverged counts as the worst; ``difference``, the mean difference from the first loop over
        the pairs of paths of which neither diverged; ``significant``, whether its interval
        excludes zero; ``settled`` and ``diverged``, numbers of paths; ``values`` of every path;
        ``experiment``, the description of each loop as in the attributes of `ensemble`; and
        ``differs``, the parameters in which a loop differs from the first.

    Raises:
        ParameterError: If there are fewer than two loops, or their joints differ.
        Interrupted: At Ctrl-C. Its ``partial`` compares the loops all of whose paths are done, or
            is None if they are fewer than two.
    """
    _check(loops)
    runs: dict[str, xr.Dataset] = {}
    try:
        for loop_number, (name, loop) in enumerate(loops.items()):
            done = _progress_of_all(progress, loop_number * paths, len(loops) * paths)
            runs[name] = ensemble(
                loop, paths, duration, confidence=confidence, progress=done, **options
            )
    except KeyboardInterrupt:
        partial = _comparison(loops, runs, confidence) if len(runs) > 1 else None
        raise Interrupted("compare", partial) from None
    return _comparison(loops, runs, confidence)


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


def _progress_of_all(progress: Progress | None, before: int, total: int) -> Progress | None:
    """What an ensemble calls for its progress: its paths come after those of earlier loops."""
    return None if progress is None else lambda done, _: progress(before + done, total)


def _comparison(
    loops: Mapping[str, ClosedLoop], runs: Mapping[str, xr.Dataset], confidence: float
) -> xr.Dataset:
    """The Dataset of `compare` from the ensembles of loops, by name."""
    values = [
        [metric.values(run, loops[name].arm.effort_limit) for metric in COMPARED.values()]
        for name, run in runs.items()
    ]
    descriptions = [json.loads(run.attrs["experiment"]) for run in runs.values()]
    differs = [differences(descriptions[0], description) for description in descriptions]
    run = next(iter(runs.values()))
    copied = ("ftcfa_version", "confidence", "duration", "seed", "tolerance", "after")
    return (
        _statistics(np.array(values), confidence)
        .assign(differs=("loop", differs))
        .assign(experiment=("loop", [run.attrs["experiment"] for run in runs.values()]))
        .assign_coords(loop=list(runs), path=run["path"])
        .assign_attrs({name: run.attrs[name] for name in copied})
    )


def _statistics(rows: Array, confidence: float) -> xr.Dataset:
    """Statistics of metrics, shape (loop, metric, path); NaN where a path diverged."""
    moments = [Moments.of(row.T).without_missing() for row in rows]
    mean = [np.stack(one.skewness_corrected(confidence)) for one in moments]
    together = 1.0 - (1.0 - confidence) / max(1, (len(rows) - 1) * rows.shape[1])
    difference = np.stack([_difference(row, rows[0], together) for row in rows])
    low, high = difference[:, 1], difference[:, 2]
    quantiles = [[_quantiles(values) for values in row] for row in rows]
    unsettled, diverged = (
        rows[:, list(COMPARED).index(name)] for name in ("unsettled", "diverged")
    )
    dims = ("loop", "bound", "metric")
    return xr.Dataset(
        {
            "mean": (dims, np.stack(mean)),
            "difference": (dims, difference),
            "significant": (("loop", "metric"), (low > 0) | (high < 0)),
            "quantiles": (("loop", "metric", "quantile"), np.array(quantiles)),
            "settled": ("loop", np.sum(unsettled == 0, axis=1)),
            "diverged": ("loop", np.sum(diverged == 1, axis=1)),
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


def _difference(values: Array, first: Array, confidence: float) -> Array:
    """Paired differences of metrics, shape (metric, path), with intervals: (bound, metric)."""
    pairs = paired_differences(values.T, first.T).without_missing()
    difference = np.stack(pairs.skewness_corrected(confidence))
    for name in BINARY:
        index = list(COMPARED).index(name)
        difference[:, index] = _paired_shares(values[index], first[index], confidence)
    return difference


def _paired_shares(values: Array, first: Array, confidence: float) -> Array:
    """Difference of two shares over the same paths: estimate, low and high.

    Among the pairs that differ, the share of those with the larger value has Clopper and Pearson's
    interval; it excludes a half just where McNemar's exact test rejects equality.
    """
    more, less = int(np.sum(values > first)), int(np.sum(values < first))
    if more + less == 0:
        return np.zeros(3)
    share = np.stack(proportion(more, more + less, confidence))
    return (2.0 * share - 1.0) * (more + less) / len(values)


def _quantiles(values: Array) -> Array:
    """Quantiles over paths; a path that diverged counts as the worst of all."""
    return sample_quantile(np.where(np.isnan(values), np.inf, values), QUANTILES).value
