"""Tables of measurements, and of whether they reach their targets."""

import math
from collections.abc import Iterable

from rich.console import Console
from timing import Record

from ftcfa.report.terminal import plain_table, print_fitted


def number(value: float | None) -> str:
    """A number for a table, to three digits or more."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.3g}" if value < 100 else f"{value:,.0f}"


def show(console: Console, title: str, heads: list[str], rows: Iterable[Iterable[object]]) -> None:
    """Print a table of words, counts and measured numbers, its first column to the left."""
    table = plain_table()
    for i, head in enumerate(heads):
        table.add_column(head, justify="right" if i else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(x if isinstance(x, str) else number(x) for x in row))
    console.print(f"\n{title}", highlight=False)
    print_fitted(table, console)


def show_skipped(console: Console, skipped: dict[str, str]) -> None:
    """Print which contenders were left out, and why."""
    for name, reason in skipped.items():
        console.print(f"skipped: {name}: {reason}", highlight=False, markup=False)


def at_least(question: str, value: float | None, bound: float) -> Record:
    """A target that a value must reach; None if it was not measured."""
    met = None if value is None else value >= bound
    return {"target": question, "value": value, "bound": f">= {bound:g}", "met": met}


def at_most(question: str, value: float | None, bound: float) -> Record:
    """A target that a value must not exceed; None if it was not measured."""
    met = None if value is None else value <= bound
    return {"target": question, "value": value, "bound": f"<= {bound:g}", "met": met}


def show_targets(console: Console, targets: list[Record]) -> None:
    """Print which targets are met."""
    answers = {True: "met", False: "NOT MET", None: "not measured"}
    show(
        console,
        "Targets",
        ["", "measured", "required", ""],
        ([each["target"], each["value"], each["bound"], answers[each["met"]]] for each in targets),
    )
