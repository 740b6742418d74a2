"""One chunk of an ensemble: its paths are run, then counted."""

from collections.abc import Iterator
from typing import cast

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.control.protocol import Signals
from ftcfa.engine.run import Run, run_paths, samples_of
from ftcfa.engine.simulate import SCALE
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.moments import Moments
from ftcfa.statistics.quantile_sketch import BINS, QuantileSketch
from ftcfa.study.path_metrics import PathMetrics
from ftcfa.study.plan import Plan

IN_CACHE = 2**17
"""Numbers counted at once: few enough to stay in the processor's cache."""
SUMS = ("count", "missing", "average", "M2", "M3")
PER_JOINT = ("error", "u")
"""Quantities of every joint: q - q_d and the torque."""
PATH_DIMENSIONS = ("path", "joint")
"""Dimensions of what has a value for each path, or for each of its joints."""


def quantities(n: int) -> int:
    """Number of quantities over time: the overall error, and those of each of n joints."""
    return 1 + len(PER_JOINT) * n


def run_chunk(loop: ClosedLoop, plan: Plan, paths: range, threads: int | None = None) -> xr.Dataset:
    """Run some paths of a loop, as `Plan.observed` gives it, and count them: see `count_chunk`."""
    return count_chunk(loop, plan, paths, simulate_chunk(loop, plan, paths, threads))


def simulate_chunk(loop: ClosedLoop, plan: Plan, paths: range, threads: int | None = None) -> Run:
    """Run some paths: the first half of `run_chunk`."""
    samples, numbers = samples_of(loop, plan.duration), np.array(paths, dtype=np.uint64)
    names = ["q", "u", "q_d"] if SCALE in loop.spread else ["q", "u"]
    return run_paths(loop, samples, plan.every(loop), plan.seed, numbers, names, {}, threads)


def count_chunk(loop: ClosedLoop, plan: Plan, paths: range, run: Run) -> xr.Dataset:
    """Count paths that were run: the second half of `run_chunk`.

    Returns:
        A Dataset with the metrics of each path (dimension ``path``), the sums of the moments of
        values and squares over (sum, power, time, quantity), and the filled bins of the sketch of
        quantiles: ``filled``, their numbers, and ``count``, the number of paths in each.
    """
    moments, filled, count = [], [], []
    for entry, values in _slices(loop, plan, run.paths.signals):
        moments.append(sums_of(Moments.of(np.stack([values, values * values], axis=1))))
        counts = QuantileSketch.of(values).counts.reshape(-1)
        bins = np.flatnonzero(counts != 0)
        filled.append((bins + entry * BINS).astype(np.uint32))
        count.append(counts[bins])
    return (
        metrics_of(loop, run)
        .assign_coords(path=np.array(paths))
        .assign(
            {
                "moments": (("sum", "power", "time", "quantity"), np.concatenate(moments, axis=2)),
                "filled": ("bin", np.concatenate(filled)),
                "count": ("bin", np.concatenate(count)),
            }
        )
    )


def metrics_of(loop: ClosedLoop, run: Run) -> xr.Dataset:
    """The metrics and the outcome of each path of an observed loop that was run."""
    per_path = cast(PathMetrics, loop.observer).results(run.paths.observed, loop.period)
    at = run.paths.diverged_at
    per_path["outcome_time"] = np.where(np.isfinite(at), at, per_path["outcome_time"])
    rows = {name: (PATH_DIMENSIONS[: rows.ndim], rows) for name, rows in per_path.items()}
    return xr.Dataset({**rows, "diverged_at": ("path", at)})


def _slices(loop: ClosedLoop, plan: Plan, signals: Signals) -> Iterator[tuple[int, Array]]:
    """Overall error, errors and torques at some times after another, shape (paths, t, 1 + 2 n).

    Each slice comes with the number of its first entry (time, quantity).
    """
    q, u, q_d = signals["q"], signals["u"], signals.get("q_d")
    if q_d is None:
        q_d = loop.desired(plan.times(loop)).q[None]
    entries = quantities(loop.arm.n)
    width = max(1, IN_CACHE // (len(q) * entries))
    for start in range(0, q.shape[1], width):
        times = slice(start, start + width)
        error = q[:, times] - q_d[:, times]
        squares = error * error
        ote = np.sqrt(sum(squares[:, :, j] for j in range(loop.arm.n)))
        yield start * entries, np.concatenate([ote[:, :, None], error, u[:, times]], axis=2)


def sums_of(moments: Moments) -> Array:
    """Moments as one array, shape (sum, ...)."""
    return np.stack([getattr(moments, name) for name in SUMS])


def moments_of(sums: Array) -> Moments:
    """The moments that `sums_of` put into an array."""
    count, missing, *rest = sums
    return Moments(count.astype(np.int64), missing.astype(np.int64), *rest)
