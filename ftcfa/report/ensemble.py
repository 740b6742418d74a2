"""An ensemble as plain data, and as the files of ``ftcfa run``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.report.ensemble_figure import ensemble_figure
from ftcfa.report.figures import figure_files
from ftcfa.report.joints import joint_records
from ftcfa.report.netcdf import netcdf
from ftcfa.report.records import finite, interval, versions
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import KEPT, WORDS
from ftcfa.study.summary import settled_in_mean_square, settling

LEVELS = {"median": 0.5, "95 %": 0.95}
"""Quantiles over paths of each metric, by name."""
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
