"""The reproduction of the paper as a reader gets it: figures, summary.json and a table."""

import json
import platform
from collections.abc import Callable, Mapping
from importlib.metadata import version
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from ftcfa.report.figures import filters, overall_error, rendered, torque, tracking
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.study.reproduction import (
    ASYMPTOTIC,
    BAND,
    EXPLICIT,
    FINITE_TIME,
    INTENSITY,
    SEED,
    UNITS,
    Case,
    closed_loop,
    summary_row,
)

NUMBERS = (
    "period\nms",
    "rms OTE\nrad",
    "settled\ns",
    "max|u|\nN m",
    "satur.\n%",
    "error\nrad/s",
)
"""Headers of the table's numbers."""
FIGURES = 4
"""How many figures there are."""
LIMIT_CYCLE_JOINT = "elbow"
"""The joint of the filter figure: the lighter one, whose torque chatters most."""


def reproduction_figures(paths: Mapping[Case, xr.Dataset]) -> dict[str, Figure]:
    """The paper's Figures 1-1, 1-2 and 2 and the filter figure, by file name.

    Args:
        paths: Datasets of the cases; FINITE_TIME, ASYMPTOTIC and EXPLICIT must be among them.
    """
    finite, explicit = paths[FINITE_TIME], paths[EXPLICIT]
    limit = closed_loop(FINITE_TIME).arm.effort_limit
    shown = list(finite["joint"].values).index(LIMIT_CYCLE_JOINT)
    plant = f"double pendulum, {FINITE_TIME.plant} plant, noise as printed (Σ = {INTENSITY:g})"
    kappa = f"κ = {FINITE_TIME.kappa:g}"
    filter_step = f"{FINITE_TIME.filter} filter"
    period = f"period {1e3 * FINITE_TIME.period:g} ms"
    note = ", ".join((plant, kappa, filter_step, period))
    return {
        "figure-1-1": tracking(finite, "Figure 1-1: position against reference", note),
        "figure-1-2": torque(finite, limit, "Figure 1-2: torque within its limits", note),
        "figure-2": overall_error(
            {f"κ = {case.kappa:g}": paths[case] for case in (FINITE_TIME, ASYMPTOTIC)},
            BAND,
            "Figure 2: overall tracking error, finite-time (κ < 1) against asymptotic (κ = 1)",
            ", ".join((plant, filter_step, period)),
        ),
        "figure-filter": filters(
            {"explicit\nEuler step": explicit, "implicit\nEuler step": finite},
            LIMIT_CYCLE_JOINT,
            float(limit[shown]),
            "The command filter, stepped explicitly and implicitly",
            ", ".join((plant, kappa, period)),
        ),
    }


def summary_record(
    paths: Mapping[Case, xr.Dataset], duration: float, quick: bool
) -> dict[str, Any]:
    """What summary.json holds: a row a case, and what is needed to run it again."""
    return {
        "study": "Song, Zhao and Cui, Section V",
        "quick": quick,
        "duration": duration,
        "seed": SEED,
        "path": 0,
        "settled_band": BAND,
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("ftcfa", "numpy", "pin", "matplotlib")},
        },
        "units": {"duration": "s", "settled_band": "rad", **UNITS},
        "cases": [summary_row(case, path) for case, path in paths.items()],
    }


def reproduction_files(
    paths: Mapping[Case, xr.Dataset],
    record: Mapping[str, Any],
    done: Callable[[], None] = lambda: None,
) -> dict[str, bytes]:
    """All files of the reproduction, by name: PNG and SVG of each figure, and summary.json.

    Args:
        paths: Datasets of the cases.
        record: Of `summary_record`.
        done: Called as each figure is finished.
    """
    files = {}
    for name, figure in reproduction_figures(paths).items():
        for suffix, content in rendered(figure).items():
            files[f"{name}.{suffix}"] = content
        done()
    text = json.dumps(record, indent=2, allow_nan=False) + "\n"
    return {**files, "summary.json": text.encode()}


def print_summary(record: Mapping[str, Any], console: Console) -> None:
    """Write the table of the cases and what its columns mean."""
    table = plain_table()
    for header in ("plant", "noise", "kappa", "filter"):
        table.add_column(header, no_wrap=True)
    for header in NUMBERS:
        table.add_column(header, justify="right", no_wrap=True)
    for row in record["cases"]:
        table.add_row(*_cells(row))
    print_fitted(table, console)
    late = f"{record['duration'] / 2:g} s to {record['duration']:g} s"
    meanings = {
        "noise": "psd: varpi is the intensity; amplitude: its root, as the paper prints it",
        "rms OTE": f"root mean square of |q - q_d|, {late}",
        "settled": f"time from which |q - q_d| stays below {record['settled_band']:g} rad",
        "satur.": "share of time in which some joint asks for more torque than its limit",
        "error": f"largest filter error |abar - alpha|, {late}",
    }
    key = Table.grid(padding=(0, 1))
    for item in meanings.items():
        key.add_row(*item)
    console.print()
    console.print(key, style="dim", highlight=False)


def _cells(row: Mapping[str, Any]) -> list[str]:
    died = row["diverged_at"]
    settled = f"{row['settled_after']:.2f}" if row["settled_after"] is not None else "never"
    share = row["saturated_share"]
    return [
        row["plant"],
        row["noise"],
        f"{row['kappa']:g}",
        row["filter"],
        f"{1e3 * row['period']:g}",
        _number(row["rms_ote"], ".4f"),
        settled if died is None else f"died {died:.2f}",
        _number(row["largest_u"], ".4g"),
        _number(None if share is None else 100 * share, ".1f"),
        _number(row["largest_filter_error"], ".1e"),
    ]


def _number(value: float | None, spec: str) -> str:
    return "-" if value is None else format(value, spec)
