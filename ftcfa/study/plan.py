"""How an ensemble is run: its duration, seed and chunks, and the times at which it is recorded."""

import math
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import counting, natural, positive
from ftcfa.engine.run import samples_of
from ftcfa.errors import ParameterError
from ftcfa.loop.bounds import bounds_of
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.study.path_metrics import PathMetrics

RECORDED_TIMES = 200
"""Largest number of recorded times, about, where the user does not choose."""

_observed: WeakKeyDictionary[ClosedLoop, dict[Any, ClosedLoop]] = WeakKeyDictionary()


@dataclass(frozen=True)
class Plan:
    """How an ensemble is run: with its loop, all that its numbers depend on.

    Attributes:
        duration: Simulated time [s].
        seed: Seed of the random streams.
        record_every: Number of samples from one recorded time to the next; 0 records about 200
            times.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        chunk: Number of paths that are computed, stored and sent at once.
        after: Time from which errors count as late [s]; None takes half of the duration.
        lost: Error beyond which a joint has lost track, for each joint [rad or m]; None takes the
            default of `ftcfa.loop.bounds.bounds_of`.
    """

    duration: float
    seed: int = 0
    record_every: int = 0
    tolerance: float = 0.05
    chunk: int = 4096
    after: float | None = None
    lost: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        natural("seed", self.seed)
        natural("record_every", self.record_every)
        positive("tolerance", self.tolerance, "rad or m")
        counting("chunk", self.chunk)
        if self.after is not None and not 0 <= self.after < self.duration:
            limits = f"a number from 0 to below the {self.duration:g} s of a run"
            raise ParameterError("after", repr(self.after), limits)

    def observed(self, loop: ClosedLoop) -> ClosedLoop:
        """The loop with the observer that counts the metrics of each path.

        A loop always gets the same observed loop, so that it is traced only once.
        """
        known = _observed.setdefault(loop, {})
        key = (self.tolerance, self.late, self.lost)
        if key not in known:
            metrics = PathMetrics(self.tolerance, self.late, bounds_of(loop.arm, self.lost))
            known[key] = replace(loop, observer=metrics)
        return known[key]

    @property
    def late(self) -> float:
        """Time from which errors count as late [s]."""
        return self.duration / 2 if self.after is None else self.after

    def every(self, loop: ClosedLoop) -> int:
        """Number of samples from one recorded time to the next: 1, 2 or 5 times a power of ten."""
        if self.record_every:
            return self.record_every
        least = max(1.0, (samples_of(loop, self.duration) - 1) / RECORDED_TIMES)
        decade = 10 ** math.floor(math.log10(least))
        return next(step * decade for step in (1, 2, 5, 10) if step * decade >= least)

    def times(self, loop: ClosedLoop) -> Array:
        """Recorded times, shape (T,) [s]."""
        samples = samples_of(loop, self.duration)
        return np.arange(0, samples, self.every(loop)) * loop.period

    def paths_of(self, chunk: int, paths: int) -> range:
        """Path numbers of a chunk of an ensemble."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, paths))

    def chunks(self, paths: int) -> range:
        """Numbers of the chunks of an ensemble."""
        return range(-(-paths // self.chunk))
