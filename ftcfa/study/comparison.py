"""`compare`: controllers under the same noise on the same robots, path by path.

Path i of every loop has the same random numbers, so differences are taken in pairs and most of
the noise cancels. All differences together hold with the confidence asked for (Bonferroni).
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.description.write import describe, differences
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.estimate import CONFIDENCE
from ftcfa.statistics.moments import Moments, paired_differences
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.ensemble import ensemble
from ftcfa.study.summary import BOUNDS, QUANTILES

METRICS = {
    "settling_time": ("s", "time to settle, the duration where that never happens"),
    "rms_error": ("rad", "rms of |q - q_d| late in the run"),
    "peak_error": ("rad", "largest |q - q_d| late in the run"),
    "mean_square_error": ("rad^2", "mean of |q - q_d|^2 late in the run"),
    "effort": ("1", "rms torque over its limit, rms over the joints"),
    "torque_rate": ("1/s", "rms torque rate over the torque limit, rms over the joints"),
    "saturated": ("1", "share of samples at which some joint asked for more than its limit"),
    "unsettled": ("1", "1 for a path that does not settle, or diverges"),
    "diverged": ("1", "1 for a path that diverges"),
    "energy": ("J", "time integral of |u v|, summed over the joints"),
}
"""What loops are compared by."""
SHARES = ("unsettled", "diverged")
"""Those that are yes or no for each path."""


def compare(
    loops: Mapping[str, ClosedLoop],
    paths: int,
    duration: float,
    *,
    confidence: float = CONFIDENCE,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> xr.Dataset:
    """Run loops under common random numbers and compare each with the first.

    Args:
        loops: By name; the first is what the others are compared with.
        paths: How many, of each.
        duration: Simulated time [s].
        confidence: Of the intervals; of all differences together.
        progress: Called with the paths done and to do, of all loops.
        options: As of `ensemble`: ``seed``, ``tolerance``, ``after``, ``threads``, ``chunk``,
            ``client``.

    Returns:
        A Dataset over ``loop``, ``metric``, ``bound`` (estimate, low, high) and ``quantile``:
        ``mean`` over the paths that did not diverge, ``quantiles`` over all, a path that did
        counting as the worst, ``difference``, the paired mean difference from the first loop over
        the pairs of which neither diverged, with ``significant``, whether its interval excludes
        zero; ``settled`` and ``diverged``, counts of paths; ``values`` of every path; and
        ``differs``, what sets a loop apart from the first.

    Raises:
        ParameterError: If there are fewer than two loops, or they have other joints.
    """
    _check(loops)
    names = list(loops)
    values = []
    for number, loop in enumerate(loops.values()):
        done = _told(progress, number * paths, len(names) * paths)
        run = ensemble(loop, paths, duration, confidence=confidence, progress=done, **options)
        if run.sizes["path"] < paths:
            raise KeyboardInterrupt  # the ensemble was
        values.append(_values(run, loop))
    rows = np.stack(values)  # (loop, metric, path)
    dataset = _statistics(rows, confidence)
    first = describe(loops[names[0]])
    apart = [differences(first, describe(loop)) for loop in loops.values()]
    told = {"ftcfa_version": run.attrs["ftcfa_version"], "confidence": confidence}
    told |= {name: run.attrs[name] for name in ("duration", "seed", "tolerance", "after")}
    return (
        dataset.assign(differs=("loop", apart))
        .assign_coords(loop=names, path=run["path"])
        .assign_attrs(told)
    )


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


def _told(
    progress: Callable[[int, int], None] | None, before: int, total: int
) -> Callable[[int, int], None] | None:
    return None if progress is None else lambda done, _: progress(before + done, total)


def _values(run: xr.Dataset, loop: ClosedLoop) -> Array:
    """Metrics of every path, shape (metric, path); NaN where it diverged, the settling time too."""
    limit = loop.arm.effort_limit
    rms = run["late_rms_error"].values
    settling = np.minimum(run["settling_time"].values, run.attrs["duration"])

    def over_limit(name: str) -> Array:
        return np.sqrt(np.mean((run[name].values / limit) ** 2, axis=1))

    return np.stack(
        [
            settling,
            rms,
            run["late_peak_error"].values,
            rms**2,
            over_limit("rms_torque"),
            over_limit("rms_torque_rate"),
            run["saturated"].values,
            1.0 - np.isfinite(run["settling_time"].values),
            1.0 * np.isfinite(run["diverged_at"].values),
            run["energy"].values,
        ]
    )


def _statistics(rows: Array, confidence: float) -> xr.Dataset:
    """Of metrics, shape (loop, metric, path)."""
    moments = [Moments.of(row.T).survivors() for row in rows]
    mean = [np.stack(one.skewness_corrected(confidence)) for one in moments]
    joint = 1.0 - (1.0 - confidence) / max(1, (len(rows) - 1) * rows.shape[1])
    difference = np.stack([_difference(row, rows[0], joint) for row in rows])
    low, high = difference[:, 1], difference[:, 2]
    quantiles = [[_quantiles(values) for values in row] for row in rows]
    unsettled, diverged = (rows[:, list(METRICS).index(share)] for share in SHARES)
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
            "metric": list(METRICS),
            "unit": ("metric", [unit for unit, _ in METRICS.values()]),
            "bound": list(BOUNDS),
            "quantile": list(QUANTILES),
        },
    )


def _difference(values: Array, first: Array, confidence: float) -> Array:
    """Paired differences of metrics, shape (metric, path), with intervals: (bound, metric)."""
    pairs = paired_differences(values.T, first.T).survivors()
    difference = np.stack(pairs.skewness_corrected(confidence))
    for share in SHARES:
        index = list(METRICS).index(share)
        difference[:, index] = _paired_shares(values[index], first[index], confidence)
    return difference


def _paired_shares(values: Array, first: Array, confidence: float) -> Array:
    """Difference of two shares over the same paths, estimate, low and high.

    Of the pairs that differ, one way or the other, Clopper and Pearson's interval of one way's
    share; it excludes a half just where McNemar's exact test rejects equality.
    """
    more, less = int(np.sum(values > first)), int(np.sum(values < first))
    if more + less == 0:
        return np.zeros(3)
    share = np.stack(proportion(more, more + less, confidence))
    return (2.0 * share - 1.0) * (more + less) / len(values)


def _quantiles(values: Array) -> Array:
    """A path that diverged is the worst of all."""
    return sample_quantile(np.where(np.isnan(values), np.inf, values), QUANTILES).value
