"""How does the time of a path-step depend on the number of paths?"""

from dataclasses import replace

from contenders import compiled
from rich.console import Console
from tables import show
from timing import Effort, Record, measured

from ftcfa.study.reproduction import FINITE_TIME, closed_loop

COUNTS = (1, 8, 64, 1024, 10_000, 100_000)
"""Numbers of paths."""
TURNS = 4
"""Largest number of turns: the many paths take long."""


def measure(effort: Effort) -> Record:
    """The record of the paper's pendulum with few and with many paths."""
    loop, counts = closed_loop(FINITE_TIME), COUNTS[: -1 if effort.quick else None]
    fewer = replace(effort, turns=min(effort.turns, TURNS))
    return {"rows": measured([compiled(loop, effort.threads, paths) for paths in counts], fewer)}


def print_tables(paths: Record, console: Console) -> None:
    """Print the times, the speed and the cost of a call."""
    rows = paths["rows"]
    show(
        console,
        f"The paper's pendulum at {rows[0]['threads']} threads",
        ["paths", "us per path-step", "million path-steps/s", "call ms"],
        ([f"{r['paths']:,}", r["us"], 1 / r["us"], r["call_ms"]] for r in rows),
    )
