"""A comparison as a reader gets it: a table, a figure, summary.json and plain sentences."""

import json
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from rich.console import Console

from ftcfa.report.figures import BLUE, INK, LIGHT, STYLE, WIDTH, rendered
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.study.comparison import METRICS

HEADERS = {
    "settling_time": "settle\ns",
    "rms_error": "rms\nrad",
    "peak_error": "peak\nrad",
    "effort": "effort\n%",
    "torque_rate": "rate\n1/s",
    "saturated": "satur.\n%",
    "unsettled": "unsettled\n%",
    "diverged": "dead\n%",
}
"""Columns of the table; the other metrics are in the record."""
PERCENT = ("effort", "saturated", "unsettled", "diverged")
LINE, HEAD = 0.24, 1.2
"""Height of a loop in the figure, and of what is around the panels [in]."""
SHOWN = ("settling_time", "rms_error", "effort", "torque_rate")
"""Metrics of the figure."""
TITLES = ("settling time [s]", "late rms error [rad]", "rms torque / limit", "torque rate [1/s]")


def comparison_record(dataset: xr.Dataset) -> dict[str, Any]:
    """What summary.json holds: a row a loop, with intervals and differences from the first."""
    first = str(dataset["loop"].values[0])
    rows = []
    for name in dataset["loop"].values:
        one = dataset.sel(loop=name)
        metrics = {
            metric: {
                "unit": unit,
                "mean": _interval(one["mean"].sel(metric=metric)),
                "quantiles": _finite(one["quantiles"].sel(metric=metric).values),
                "difference": _interval(one["difference"].sel(metric=metric)),
                "significant": bool(one["significant"].sel(metric=metric)),
            }
            for metric, (unit, _) in METRICS.items()
        }
        rows.append(
            {
                "loop": str(name),
                "differs in": str(one["differs"].values),
                "settled": int(one["settled"]),
                "diverged": int(one["diverged"]),
                "metrics": metrics,
            }
        )
    told = {**dataset.attrs, "paths": dataset.sizes["path"], "compared with": first}
    return {**told, "quantiles": dataset["quantile"].values.tolist(), "loops": rows}


def print_comparison(dataset: xr.Dataset, console: Console) -> None:
    """The table: means over the paths that did not diverge, * where they differ from the first."""
    table = plain_table()
    table.add_column("loop", overflow="fold")
    for header in HEADERS.values():
        table.add_column(header, justify="right", no_wrap=True)
    for name in dataset["loop"].values:
        one = dataset.sel(loop=name)
        cells = [_cell(one, metric) for metric in HEADERS]
        table.add_row(str(name), *cells)
    print_fitted(table, console)
    for sentence in sentences(dataset):
        console.print(sentence, markup=False, highlight=False)


def sentences(dataset: xr.Dataset) -> list[str]:
    """What the table means, and which differences are significant."""
    told, first = dataset.attrs, str(dataset["loop"].values[0])
    differs = ",".join(map(str, dataset["differs"].values))
    apart = sorted({word.split(".")[0].strip() for word in differs.split(",")} - {""})
    lines = [
        f"{dataset.sizes['path']} paths of {told['duration']:g} s with the same noise for all; "
        f"errors from {told['after']:g} s on; settled is below {told['tolerance']:g}, and what "
        f"never is counts with {told['duration']:g} s. Means over the paths that did not diverge; "
        "* differs significantly from the first (paired, all differences together with confidence "
        f"{told['confidence']:g}). The loops differ in their {', '.join(apart) or 'names'} only."
    ]
    for name in dataset["loop"].values[1:]:
        one = dataset.sel(loop=name)
        better = [m for m in HEADERS if one["significant"].sel(metric=m) and _change(one, m) < 0]
        worse = [m for m in HEADERS if one["significant"].sel(metric=m) and _change(one, m) > 0]
        words = [
            f"{word} {', '.join(_told(one, metric) for metric in metrics)}"
            for word, metrics in (("lower", better), ("higher", worse))
            if metrics
        ]
        if np.isnan(one["difference"].sel(metric=list(HEADERS))).any():
            words.append("the rest is not comparable, no pair of paths lived")
        found = "; ".join(words) or "no significant difference"
        lines.append(f"{name} against {first}: {found}.")
    return lines


@mpl.rc_context(STYLE)
def comparison(dataset: xr.Dataset, title: str) -> Figure:
    """Median, quartiles and 5 to 95 % of the paths, a row a loop, a panel a metric."""
    names = [str(name) for name in dataset["loop"].values]
    size = (WIDTH, HEAD + 2 * (LINE * len(names) + 0.4))
    figure = Figure(figsize=size, layout=ConstrainedLayoutEngine(wspace=0.05, hspace=0.06))
    panels = figure.subplots(2, 2, sharey=True).ravel()
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, fontweight="bold")
    for ax, metric, label in zip(panels, SHOWN, TITLES, strict=True):
        _draw(ax, dataset["quantiles"].sel(metric=metric).values, names)
        never = f", {dataset.attrs['duration']:g} if not settled" if metric == SHOWN[0] else ""
        ax.set_title(label + never)
    diverged = dataset["diverged"].values
    if diverged.any():
        dead = ", ".join(f"{n}: {k}" for n, k in zip(names, diverged, strict=True) if k)
        note = f"of {dataset.sizes['path']} paths; diverged, and beyond the right edge: {dead}"
    else:
        note = f"of {dataset.sizes['path']} paths each; none diverged"
    figure.supxlabel(f"median, quartiles and 5 to 95 % {note}", fontsize=8, x=0.01, ha="left")
    return figure


def comparison_files(dataset: xr.Dataset, title: str) -> dict[str, bytes]:
    """The figure and summary.json, by file name."""
    figure = rendered(comparison(dataset, title))
    record = json.dumps(comparison_record(dataset), indent=2, allow_nan=False)
    images = {f"comparison.{suffix}": content for suffix, content in figure.items()}
    return {**images, "summary.json": record.encode()}


def _draw(ax: Axes, quantiles: np.ndarray, names: Sequence[str]) -> None:
    rows = np.arange(len(names))
    finite = quantiles[np.isfinite(quantiles) & (quantiles > 0)]
    log = finite.size > 0 and finite.max() > 20 * finite.min()
    shown = np.where(np.isfinite(quantiles), quantiles, 10 * finite.max(initial=1.0))
    low, first, median, third, high = shown.T
    ax.hlines(rows, low, high, color=LIGHT, linewidth=2.0)
    ax.hlines(rows, first, third, color=BLUE, linewidth=4.0)
    ax.plot(median, rows, "o", color=INK, markersize=3.5)
    ax.set_yticks(rows, names)
    ax.set_ylim(len(names) - 0.5, -0.5)
    if log:
        ax.set_xscale("log")
        ax.set_xlim(0.7 * finite.min(), 1.4 * finite.max())
    else:
        ax.set_xlim(0, 1.05 * (finite.max() if finite.size else 1.0))


def _cell(one: xr.Dataset, metric: str) -> str:
    mean = float(one["mean"].sel(bound="estimate", metric=metric))
    star = "*" if bool(one["significant"].sel(metric=metric)) else ""
    return f"{mean * (100 if metric in PERCENT else 1):.3g}{star}"


def _told(one: xr.Dataset, metric: str) -> str:
    """A metric and the interval of its difference from the first."""
    scale, unit = (100.0, "%") if metric in PERCENT else (1.0, METRICS[metric][0])
    low, high = sorted(abs(scale * one["difference"].sel(metric=metric).values[1:]))
    return f"{metric.replace('_', ' ')} by {low:.3g} to {high:.3g} {unit}"


def _change(one: xr.Dataset, metric: str) -> float:
    return float(one["difference"].sel(bound="estimate", metric=metric))


def _interval(estimate: xr.DataArray) -> dict[str, float | None]:
    values = _finite(estimate.values)
    return dict(zip(("estimate", "low", "high"), values, strict=True))


def _finite(values: np.ndarray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
