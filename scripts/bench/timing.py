"""Contenders, and how they are measured: in turns, the shortest time of each counts."""

import math
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

Record = dict[str, Any]


@dataclass(frozen=True)
class Effort:
    """How carefully to measure.

    Attributes:
        threads: Largest number of threads.
        turns: Number of turns of each contender.
        seconds: Length of a turn [s].
        quick: Whether to leave out what takes long.
    """

    threads: int
    turns: int
    seconds: float
    quick: bool

    @property
    def thread_counts(self) -> list[int]:
        """One thread, and the largest number."""
        return sorted({1, self.threads})


@dataclass
class Contender:
    """What is measured: ``run(ticks)`` advances some paths by some ticks.

    Attributes:
        name: Name in the tables.
        threads: Number of threads that it may use.
        run: The measured call.
        paths: Number of paths that it advances.
        has_fixed: Whether the time of ``run(1)`` is subtracted.
        ticks: Number of ticks of a measurement.
        times: Time of each turn [s].
        fixed: Time of ``run(1)`` in each turn [s].
    """

    name: str
    threads: int
    run: Callable[[int], object]
    paths: int
    has_fixed: bool = False
    ticks: int = 1
    times: list[float] = field(default_factory=list)
    fixed: list[float] = field(default_factory=list)

    def calibrate(self, seconds: float) -> None:
        """Warm up, and set the number of ticks so that a turn takes a given time or longer.

        It takes at least ten times as long as what is subtracted.
        """
        self.run(1)
        floor = self._shorter(1) if self.has_fixed else 0.0
        seconds = max(seconds, 10 * floor)
        while (taken := self._shorter(self.ticks) - floor) < seconds / 2:
            self.ticks *= 2
        self.ticks = math.ceil(self.ticks * seconds / taken)

    def _shorter(self, ticks: int) -> float:
        """The shorter time of two calls [s]."""
        return min(seconds_of(self.run, ticks) for _ in range(2))

    def take_turn(self) -> None:
        """Measure once."""
        self.times.append(seconds_of(self.run, self.ticks))
        if self.has_fixed:
            self.fixed.append(seconds_of(self.run, 1))

    @property
    def microseconds(self) -> float:
        """Time of a path-step [us]."""
        seconds, ticks = min(self.times), self.ticks
        if self.has_fixed:
            seconds, ticks = seconds - min(self.fixed), ticks - 1
        return 1e6 * seconds / (ticks * self.paths)

    def row(self) -> Record:
        """The measurement as plain data."""
        row = {"threads": self.threads, "paths": self.paths, "ticks": self.ticks}
        call = {"call_ms": 1e3 * min(self.fixed)} if self.has_fixed else {}
        spread = {"median_over_best": statistics.median(self.times) / min(self.times)}
        return {"contender": self.name, **row, "us": self.microseconds, **call, **spread}


def seconds_of(run: Callable[..., object], *arguments: object) -> float:
    """Time that a call takes [s]."""
    start = time.perf_counter()
    run(*arguments)
    return time.perf_counter() - start


def measured(contenders: list[Contender], effort: Effort) -> list[Record]:
    """The rows of contenders that are measured in turns."""
    for contender in contenders:
        contender.calibrate(effort.seconds)
    for _ in range(effort.turns):
        for contender in contenders:
            contender.take_turn()
    return [contender.row() for contender in contenders]


def microseconds(rows: list[Record], contender: str, threads: int | None = None) -> float:
    """Time of a path-step of a contender [us]; NaN if it was not measured.

    Args:
        rows: Rows of `measured`.
        contender: Its name.
        threads: Number of threads; None for the best one.
    """
    fitting = (r for r in rows if r["contender"] == contender and threads in (None, r["threads"]))
    return min((row["us"] for row in fitting), default=math.nan)


def ratios(rows: list[Record]) -> dict[str, float]:
    """Time of each contender over that of ftcfa, each at its best number of threads."""
    own = microseconds(rows, "ftcfa")
    others = dict.fromkeys(row["contender"] for row in rows)
    return {name: microseconds(rows, name) / own for name in others if name != "ftcfa"}
