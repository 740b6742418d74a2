"""What do the statistics of an ensemble, and a store, cost beside the engine alone?

    python scripts/bench_ensemble.py [LOOP ...] [--duration S] [--chunks N] [--turns N]

The bare engine runs the same chunks of paths and records the same signals, and throws them away.
Contenders take turns and the shortest time of each counts, on the clock and of the processor; the
latter hardly depends on what else the machine does. What a call costs whatever the number of paths
(tracing, the summary, its file) is taken off and shown by itself: the time of one chunk is
subtracted from that of all.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Sinusoid,
    Uncertainty,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
)
from ftcfa.arrays import Array
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.study.chunk import simulate_chunk
from ftcfa.study.plan import Plan
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

UNCERTAINTY = Uncertainty(mass=0.2, centre=0.01, shape=0.1)


def loops() -> dict[str, ClosedLoop]:
    """The paper's pendulum and a Panda, as it is and with a robot of its own for every path."""
    arm = load_arm("panda")
    panda = ClosedLoop(
        arm=arm,
        controller=FTCF(arm, compensation="bias"),
        reference=Sinusoid(amplitude=0.3, offset=arm.home),
        vibration=Vibration(BaseAcceleration(), WhiteNoise(0.1)),
    )
    uncertain = replace(panda, uncertainty=UNCERTAINTY)
    return {"pendulum": closed_loop(FINITE_TIME), "panda": panda, "uncertain panda": uncertain}


def contenders(
    loop: ClosedLoop, duration: float, threads: int | None
) -> dict[str, Callable[[int], object]]:
    """What runs a number of chunks."""
    plan = Plan(duration)

    def bare(chunks: int) -> None:
        for chunk in range(chunks):
            simulate_chunk(loop, plan, plan.paths_of(chunk, chunks * plan.chunk), threads)

    def statistics(chunks: int, store: str | None = None) -> None:
        ensemble(loop, chunks * plan.chunk, duration, threads=threads, store=store)

    def stored(chunks: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            statistics(chunks, str(Path(folder) / "store"))

    return {"engine": bare, "statistics": statistics, "statistics and store": stored}


def seconds(run: Callable[[int], object], chunks: int) -> Array:
    """How long some chunks take: on the clock, and of the processor."""
    start = np.array([time.perf_counter(), time.process_time()])
    run(chunks)
    return np.array([time.perf_counter(), time.process_time()]) - start


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("loops", nargs="*", help="all by default", metavar="LOOP")
    parser.add_argument("--duration", type=float, default=5.0, help="of a path [s]")
    parser.add_argument("--chunks", type=int, default=3)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--threads", type=int)
    asked = parser.parse_args()
    table = plain_table()
    for column in ("loop", "what"):
        table.add_column(column)
    for column in (
        "us a path-step",
        "over the engine",
        "processor",
        "over the engine",
        "a call [s]",
    ):
        table.add_column(column, justify="right")
    for name, loop in loops().items():
        if not asked.loops or name in asked.loops:
            for row in rows(loop, asked):
                table.add_row(name, *row)
    print_fitted(table, Console())


def rows(loop: ClosedLoop, asked: argparse.Namespace) -> Iterator[tuple[str, ...]]:
    """What each contender takes."""
    runs = contenders(loop, asked.duration, asked.threads)
    once, often = ({what: np.full(2, np.inf) for what in runs} for _ in range(2))
    for run in runs.values():
        run(1)
    for _ in range(asked.turns):
        for what, run in runs.items():
            once[what] = np.minimum(once[what], seconds(run, 1))
            often[what] = np.minimum(often[what], seconds(run, asked.chunks))
    steps = Plan(asked.duration).chunk * asked.duration / loop.period
    chunk = {what: (often[what] - once[what]) / (asked.chunks - 1) for what in runs}
    for what, took in chunk.items():
        over = [f"{share - 1:+.0%}" for share in took / chunk["engine"]]
        clock, processor = (f"{1e6 * each / steps:.4f}" for each in took)
        yield what, clock, over[0], processor, over[1], f"{(once[what] - took)[0]:.2f}"


if __name__ == "__main__":
    main()
