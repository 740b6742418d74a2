"""Tables of measurements, and of whether they reach their targets."""

import math
from collections.abc import Iterable

from rich.console import Console
from timing import Record

from ftcfa.report.terminal import print_line, print_table


def number(value: float | None) -> str:
    """A number for a table, to three digits or more."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.3g}" if value < 100 else f"{value:,.0f}"


def show(console: Console, title: str, heads: list[str], rows: Iterable[Iterable[object]]) -> None:
    """Print a table of words, counts and measured numbers, its first column to the left."""
    print_line(f"\n{title}", console)
    print_table(heads, ([x if isinstance(x, str) else number(x) for x in r] for r in rows), console)


def show_skipped(console: Console, skipped: dict[str, str]) -> None:
    """Print which contenders were left out, and why."""
    for name, reason in skipped.items():
        print_line(f"skipped: {name}: {reason}", console)


def target(question: str, value: float | None, relation: str, bound: float) -> Record:
    """A target: a value that is ``>=`` or ``<=`` a bound; None if it was not measured."""
    met = None
    if value is not None:
        met = value >= bound if relation == ">=" else value <= bound
    return {"target": question, "value": value, "bound": f"{relation} {bound:g}", "met": met}


def show_targets(console: Console, targets: list[Record]) -> None:
    """Print which targets are met."""
    answers = {True: "met", False: "NOT MET", None: "not measured"}
    rows = (
        [each["target"], each["value"], each["bound"], answers[each["met"]]] for each in targets
    )
    show(console, "Targets", ["", "measured", "required", ""], rows)
