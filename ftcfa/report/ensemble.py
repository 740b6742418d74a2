"""An ensemble as plain data, as facts and a table, and as the files of ``ftcfa run``."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console

from ftcfa.arrays import Array
from ftcfa.report.ensemble_figure import ensemble_figure
from ftcfa.report.figures import figure_files
from ftcfa.report.joints import joint_records, print_joints
from ftcfa.report.netcdf import netcdf
from ftcfa.report.records import finite, interval, versions
from ftcfa.report.terminal import number, print_facts, print_line, print_table
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import KEPT, OUTCOMES, WORDS
from ftcfa.study.summary import settled_in_mean_square, settling

LEVELS = {"median": 0.5, "95 %": 0.95}
"""Quantiles over paths of each metric, by name."""
ONLY_OF_JOINTS = ("late_rms_joint_error", "late_peak_joint_error", "joint_saturated")
"""Those that the table of metrics does not show."""
NAMED = 10
"""Number of paths of an outcome that are listed."""


def ensemble_record(dataset: xr.Dataset, requested: int) -> dict[str, Any]:
    """Content of summary.json: statistics over all paths, and what is needed to run it again.

    A missing number is None: an end of an interval for which there are too few paths, a settling
    time beyond the end of the run, a mean over paths of which one diverged.

    Args:
        dataset: Result of `ftcfa.ensemble`.
        requested: Number of paths requested; fewer were run if the ensemble was interrupted.
    """
    attributes = dataset.attrs
    numbers = ("duration", "tolerance", "after", "confidence")
    return {
        "paths": dataset.sizes["path"],
        "requested": requested,
        "seed": int(attributes["seed"]),
        **{name: float(attributes[name]) for name in numbers},
        "hardware": attributes["hardware"],
        "outcomes": _outcomes(dataset),
        "without_torque": {
            "paths": int(np.sum(dataset["without_torque"] > 0)),
            "samples": int(np.sum(dataset["without_torque"])),
        },
        "diagnosis": attributes["diagnosis"],
        "settling_time": _settling(dataset),
        "mean_square_error": _mean_square(dataset),
        "practical_settling": _practical(dataset),
        "metrics": [
            row for name in METRICS if name != "settling_time" for row in _rows(dataset, name)
        ],
        "joints": joint_records(dataset),
        "versions": {**versions("numpy", "scipy", "xarray"), "ftcfa": attributes["ftcfa_version"]},
        "kernels": int(attributes["kernels"]),
        "units": {
            **dict.fromkeys(("duration", "after", "settling_time"), "s"),
            **dict.fromkeys(("tolerance", "error"), dataset["late_rms_error"].attrs["units"]),
        },
    }


def _outcomes(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Number and share of the paths of each outcome, and the first of those that are not kept."""
    outcome, at = dataset["outcome"].values, dataset["outcome_time"].values
    joints = [*dataset["joint"].values.tolist(), None]  # -1: none
    record = {}
    for code, word in enumerate(WORDS):
        those = np.flatnonzero(outcome == code)
        share = proportion(len(those), len(outcome), dataset.attrs["confidence"])
        record[word] = {"count": len(those), "share": interval(share)}
        if code != KEPT:
            first = those[:NAMED]
            record[word] |= {
                "first_paths": dataset["path"].values[first].tolist(),
                "at": at[first].tolist(),
                "joints": [joints[k] for k in dataset["outcome_joint"].values[first]],
            }
    return record


def _settling(dataset: xr.Dataset) -> dict[str, Any]:
    """Number of the settled paths, and quantiles of the settling time."""
    distribution = settling(dataset)
    levels = sorted({*dataset["quantile"].values.tolist(), *LEVELS.values()})
    return {
        "settled": distribution.settled,
        "not_settled": distribution.censored,
        "quantiles": [{"share": p, **interval(distribution.quantile(p))} for p in levels],
    }


def _mean_square(dataset: xr.Dataset) -> dict[str, Any]:
    """Mean-square error at the last time; if a path diverged, also that of the others."""
    last = dataset.isel(time=-1)
    record = {
        "unit": dataset["ote_mean_square"].attrs["units"],
        "time": float(last["time"]),
        **interval(last["ote_mean_square"].values),
        "by_few": bool(last["ote_mean_square_by_few"]),
    }
    if dataset.attrs["diverged"]:
        record["not_diverged"] = interval(last["ote_mean_square_not_diverged"].values)
    return record


def _practical(dataset: xr.Dataset) -> dict[str, Any]:
    """Practical settling of Definition 1 with epsilon = tolerance^2."""
    epsilon = float(dataset.attrs["tolerance"]) ** 2
    return {"epsilon": epsilon, "time": finite(settled_in_mean_square(dataset, epsilon))}


def _rows(dataset: xr.Dataset, name: str) -> list[dict[str, Any]]:
    """Rows of a metric: one, or one a joint if each joint has its own."""
    metric = dataset[name]
    if "joint" not in metric.dims:
        return [_row(dataset, name, metric.values, metric.attrs["units"])]
    columns = zip(metric["joint"].values, metric["joint_type"].values, metric.values.T, strict=True)
    return [
        {"joint": str(joint), **_row(dataset, name, x, _unit(metric.attrs["units"], str(kind)))}
        for joint, kind, x in columns
    ]


def _row(dataset: xr.Dataset, name: str, values: Array, unit: str) -> dict[str, Any]:
    """Row of a metric of each path; one without a value, diverged or not settled, is the worst."""
    ranked = np.where(np.isfinite(values), values + 0.0, np.inf)  # + 0.0: no negative zero
    row: dict[str, Any] = {"metric": name, "unit": unit}
    for label, p in LEVELS.items():
        row[label] = interval(sample_quantile(ranked, p, dataset.attrs["confidence"]))
    valid = np.flatnonzero(np.isfinite(values))
    if len(valid):
        largest = valid[np.argmax(values[valid])]
        row |= {"largest": float(ranked[largest]), "path": int(dataset["path"].values[largest])}
    return {**row, "without": len(values) - len(valid)}


def _unit(unit: str, joint_type: str) -> str:
    """Unit of one joint, from an attribute that may name a second unit for prismatic joints."""
    revolute, _, prismatic = unit.rstrip(")").partition(" (prismatic joints: ")
    return prismatic if joint_type == "prismatic" and prismatic else revolute


def ensemble_files(
    dataset: xr.Dataset, record: Mapping[str, Any], effort_limit: Array, title: str
) -> dict[str, bytes]:
    """Files of ``ftcfa run``, by name: the Dataset, PNG and SVG of the figure, summary.json."""
    figure = ensemble_figure(dataset, effort_limit, title)
    return {"ensemble.nc": netcdf(dataset), **figure_files("ensemble", figure, record)}


def print_ensemble(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `ensemble_record`: facts, a table, and the meaning of its columns."""
    print_facts(_facts(record), console)
    console.print()
    _print_metrics(record["metrics"], console)
    console.print()
    print_joints(record["joints"], console)
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
    without = record["without_torque"]
    if without["paths"]:
        text = f"{without['samples']:,} samples of {without['paths']:,} paths: the law asked for "
        facts.append(("no torque", f"{text}a torque that is not finite, and started anew"))
    if record["diagnosis"]:
        facts.append(("diagnosis", record["diagnosis"]))
    return facts


def _print_metrics(metrics: list[dict[str, Any]], console: Console) -> None:
    """Print two lines a metric: name and values; joint, unit and intervals.

    Of several joints the one with the largest median is shown.
    """
    rows = []
    shown = [row for row in metrics if row["metric"] not in ONLY_OF_JOINTS]
    for metric in dict.fromkeys(row["metric"] for row in shown):
        row = max((row for row in metrics if row["metric"] == metric), key=_median)
        below = f"{row.get('joint', '')} [{row['unit']}]".strip()
        cells = [f"{number(row[x]['estimate'])}\n{_interval(row[x])}" for x in LEVELS]
        largest = f"{number(row.get('largest'))}\n{row.get('path', '-')}"
        rows.append([f"{METRICS[metric].label}\n{below}", *cells, largest])
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
