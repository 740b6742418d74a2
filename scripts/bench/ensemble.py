"""What do the statistics of an ensemble, and a store, cost beside the engine alone?

The bare engine runs the same chunks of paths and records the same signals, but keeps nothing.
The shortest time of each counts, on the clock and of the processor; the latter hardly depends on
what else the machine does. The cost of a call that does not depend on the number of paths
(tracing, the summary, its file) is subtracted and shown by itself: the time of one chunk is
subtracted from that of all.
"""

import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from tables import show
from timing import Effort, Record

import ftcfa
from ftcfa.arrays import Array
from ftcfa.study.chunk import simulate_chunk
from ftcfa.study.plan import Plan
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

UNCERTAINTY = ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1)
DURATION, QUICK_DURATION = 5.0, 0.5
"""Simulated time of a path [s]."""
CHUNKS, TURNS = 3, 3


def measure(effort: Effort) -> Record:
    """The rows of every loop."""
    rows = []
    for name, loop in loops().items():
        rows += [{"loop": name, **row} for row in _measure_loop(loop, effort)]
    return {"rows": rows}


def loops() -> dict[str, ftcfa.ClosedLoop]:
    """The paper's pendulum and a Panda, as it is and with another robot for every path."""
    arm = ftcfa.load_arm("panda")
    panda = ftcfa.ClosedLoop(
        arm=arm,
        controller=ftcfa.FTCF(arm, compensation="bias"),
        reference=ftcfa.Sinusoid(amplitude=0.3, offset=arm.home),
        vibration=ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1)),
    )
    uncertain = replace(panda, uncertainty=UNCERTAINTY)
    return {"pendulum": closed_loop(FINITE_TIME), "panda": panda, "uncertain panda": uncertain}


def contenders(
    loop: ftcfa.ClosedLoop, duration: float, threads: int
) -> dict[str, Callable[[int], object]]:
    """Functions that run a number of chunks, by name."""
    plan = Plan(duration)

    def bare(chunks: int) -> None:
        for chunk in range(chunks):
            simulate_chunk(loop, plan, plan.paths_of(chunk, chunks * plan.chunk), threads)

    def statistics(chunks: int, store: str | None = None) -> None:
        ftcfa.ensemble(loop, chunks * plan.chunk, duration, threads=threads, store=store)

    def stored(chunks: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            statistics(chunks, str(Path(folder) / "store"))

    return {"engine": bare, "statistics": statistics, "statistics and store": stored}


def seconds(run: Callable[[int], object], chunks: int) -> Array:
    """Time that some chunks take, on the clock and of the processor, shape (2,) [s]."""
    start = np.array([time.perf_counter(), time.process_time()])
    run(chunks)
    return np.array([time.perf_counter(), time.process_time()]) - start


def _measure_loop(loop: ftcfa.ClosedLoop, effort: Effort) -> list[Record]:
    """A row of each contender."""
    duration, turns = (QUICK_DURATION, 1) if effort.quick else (DURATION, TURNS)
    runs = contenders(loop, duration, effort.threads)
    once, often = ({name: np.full(2, np.inf) for name in runs} for _ in range(2))
    for run in runs.values():
        run(1)
    for _ in range(turns):
        for name, run in runs.items():
            once[name] = np.minimum(once[name], seconds(run, 1))
            often[name] = np.minimum(often[name], seconds(run, CHUNKS))
    steps = Plan(duration).chunk * duration / loop.period
    chunk = {name: (often[name] - once[name]) / (CHUNKS - 1) for name in runs}
    return [
        {
            "contender": name,
            "us": float(1e6 * took[0] / steps),
            "processor_us": float(1e6 * took[1] / steps),
            "over_engine": (took / chunk["engine"] - 1).tolist(),
            "call_s": float((once[name] - took)[0]),
        }
        for name, took in chunk.items()
    ]


def print_tables(record: Record, console: Console) -> None:
    """Print the times on the clock and of the processor, and the cost of a call."""
    title = "Ensembles: microseconds per path-step, and how much more than the engine alone"
    heads = ["loop", "what", "clock", "more", "processor", "more", "call s"]
    rows = []
    for row in record["rows"]:
        clock, processor = (f"{more:+.0%}" for more in row["over_engine"])
        times = [row["us"], clock, row["processor_us"], processor, row["call_s"]]
        rows.append([row["loop"], row["contender"], *times])
    show(console, title, heads, rows)
