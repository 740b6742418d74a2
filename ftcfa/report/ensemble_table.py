"""The table of an ensemble, and the facts above it."""

import math
from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ftcfa.report.terminal import number, plain_table, print_facts, print_fitted
from ftcfa.study.metrics.table import METRICS

LEVELS = ("median", "95 %")
"""Quantiles over paths that the table shows."""


def print_ensemble(record: Mapping[str, Any], console: Console) -> None:
    """Print the facts and the table of an ensemble, and the meaning of its columns.

    Args:
        record: Result of `ensemble_record`.
        console: Where to print.
    """
    print_facts(_facts(record), console)
    console.print()
    print_fitted(_metrics_table(record), console)
    percent = f"{100 * record['confidence']:g} %"
    console.print(
        f"\nMedian and 95 % quantile over the paths, with distribution-free {percent} intervals. "
        "A path that diverged counts as the worst of all; for settled errors, a path that never "
        f"settled does too. Late errors are those from {record['after']:g} s on. Of a metric of "
        "each joint, the row shows the joint with the largest median; summary.json has all.",
        style="dim", highlight=False, markup=False,
    )  # fmt: skip


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what is true of the whole ensemble."""
    square = record["mean_square_error"]
    facts = [
        ("paths", _paths(record)),
        ("diverged", _diverged(record["diverged"])),
        *_settling(record),
        ("E|z1|^2", f"{_estimate(square)} {square['unit']} at {square['time']:g} s"),
    ]
    if "not_diverged" in square:
        facts.append(("not diverged", f"{_estimate(square['not_diverged'])} {square['unit']}"))
    return [*facts, ("Definition 1", _definition_1(record))]


def _settling(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of the settling."""
    duration, settled = record["duration"], record["settling_time"]
    within = f"to within {record['tolerance']:g} {record['units']['error']} until the end"
    missing = f"later than {duration:g}"
    texts = [
        f"{100 * row['share']:g} %: {missing if row['low'] is None else _estimate(row, missing)} s"
        for row in settled["quantiles"]
    ]
    return [
        (
            "settled",
            f"{settled['settled']:,}, {within}; {settled['not_settled']:,} not by {duration:g} s",
        ),
        *zip(("settling time", *[""] * (len(texts) - 1)), texts, strict=True),
    ]


def _definition_1(record: Mapping[str, Any]) -> str:
    """Whether E|z1|^2 stays below epsilon, and from when on."""
    if record["paths"] == 1:
        return "one path gives no interval"
    practical, unit = record["practical_settling"], record["mean_square_error"]["unit"]
    reached = practical["time"]
    answer = "is not below" if reached is None else "stays below"
    since = "at the end" if reached is None else f"from {reached:g} s on"
    return (
        f"the {50 * (1 + record['confidence']):g} % upper bound of E|z1|^2 {answer} "
        f"epsilon = tolerance^2 = {practical['epsilon']:.4g} {unit} {since}"
    )


def _paths(record: Mapping[str, Any]) -> str:
    """Number, seed and length of the paths."""
    text = f"{record['paths']:,} of seed {record['seed']}, {record['duration']:g} s each"
    if record["paths"] < record["requested"]:
        text += f"; interrupted, {record['requested']:,} were requested"
    return text


def _diverged(diverged: Mapping[str, Any]) -> str:
    """Number and share of the diverged paths, and the first of them."""
    share = diverged["share"]
    text = f"{diverged['count']:,}, a share of {share['low']:.2g} to {share['high']:.2g}"
    if diverged["count"]:
        more = ", ..." if diverged["count"] > len(diverged["first_paths"]) else ""
        text += f": paths {', '.join(map(str, diverged['first_paths']))}{more}"
    return text


def _metrics_table(record: Mapping[str, Any]) -> Table:
    """A table of two lines a metric: name and values; joint, unit and intervals."""
    table = plain_table()
    table.add_column("")
    for label in LEVELS:
        table.add_column(label, justify="right", no_wrap=True)
    table.add_column("largest\nof path", justify="right", no_wrap=True)
    for row in _shown(record["metrics"]):
        below = f"{row.get('joint', '')} [{row['unit']}]".strip()
        cells = [f"{number(row[x]['estimate'])}\n{_interval(row[x])}" for x in LEVELS]
        largest = f"{number(row.get('largest'))}\n{row.get('path', '-')}"
        table.add_row(Text(f"{METRICS[row['metric']].label}\n{below}"), *cells, largest)
    return table


def _shown(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row a metric: of several joints, that with the largest median."""
    best: dict[str, dict[str, Any]] = {}
    for row in rows:
        if row["metric"] not in best or _median(row) > _median(best[row["metric"]]):
            best[row["metric"]] = row
    return list(best.values())


def _median(row: Mapping[str, Any]) -> float:
    """Median of a row; infinite if it is missing, as half of the paths diverged."""
    value = row["median"]["estimate"]
    return math.inf if value is None else float(value)


def _estimate(bounds: Mapping[str, Any], missing: str = "-") -> str:
    """An estimate with its interval."""
    return f"{number(bounds['estimate'], missing=missing)} ({_interval(bounds, missing)})"


def _interval(bounds: Mapping[str, Any], missing: str = "-") -> str:
    """The ends of an interval."""
    return " to ".join(number(bounds[end], missing=missing) for end in ("low", "high"))
