"""The record of an ensemble, or of one path, as facts and tables."""

import math
from collections.abc import Mapping
from typing import Any

from rich.console import Console

from ftcfa.report.ensemble import LEVELS
from ftcfa.report.joints import print_joints
from ftcfa.report.terminal import number, print_facts, print_line, print_table
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import OUTCOMES, WORDS

ONLY_OF_JOINTS = ("late_rms_joint_error", "late_peak_joint_error", "joint_saturated")
"""Those that the table of metrics does not show."""


def print_ensemble(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `ensemble_record`: facts, a table, and the meaning of its columns."""
    one = record["paths"] == 1
    print_facts(_facts_of_one(record) if one else _facts(record), console)
    console.print()
    (_print_values if one else _print_metrics)(record["metrics"], console)
    console.print()
    print_joints(record["joints"], console)
    if one:
        return  # what follows explains intervals
    percent = f"{100 * record['confidence']:g} %"
    print_line(
        f"\nMedian and 95 % quantile over the paths, with distribution-free {percent} intervals. "
        "A path that diverged counts as the worst of all; for settled errors, a path that never "
        f"settled does too. Late errors are those from {record['after']:g} s on. Of a metric of "
        "each joint, the row shows the joint with the largest median; summary.json has all.\n\n"
        "Of each joint: late errors, u over its limit, share of samples beyond that limit, torque "
        "rate and share of samples limited by the driver (medians over the paths; peaks of the "
        "worst path), and the number of paths that fail there.",
        console, "dim",
    )  # fmt: skip


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what is true of the whole ensemble."""
    square = record["mean_square_error"]
    facts = [
        ("paths", _paths(record)),
        ("hardware", record["hardware"]),
        *_outcome_facts(record),
        *_settling_facts(record),
        ("E|z1|^2", f"{_estimate(square)} {square['unit']} at {square['time']:g} s{_few(square)}"),
    ]
    if "not_diverged" in square:
        facts.append(("not diverged", f"{_estimate(square['not_diverged'])} {square['unit']}"))
    return [*facts, ("Definition 1", _definition_1(record))]


def _facts_of_one(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what is true of one path: no shares, and no intervals."""
    word = next(word for word in WORDS if record["outcomes"][word]["count"])
    outcome, settled = record["outcomes"][word], record["settling_time"]
    text = OUTCOMES[WORDS.index(word)]
    if "at" in outcome:
        joint = outcome["joints"][0]
        text += f" at {outcome['at'][0]:.4g} s{f', {joint}' if joint else ''}"
    within = f"to within {record['tolerance']:g} {record['units']['error']}"
    at = settled["quantiles"][0]["estimate"]
    time = f"at {at:.4g} s" if settled["settled"] else f"not by {record['duration']:g} s"
    return [
        ("path", _paths(record)), ("hardware", record["hardware"]), ("outcome", text),
        *_trouble_facts(record), ("settles", f"{time}, {within}"),
    ]  # fmt: skip


def _few(square: Mapping[str, Any]) -> str:
    """What to say where few paths carry a mean square."""
    return "; few paths carry it: run more, the interval may miss it" if square["by_few"] else ""


def _settling_facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of the settling."""
    duration, settled = record["duration"], record["settling_time"]
    within = f"to within {record['tolerance']:g} {record['units']['error']} until the end"
    missing = f"later than {duration:g}"
    texts = [
        f"{100 * row['share']:g} %: {missing if row['low'] is None else _estimate(row, missing)} s"
        for row in settled["quantiles"]
    ]
    counts = f"{settled['settled']:,}, {within}; {settled['not_settled']:,} not by {duration:g} s"
    labels = ("settling time", *[""] * (len(texts) - 1))
    return [("settled", counts), *zip(labels, texts, strict=True)]


def _definition_1(record: Mapping[str, Any]) -> str:
    """Whether E|z1|^2 stays below epsilon, and from when on."""
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


def _outcome_facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what became of the paths."""
    facts = []
    for word, label in zip(WORDS, OUTCOMES, strict=True):
        one = record["outcomes"][word]
        low, high = one["share"]["low"], one["share"]["high"]
        text = f"{one['count']:,}, a share of {low:.2g} to {high:.2g}"
        if one["count"] and "first_paths" in one:
            more = ", ..." if one["count"] > len(one["first_paths"]) else ""
            text += f": paths {', '.join(map(str, one['first_paths']))}{more}"
        if one["count"] or word in ("kept", "diverged"):
            facts.append((label, text))
    return facts + _trouble_facts(record)


def _trouble_facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what went wrong, where anything did."""
    facts, without = [], record["without_torque"]
    if without["paths"]:
        text = f"{without['samples']:,} samples of {without['paths']:,} paths: the law asked for "
        facts.append(("no torque", f"{text}a torque that is not finite, and started anew"))
    if record["diagnosis"]:
        facts.append(("diagnosis", record["diagnosis"]))
    return facts


def _print_values(metrics: list[dict[str, Any]], console: Console) -> None:
    """Print the metrics of one path; of several joints the largest."""
    rows = [
        [
            METRICS[row["metric"]].label, number(row["median"]["estimate"]), row["unit"],
            row.get("joint", ""),
        ]
        for row in _largest(metrics)
    ]  # fmt: skip
    print_table(["", "value", "unit", "joint"], rows, console, "lrl")


def _largest(metrics: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row of each metric; of several joints that with the largest median."""
    shown = dict.fromkeys(row["metric"] for row in metrics if row["metric"] not in ONLY_OF_JOINTS)
    return [max((row for row in metrics if row["metric"] == m), key=_median) for m in shown]


def _print_metrics(metrics: list[dict[str, Any]], console: Console) -> None:
    """Print two lines a metric: name and values; joint, unit and intervals.

    Of several joints the one with the largest median is shown.
    """
    rows = []
    for row in _largest(metrics):
        below = f"{row.get('joint', '')} [{row['unit']}]".strip()
        cells = [f"{number(row[x]['estimate'])}\n{_interval(row[x])}" for x in LEVELS]
        largest = f"{number(row.get('largest'))}\n{row.get('path', '-')}"
        rows.append([f"{METRICS[row['metric']].label}\n{below}", *cells, largest])
    print_table(["", *LEVELS, "largest\nof path"], rows, console, "fr")


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
