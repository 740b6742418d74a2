"""How fast is ftcfa, and how fast are others on the same machine?

    python scripts/bench [QUESTION ...] [--quick] [--threads N] [--json FILE]

A question a module: `arms`, `pendulum`, `paths`, `ensemble`, `hardware`; all of them by default.

The unit is microseconds per path-step: one sample of one path of the whole closed loop (plant,
noise, controller, filter, adaptation), 1 ms long, one integration step. Contenders take turns and
the shortest time of each counts, so that other load of the machine hits all alike. Times are those
of the run alone: from the time of a call of `simulate_paths` that of a call for a single sample
(finding the code, the Dataset) is subtracted and shown by itself. A package that is not installed
is left out with a line that says so.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would spin beside the contenders

import argparse
import json
from pathlib import Path

import arms
import ensemble
import hardware
import paths
import pendulum
from machine import machine, print_machine
from rich.console import Console
from tables import show_targets
from timing import Effort, Record

from ftcfa.engine.compiled import usable_cores

QUESTIONS = {
    "arms": arms,
    "pendulum": pendulum,
    "paths": paths,
    "ensemble": ensemble,
    "hardware": hardware,
}


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    parser.add_argument(
        "questions", nargs="*", metavar="QUESTION", help=f"{', '.join(QUESTIONS)}; all by default"
    )
    parser.add_argument("--quick", action="store_true", help="coarse, in two minutes")
    parser.add_argument(
        "--threads", type=int, help="number of threads, measured beside one; by default all cores"
    )
    parser.add_argument(
        "--json", metavar="FILE", help="file for all numbers; - for standard output alone"
    )
    options = parser.parse_args()
    threads = options.threads or usable_cores()
    if threads < 1:
        parser.error("--threads: at least 1")
    for name in options.questions:
        if name not in QUESTIONS:
            parser.error(f"QUESTION: {name}, expected one of: {', '.join(QUESTIONS)}")
    turns, seconds = (3, 0.08) if options.quick else (12, 0.15)
    effort = Effort(threads, turns, seconds, options.quick)
    console = Console(stderr=options.json == "-", width=110)
    record = answer(options.questions or list(QUESTIONS), effort, console)
    if options.json == "-":
        print(json.dumps(record, indent=2))
    elif options.json:
        Path(options.json).write_text(json.dumps(record, indent=2) + "\n")


def answer(names: list[str], effort: Effort, console: Console) -> Record:
    """Measure the answers to some questions and print them."""
    record: Record = {"machine": machine(), "effort": vars(effort)}
    print_machine(record["machine"], console)
    targets = []
    for name in names:
        with console.status(name):
            record[name] = QUESTIONS[name].measure(effort)
        QUESTIONS[name].print_tables(record[name], console)
        targets += record[name].get("targets", [])
    if targets:
        show_targets(console, targets)
    return record


if __name__ == "__main__":
    main()
