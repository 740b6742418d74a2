"""One chunk of an ensemble: its paths run, watched and counted; what merges over chunks."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast
from weakref import WeakKeyDictionary

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.checks import counting, natural, positive
from ftcfa.control.protocol import Signals
from ftcfa.engine.run import Run, run_paths, samples_of
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.moments import Moments
from ftcfa.statistics.quantile_sketch import BINS, QuantileSketch
from ftcfa.study.path_metrics import PathMetrics

KEPT_TIMES = 200
"""About how many times are kept where the user does not say how many."""
IN_CACHE = 2**17
"""Numbers counted at once: few enough to stay in the processor's cache."""
SUMS = ("count", "missing", "average", "M2", "M3")
PER_JOINT = ("error", "u")
"""Quantities of every joint: q - q_d and the torque."""
PATH_DIMENSIONS = ("path", "joint")
"""Of what is known of each path, or of each of its joints."""


_watched: WeakKeyDictionary[ClosedLoop, dict[tuple[float, float], ClosedLoop]] = WeakKeyDictionary()


@dataclass(frozen=True)
class Plan:
    """How an ensemble is run: with its loop, all that its numbers depend on.

    Attributes:
        duration: Simulated time [s].
        seed: Of the random streams.
        record_every: Statistics over time are kept at every so many samples; 0 takes about 200
            times.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        chunk: Paths a chunk: what is computed, stored and sent at once.
        after: Time from which errors count as late [s]; None takes half of the duration.
    """

    duration: float
    seed: int = 0
    record_every: int = 0
    tolerance: float = 0.05
    chunk: int = 4096
    after: float | None = None

    def __post_init__(self) -> None:
        natural("seed", self.seed)
        natural("record_every", self.record_every)
        positive("tolerance", self.tolerance, "rad or m")
        counting("chunk", self.chunk)
        if self.after is not None and not 0 <= self.after < self.duration:
            limits = f"a number from 0 to below the {self.duration:g} s of a run"
            raise ParameterError("after", repr(self.after), limits)

    def watched(self, loop: ClosedLoop) -> ClosedLoop:
        """The loop with an observer that counts what each path amounts to.

        The same object for the same loop, so that it is traced only once.
        """
        known = _watched.setdefault(loop, {})
        if (self.tolerance, self.late) not in known:
            metrics = PathMetrics(self.tolerance, self.late)
            known[self.tolerance, self.late] = replace(loop, observer=metrics)
        return known[self.tolerance, self.late]

    @property
    def late(self) -> float:
        """Time from which errors count as late [s]."""
        return self.duration / 2 if self.after is None else self.after

    def every(self, loop: ClosedLoop) -> int:
        """Samples from one kept time to the next."""
        if self.record_every:
            return self.record_every
        wanted = max(1.0, (samples_of(loop, self.duration) - 1) / KEPT_TIMES)
        decade = 10 ** math.floor(math.log10(wanted))
        return next(step * decade for step in (1, 2, 5, 10) if step * decade >= wanted)

    def times(self, loop: ClosedLoop) -> Array:
        """The kept times, shape (T,) [s]."""
        samples = samples_of(loop, self.duration)
        return np.arange(0, samples, self.every(loop)) * loop.period

    def paths_of(self, chunk: int, paths: int) -> range:
        """Path numbers of a chunk of an ensemble."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, paths))

    def chunks(self, paths: int) -> range:
        """Numbers of the chunks of an ensemble."""
        return range(-(-paths // self.chunk))


def quantities(n: int) -> int:
    """Quantities kept over time: the overall error, and those of every joint."""
    return 1 + len(PER_JOINT) * n


def run_chunk(loop: ClosedLoop, plan: Plan, paths: range, threads: int | None = None) -> xr.Dataset:
    """Run some paths and count them.

    Args:
        loop: The closed loop, ``plan.watched``.
        plan: How it is run.
        paths: Path numbers.
        threads: Threads; all that this process may use by default.

    Returns:
        As `count_chunk`.
    """
    return count_chunk(loop, plan, paths, simulate_chunk(loop, plan, paths, threads))


def simulate_chunk(loop: ClosedLoop, plan: Plan, paths: range, threads: int | None = None) -> Run:
    """Run some paths: the first half of `run_chunk`."""
    samples, numbers = samples_of(loop, plan.duration), np.array(paths, dtype=np.uint64)
    return run_paths(loop, samples, plan.every(loop), plan.seed, numbers, ["q", "u"], {}, threads)


def count_chunk(loop: ClosedLoop, plan: Plan, paths: range, run: Run) -> xr.Dataset:
    """Count paths that were run: the second half of `run_chunk`.

    Returns:
        A Dataset with the metrics of each path (dimension ``path``), the sums of the moments of
        values and squares over (sum, power, time, quantity), and the filled bins of the sketch of
        quantiles, ``filled`` with the paths in each, ``count``.
    """
    metrics = cast(PathMetrics, loop.observer)
    moments, filled, count = [], [], []
    for entry, values in _slices(loop, plan, run.paths.signals):
        moments.append(_sums(Moments.of(np.stack([values, values * values], axis=1))))
        counts = QuantileSketch.of(values).counts.reshape(-1)
        bins = np.flatnonzero(counts != 0)
        filled.append((bins + entry * BINS).astype(np.uint32))
        count.append(counts[bins])
    per_path = metrics.results(run.paths.observed, loop.period)
    return xr.Dataset(
        {
            **{name: (PATH_DIMENSIONS[: rows.ndim], rows) for name, rows in per_path.items()},
            "diverged_at": ("path", run.paths.died),
            "moments": (("sum", "power", "time", "quantity"), np.concatenate(moments, axis=2)),
            "filled": ("bin", np.concatenate(filled)),
            "count": ("bin", np.concatenate(count)),
        },
        coords={"path": np.array(paths)},
        attrs={"engine": run.engine},
    )


def _slices(loop: ClosedLoop, plan: Plan, signals: Signals) -> Iterator[tuple[int, Array]]:
    """Overall error, errors and torques at some times, shape (paths, t, 1 + 2 n), in turn.

    With the number of the first of these entries (time, quantity).
    """
    q, u, q_d = signals["q"], signals["u"], loop.reference.at(plan.times(loop)).q
    entries = quantities(loop.arm.n)
    width = max(1, IN_CACHE // (len(q) * entries))
    for start in range(0, len(q_d), width):
        times = slice(start, start + width)
        error = q[:, times] - q_d[times]
        ote = np.sqrt(np.einsum("ptj,ptj->pt", error, error))
        yield start * entries, np.concatenate([ote[:, :, None], error, u[:, times]], axis=2)


def _sums(moments: Moments) -> Array:
    return np.stack([getattr(moments, name) for name in SUMS])


def _moments(sums: Array) -> Moments:
    count, missing, *rest = sums
    return Moments(count.astype(np.int64), missing.astype(np.int64), *rest)


class Merging:
    """Moments merged in pairs of neighbours, so that the order in which they come is no matter.

    A pair is merged when both are there, then pairs of pairs; what is held grows with the logarithm
    of their number only.
    """

    def __init__(self) -> None:
        self._parts: dict[tuple[int, int], Moments] = {}  # by first number and width

    def add(self, number: int, moments: Moments) -> None:
        """Add the moments of a number."""
        width = 1
        while (neighbour := (number ^ width, width)) in self._parts:
            other = self._parts.pop(neighbour)
            pair = (moments, other) if number < neighbour[0] else (other, moments)
            moments = pair[0].merge(pair[1])
            number, width = number & ~width, 2 * width
        self._parts[number, width] = moments

    @property
    def total(self) -> Moments:
        """Of all that were added."""
        first, *rest = (self._parts[key] for key in sorted(self._parts))
        for part in rest:
            first = first.merge(part)
        return first


class Tally:
    """What chunks add up to: the same bits in whatever order they come.

    Args:
        times: Kept times.
        n: Joints.
    """

    def __init__(self, times: int, n: int) -> None:
        self._sketch = QuantileSketch.empty((times, quantities(n)))
        self._merging = Merging()
        self._per_path: dict[int, dict[str, Array]] = {}
        self.paths = 0
        """Paths in the chunks."""

    def add(self, number: int, chunk: xr.Dataset) -> None:
        """Add a chunk."""
        counts = self._sketch.counts.reshape(-1)
        counts[chunk["filled"].values] += chunk["count"].values
        self._merging.add(number, _moments(chunk["moments"].values))
        names = [name for name, rows in chunk.variables.items() if "path" in rows.dims]
        self._per_path[number] = {str(name): chunk[name].values.copy() for name in names}
        self.paths += chunk.sizes["path"]

    def __len__(self) -> int:
        return len(self._per_path)

    @property
    def sketch(self) -> QuantileSketch:
        """Quantiles over time, entries (time, quantity)."""
        return self._sketch

    @property
    def moments(self) -> tuple[Moments, Moments]:
        """Of the quantities and of their squares, entries (time, quantity)."""
        sums = _sums(self._merging.total)
        return _moments(sums[:, 0]), _moments(sums[:, 1])

    @property
    def per_path(self) -> xr.Dataset:
        """What is known of each path, by path number."""
        parts = [self._per_path[number] for number in sorted(self._per_path)]
        rows = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return xr.Dataset({name: (PATH_DIMENSIONS[: x.ndim], x) for name, x in rows.items()})
