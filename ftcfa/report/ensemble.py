"""An ensemble as plain data, and the files of ``ftcfa run``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.report.ensemble_figure import ensemble_figure
from ftcfa.report.figures import rendered
from ftcfa.report.records import finite, interval, summary_file, versions
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.quantiles import sample_quantile
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.summary import settled_in_mean_square, settling

LEVELS = {"median": 0.5, "95 %": 0.95}
"""Quantiles over paths of each metric, by name."""
NAMED = 10
"""Number of diverged paths that are listed."""
INT32 = 2**31
"""Integer attributes of a netCDF file must be smaller."""


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
        "diverged": _diverged(dataset),
        "settling_time": _settling(dataset),
        "mean_square_error": _mean_square(dataset),
        "practical_settling": _practical(dataset),
        "metrics": [
            row for name in METRICS if name != "settling_time" for row in _rows(dataset, name)
        ],
        "versions": {
            **versions("numpy", "scipy", "xarray"),
            "ftcfa": attributes["ftcfa_version"],
        },
        "units": {
            **dict.fromkeys(("duration", "after", "settling_time"), "s"),
            **dict.fromkeys(("tolerance", "error"), dataset["late_rms_error"].attrs["units"]),
        },
    }


def _diverged(dataset: xr.Dataset) -> dict[str, Any]:
    """Number and share of the diverged paths, and the first of them."""
    at = dataset["diverged_at"].values
    diverged = np.flatnonzero(np.isfinite(at))
    share = proportion(len(diverged), len(at), dataset.attrs["confidence"])
    return {
        "count": len(diverged),
        "share": interval(share),
        "first_paths": dataset["path"].values[diverged[:NAMED]].tolist(),
        "at": at[diverged[:NAMED]].tolist(),
    }


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
    """Row of a metric; a path without a value (it diverged or never settled) is the worst of all.

    Args:
        dataset: Result of `ftcfa.ensemble`.
        name: Name of the metric.
        values: Its value of each path, shape (paths,).
        unit: Its unit.
    """
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


def netcdf(dataset: xr.Dataset) -> bytes:
    """Content of a netCDF-3 file, which every tool reads, with a Dataset.

    Integers are stored with 32 bits; a seed that does not fit is written as text.
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
    """Files of ``ftcfa run``, by name: the Dataset, summary.json, PNG and SVG of the figure.

    Args:
        dataset: Result of `ftcfa.ensemble`.
        record: Result of `ensemble_record`.
        effort_limit: u*, shape (n,) [N m or N].
        title: Heading of the figure.
    """
    figure = rendered(ensemble_figure(dataset, effort_limit, title))
    return {
        "ensemble.nc": netcdf(dataset),
        "summary.json": summary_file(record),
        **{f"ensemble.{suffix}": content for suffix, content in figure.items()},
    }
