"""A comparison as plain data and as a table, with sentences that say what the table means."""

from collections.abc import Mapping
from typing import Any

import xarray as xr
from rich.console import Console

from ftcfa.report.records import finite, interval
from ftcfa.report.terminal import print_line, print_table
from ftcfa.study.metrics.compared import COMPARED

COLUMNS = [name for name, metric in COMPARED.items() if metric.column]
"""Metrics of the table; the other metrics are in the record."""


def comparison_record(dataset: xr.Dataset) -> dict[str, Any]:
    """Content of summary.json, from the result of `ftcfa.compare`.

    A row a loop, with intervals and differences from the first loop.
    """
    rows = []
    for loop in dataset["loop"].values:
        one = dataset.sel(loop=loop)
        metrics = {
            name: {
                "unit": metric.unit,
                "mean": interval(one["mean"].sel(metric=name).values),
                "quantiles": [finite(x) for x in one["quantiles"].sel(metric=name).values],
                "difference": interval(one["difference"].sel(metric=name).values),
                "median_difference": interval(one["median_difference"].sel(metric=name).values),
                "significant": bool(one["significant"].sel(metric=name)),
                "median_significant": bool(one["median_significant"].sel(metric=name)),
                "carried_by_few": bool(one["carried_by_few"].sel(metric=name)),
            }
            for name, metric in COMPARED.items()
        }
        counts = {name: int(one[name]) for name in ("settled", "kept", "diverged")}
        differs = str(one["differs"].values)
        rows.append({"loop": str(loop), "differs in": differs, **counts, "metrics": metrics})
    return {
        **dataset.attrs,
        "paths": dataset.sizes["path"],
        "compared with": str(dataset["loop"].values[0]),
        "quantiles": dataset["quantile"].values.tolist(),
        "loops": rows,
    }


def print_comparison(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `comparison_record`: means of the paths that did not diverge."""
    heads = ["loop", *(f"{COMPARED[name].column}\n{_unit(name)}" for name in COLUMNS)]
    median = record["quantiles"].index(0.5)
    rows = (
        [row["loop"], *(_cell(row["metrics"][name], name, median) for name in COLUMNS)]
        for row in record["loops"]
    )
    print_table(heads, rows, console, "fr")
    for sentence in sentences(record):
        print_line(sentence, console)


def sentences(record: Mapping[str, Any]) -> list[str]:
    """What the table means, and for each loop which differences are significant."""
    differs = ",".join(row["differs in"] for row in record["loops"])
    apart = sorted({word.split(".")[0].strip() for word in differs.split(",")} - {""})
    duration, first = record["duration"], record["compared with"]
    lines = [
        f"{record['paths']} paths of {duration:g} s with the same noise for all loops, hardware "
        f"{record['hardware']}. Errors are "
        f"those from {record['after']:g} s on. A path has settled once its error stays below "
        f"{record['tolerance']:g}; a path that never settles counts with {duration:g} s. Means "
        "are over the paths that did not diverge; below each, the median over all paths. * differs "
        "significantly from the first loop (paired; all means together and all medians together "
        f"with confidence {record['confidence']:g}, the medians by the sign test), by at least "
        f"{100 * record['smallest']:g} % of its value. ? few paths carry the mean, which is not "
        f"judged. The loops differ in their {', '.join(apart) or 'names'} only."
    ]
    if record["same"]:
        lines.append(f"Not run twice: {record['same']}.")
    for row in record["loops"][1:]:
        lines.append(f"{row['loop']} against {first}: {_differences(row['metrics'])}.")
    return lines


def _differences(metrics: Mapping[str, Any]) -> str:
    """The significant differences of a loop from the first."""
    changes = {name: metrics[name]["difference"] for name in COLUMNS}
    significant = [name for name in COLUMNS if metrics[name]["significant"]]
    words = []
    for word, sign in (("lower", -1), ("higher", 1)):
        names = [name for name in significant if sign * changes[name]["estimate"] > 0]
        if names:
            words.append(f"{word} {', '.join(_difference(x, metrics[x]) for x in names)}")
    if any(change["estimate"] is None for change in changes.values()):
        words.append("the rest is not comparable: in every pair of paths at least one diverged")
    return "; ".join(words) or "no significant difference"


def _difference(name: str, metric: Mapping[str, Any]) -> str:
    """A metric with the interval of its difference from the first loop."""
    low, high = sorted(abs(_scale(name) * metric["difference"][end]) for end in ("low", "high"))
    return f"{name.replace('_', ' ')} by {low:.3g} to {high:.3g} {_unit(name)}"


def _cell(metric: Mapping[str, Any], name: str, median: int) -> str:
    """Mean and median of a metric, each with a star if it differs from the first loop's."""
    mean, middle = metric["mean"]["estimate"], metric["quantiles"][median]
    mark = "*" if metric["significant"] else "?" if metric["carried_by_few"] else ""
    upper = "-" if mean is None else f"{mean * _scale(name):.3g}{mark}"
    if COMPARED[name].binary:
        return upper
    star = "*" if metric["median_significant"] else ""
    lower = "-" if middle is None else f"{middle * _scale(name):.3g}{star}"
    return f"{upper}\n{lower}"


def _scale(name: str) -> float:
    """Factor from the unit of a metric to that of the table."""
    return 100.0 if COMPARED[name].percent else 1.0


def _unit(name: str) -> str:
    """Unit of a metric in the table."""
    return "%" if COMPARED[name].percent else COMPARED[name].unit
