"""An ensemble as its user reads it: a table, summary.json, and the files of `ftcfa run`."""

import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ftcfa.arrays import Array
from ftcfa.report.ensemble_figure import ensemble_figure
from ftcfa.report.figures import rendered
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.statistics.estimate import Estimate
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.summary import settled_in_mean_square, settling

LEVELS = {"median": 0.5, "95 %": 0.95}
"""Quantiles over paths that the table shows."""
NAMED = 10
"""How many of the paths that diverged are named."""
INT32 = 2**31
"""Attributes of a netCDF file are below it."""
METRICS = {
    "rms_error": "rms error, settled",
    "peak_error": "peak error, settled",
    "late_rms_error": "rms error, late",
    "late_peak_error": "peak error, late",
    "overshoot": "overshoot",
    "saturated": "saturated share",
    "rms_torque": "rms torque",
    "peak_torque": "peak torque",
    "rms_torque_rate": "rms torque rate",
    "peak_torque_rate": "peak torque rate",
    "energy": "energy",
}
"""Metrics of each path, and what the table calls them."""


def ensemble_record(dataset: xr.Dataset, asked: int) -> dict[str, Any]:
    """What summary.json holds: the statistics over all paths, and what is needed to run it again.

    A number that is not there is None: an end of an interval that the paths are too few for, a
    settling time beyond the end of the run, a mean over paths of which one diverged.

    Args:
        dataset: Of `ftcfa.ensemble`.
        asked: How many paths were asked for; fewer were run if the ensemble was interrupted.
    """
    told = dataset.attrs
    numbers = ("duration", "tolerance", "after", "confidence")
    return {
        "paths": dataset.sizes["path"],
        "asked": asked,
        "seed": int(told["seed"]),
        **{name: float(told[name]) for name in numbers},
        "diverged": _diverged(dataset),
        "settling_time": _settling(dataset),
        "mean_square_error": _mean_square(dataset),
        "practical_settling": _practical(dataset),
        "metrics": [row for name in METRICS for row in _rows(dataset, name)],
        "versions": {
            "python": platform.python_version(),
            "ftcfa": told["ftcfa_version"],
            **{name: version(name) for name in ("numpy", "scipy", "xarray")},
        },
        "units": {
            **dict.fromkeys(("duration", "after", "settling_time"), "s"),
            **dict.fromkeys(("tolerance", "error"), dataset["late_rms_error"].attrs["units"]),
        },
    }


def _diverged(dataset: xr.Dataset) -> dict[str, Any]:
    died = dataset["diverged_at"].values
    dead = np.flatnonzero(np.isfinite(died))
    share = proportion(len(dead), len(died), dataset.attrs["confidence"])
    return {
        "count": len(dead),
        "share": _bounds(share),
        "first_paths": dataset["path"].values[dead[:NAMED]].tolist(),
        "at": died[dead[:NAMED]].tolist(),
    }


def _settling(dataset: xr.Dataset) -> dict[str, Any]:
    found = settling(dataset)
    levels = sorted({*dataset["quantile"].values.tolist(), *LEVELS.values()})
    return {
        "settled": found.settled,
        "not_settled": found.censored,
        "quantiles": [{"share": p, **_bounds(found.quantile(p))} for p in levels],
    }


def _mean_square(dataset: xr.Dataset) -> dict[str, Any]:
    """At the last kept time; with diverged paths also that of the survivors."""
    last = dataset.isel(time=-1)
    record = {
        "unit": dataset["ote_mean_square"].attrs["units"],
        "time": float(last["time"]),
        **_bounds(Estimate(*last["ote_mean_square"].values)),
    }
    if dataset.attrs["diverged"]:
        record["survivors"] = _bounds(Estimate(*last["ote_mean_square_survivors"].values))
    return record


def _practical(dataset: xr.Dataset) -> dict[str, Any]:
    """Definition 1 with epsilon = tolerance^2."""
    epsilon = float(dataset.attrs["tolerance"]) ** 2
    return {"epsilon": epsilon, "time": _finite(settled_in_mean_square(dataset, epsilon))}


def _rows(dataset: xr.Dataset, name: str) -> list[dict[str, Any]]:
    """Of a metric, one row a joint where every joint has its own."""
    metric = dataset[name]
    if "joint" not in metric.dims:
        return [_row(dataset, name, metric.values, metric.attrs["units"])]
    return [
        {
            "joint": str(joint),
            **_row(dataset, name, column, _unit(metric.attrs["units"], str(kind))),
        }
        for joint, kind, column in zip(
            metric["joint"].values, metric["joint_type"].values, metric.values.T, strict=True
        )
    ]


def _row(dataset: xr.Dataset, name: str, values: Array, unit: str) -> dict[str, Any]:
    """A path without a value (it diverged, or never settled) counts as the worst of all."""
    confidence = dataset.attrs["confidence"]
    ranked = np.where(np.isfinite(values), values + 0.0, np.inf)  # and no negative zero
    row: dict[str, Any] = {"metric": name, "unit": unit}
    for label, p in LEVELS.items():
        row[label] = _bounds(sample_quantile(ranked, p, confidence))
    alive = np.flatnonzero(np.isfinite(values))
    if len(alive):
        most = alive[np.argmax(values[alive])]
        row |= {"largest": float(ranked[most]), "path": int(dataset["path"].values[most])}
    return {**row, "without": len(values) - len(alive)}


def _unit(unit: str, kind: str) -> str:
    """The unit of one joint, of those that an attribute names."""
    revolute, _, prismatic = unit.rstrip(")").partition(" (prismatic joints: ")
    return prismatic if kind == "prismatic" and prismatic else revolute


def _bounds(estimate: Estimate) -> dict[str, float | None]:
    names = ("estimate", "low", "high")
    return {name: _finite(value) for name, value in zip(names, estimate, strict=True)}


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def netcdf(dataset: xr.Dataset) -> bytes:
    """A Dataset as a netCDF-3 file, which every tool reads.

    Whole numbers become 32 bits wide; a seed that they cannot hold is written as text.
    """
    large = {
        name: str(value)
        for name, value in dataset.attrs.items()
        if isinstance(value, int) and value >= INT32
    }
    return bytes(dataset.assign_attrs(large).to_netcdf(engine="scipy"))


def ensemble_files(
    dataset: xr.Dataset, record: Mapping[str, Any], effort_limit: Array, title: str
) -> dict[str, bytes]:
    """Files of ``ftcfa run``, by name: the Dataset, the record, and the figure as PNG and SVG.

    Args:
        dataset: Of `ftcfa.ensemble`.
        record: Of `ensemble_record`.
        effort_limit: u*, shape (n,) [N m or N].
        title: Heading of the figure.
    """
    figure = rendered(ensemble_figure(dataset, effort_limit, title))
    text = json.dumps(record, indent=2, allow_nan=False) + "\n"
    return {
        "ensemble.nc": netcdf(dataset),
        "summary.json": text.encode(),
        **{f"ensemble.{suffix}": content for suffix, content in figure.items()},
    }


def print_ensemble(record: Mapping[str, Any], console: Console) -> None:
    """Write the table of an ensemble and what stands above it.

    Args:
        record: Of `ensemble_record`.
        console: Where to write.
    """
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column(overflow="fold")
    for label, text in _facts(record):
        facts.add_row(label, text)
    console.print(facts, highlight=False, markup=False)
    console.print()
    print_fitted(_metrics_table(record), console)
    percent = f"{100 * record['confidence']:g} %"
    console.print(
        f"\nMedian and 95 % quantile over the paths, with distribution-free {percent} intervals. "
        "A path that diverged counts as the worst of all; so does, for errors since it settled, "
        f"one that never did. Late is from {record['after']:g} s on. Of metrics of each joint the "
        "row is of the joint whose median is largest; summary.json has all.",
        style="dim", highlight=False, markup=False,
    )  # fmt: skip


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    duration, settled = record["duration"], record["settling_time"]
    square, practical = record["mean_square_error"], record["practical_settling"]
    unit, reached = square["unit"], practical["time"]
    facts = [
        ("paths", _paths(record)),
        ("diverged", _dead(record["diverged"])),
        (
            "settled",
            f"{settled['settled']:,}, to within {record['tolerance']:g} {record['units']['error']} "
            f"until the end; {settled['not_settled']:,} not by {duration:g} s",
        ),
    ]
    for k, row in enumerate(settled["quantiles"]):
        beyond = f"later than {duration:g}"
        told = beyond if row["low"] is None else _told(row, beyond)
        facts.append(("" if k else "settling time", f"{100 * row['share']:g} %: {told} s"))
    facts.append(("E|z1|^2", f"{_told(square)} {unit} at {square['time']:g} s"))
    if "survivors" in square:
        facts.append(("of survivors", f"{_told(square['survivors'])} {unit}"))
    bound = f"the {50 * (1 + record['confidence']):g} % upper bound of E|z1|^2 "
    answer = "is not below" if reached is None else "stays below"
    since = "at the end" if reached is None else f"from {reached:g} s on"
    epsilon = f" epsilon = tolerance^2 = {practical['epsilon']:.4g} {unit} {since}"
    single = record["paths"] == 1
    return [
        *facts,
        ("Definition 1", "one path gives no interval" if single else bound + answer + epsilon),
    ]


def _paths(record: Mapping[str, Any]) -> str:
    text = f"{record['paths']:,} of seed {record['seed']}, {record['duration']:g} s each"
    if record["paths"] < record["asked"]:
        text += f"; interrupted, {record['asked']:,} were asked for"
    return text


def _dead(diverged: Mapping[str, Any]) -> str:
    share = diverged["share"]
    text = f"{diverged['count']:,}, a share of {share['low']:.2g} to {share['high']:.2g}"
    if diverged["count"]:
        more = ", ..." if diverged["count"] > len(diverged["first_paths"]) else ""
        text += f": paths {', '.join(map(str, diverged['first_paths']))}{more}"
    return text


def _metrics_table(record: Mapping[str, Any]) -> Table:
    """A row a metric, of two lines: name and values, joint with unit and intervals."""
    table = plain_table()
    table.add_column("")
    for label in LEVELS:
        table.add_column(label, justify="right", no_wrap=True)
    table.add_column("largest\nof path", justify="right", no_wrap=True)
    for row in _shown(record["metrics"]):
        below = f"{row.get('joint', '')} [{row['unit']}]".strip()
        cells = [f"{_number(row[x]['estimate'])}\n{_interval(row[x])}" for x in LEVELS]
        largest = f"{_number(row.get('largest'))}\n{row.get('path', '-')}"
        table.add_row(Text(f"{METRICS[row['metric']]}\n{below}"), *cells, largest)
    return table


def _shown(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row a metric: of several joints the one with the largest median."""
    best: dict[str, dict[str, Any]] = {}
    for row in rows:
        if row["metric"] not in best or _median(row) > _median(best[row["metric"]]):
            best[row["metric"]] = row
    return list(best.values())


def _median(row: Mapping[str, Any]) -> float:
    value = row["median"]["estimate"]
    return np.inf if value is None else value


def _told(bounds: Mapping[str, Any], without: str = "-") -> str:
    estimate = _number(bounds["estimate"], without)
    return f"{estimate} ({_interval(bounds, without)})"


def _interval(bounds: Mapping[str, Any], without: str = "-") -> str:
    return f"{_number(bounds['low'], without)} to {_number(bounds['high'], without)}"


def _number(value: float | None, without: str = "-") -> str:
    return without if value is None else f"{value:.4g}"
