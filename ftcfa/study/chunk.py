"""One chunk of an ensemble: its paths run, watched and counted; what merges over chunks."""

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import xarray as xr

from ftcfa.arrays import Array, counting, positive
from ftcfa.engine.run import run_paths, samples_of
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.metrics import PathMetrics
from ftcfa.streams import natural
from ftcfa.study.moments import Moments
from ftcfa.study.sketch import QuantileSketch

KEPT_TIMES = 200
"""About how many times are kept where the user does not say how many."""
POWERS = ("value", "square")
SUMS = ("count", "missing", "average", "M2", "M3")
PER_JOINT = ("error", "u")
"""Quantities of every joint: q - q_d and the torque."""


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
        positive("tolerance", self.tolerance, "[rad or m]")
        counting("chunk", self.chunk)

    def watched(self, loop: ClosedLoop) -> ClosedLoop:
        """The loop with an observer that counts what each path amounts to."""
        return replace(loop, observer=PathMetrics(self.tolerance, self.late))

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
        A Dataset with the metrics of each path (dimension ``path``), the sums of the moments over
        (power, sum, time, quantity), and the filled bins of the sketch of quantiles, ``filled``
        with the paths in each, ``count``.
    """
    metrics = cast(PathMetrics, loop.observer)
    samples, every = samples_of(loop, plan.duration), plan.every(loop)
    numbers = np.arange(paths.start, paths.stop, dtype=np.uint64)
    run = run_paths(loop, samples, every, plan.seed, numbers, ["q", "u"], {}, threads)
    signals, died, observed = run.paths
    values = _quantities(loop, plan, signals["q"], signals["u"])
    moments = np.stack([_sums(Moments.of(values)), _sums(Moments.of(values**2))])
    counts = QuantileSketch.of(values).counts.reshape(-1)
    filled = np.flatnonzero(counts).astype(np.uint32)
    per_path = {
        name: (("path", "joint")[: result.ndim], result)
        for name, result in metrics.results(observed, loop.period).items()
    }
    return xr.Dataset(
        {
            **per_path,
            "diverged_at": ("path", died),
            "moments": (("power", "sum", "time", "quantity"), moments),
            "filled": ("bin", filled),
            "count": ("bin", counts[filled]),
        },
        coords={"path": numbers.astype(np.int64)},
        attrs={"engine": run.engine},
    )


def _quantities(loop: ClosedLoop, plan: Plan, q: Array, u: Array) -> Array:
    """Overall error, errors and torques, shape (paths, T, 1 + 2 n)."""
    error = q - loop.reference.at(plan.times(loop)).q
    ote = np.sqrt(np.einsum("ptj,ptj->pt", error, error))
    return np.concatenate([ote[:, :, None], error, u], axis=2)


def _sums(moments: Moments) -> Array:
    return np.stack([getattr(moments, name) for name in SUMS])


class Tally:
    """What chunks add up to, in the order of their numbers whatever order they come in.

    Args:
        times: Kept times.
        n: Joints.
    """

    def __init__(self, times: int, n: int) -> None:
        self._sketch = QuantileSketch.empty((times, quantities(n)))
        self._chunks: dict[int, xr.Dataset] = {}

    def add(self, number: int, chunk: xr.Dataset) -> None:
        """Add a chunk."""
        counts = self._sketch.counts.reshape(-1)
        counts[chunk["filled"].values] += chunk["count"].values
        self._chunks[number] = chunk.drop_dims("bin")

    def __len__(self) -> int:
        return len(self._chunks)

    @property
    def paths(self) -> int:
        """Paths in the chunks."""
        return sum(chunk.sizes["path"] for chunk in self._chunks.values())

    @property
    def sketch(self) -> QuantileSketch:
        """Quantiles over time, entries (time, quantity)."""
        return self._sketch

    @property
    def moments(self) -> tuple[Moments, Moments]:
        """Of the quantities and of their squares, entries (time, quantity)."""
        rows = [self._chunks[number]["moments"].values for number in sorted(self._chunks)]
        value, square = ([_moments(row[power]) for row in rows] for power in range(len(POWERS)))
        return _merged(value), _merged(square)

    @property
    def per_path(self) -> xr.Dataset:
        """What is known of each path, by path number."""
        parts = [self._chunks[number].drop_vars("moments") for number in sorted(self._chunks)]
        return xr.concat(parts, "path")


def _moments(rows: Array) -> Moments:
    """From an array over SUMS."""
    count, missing, *sums = rows
    return Moments(count.astype(np.int64), missing.astype(np.int64), *sums)


def _merged(parts: list[Moments]) -> Moments:
    total = parts[0]
    for part in parts[1:]:
        total = total.merge(part)
    return total
