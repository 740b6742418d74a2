"""The reproduction of the paper's study: figures, summary.json and a table."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console

from ftcfa.control.laws import PRINTED
from ftcfa.report.figures import filters, overall_error, rendered, torque, tracking
from ftcfa.report.records import finite, summary_file, versions
from ftcfa.report.terminal import number, print_facts, print_line, print_table
from ftcfa.statistics.settling import below_for_good
from ftcfa.study.reproduction import (
    ASYMPTOTIC,
    BAND,
    CASES,
    DURATION,
    EXPLICIT,
    FINITE_TIME,
    INTENSITY,
    SEED,
    Case,
    closed_loop,
)

UNITS = {
    "period": "s",
    "rms_ote": "rad",
    "settled_after": "s",
    "largest_u": "N m",
    "saturated_share": "1",
    "largest_filter_error": "rad/s",
    "diverged_at": "s",
}
"""Units of the entries of `summary_row`."""

HEADS = (
    "plant", "noise", "kappa", "filter", "period\nms", "rms OTE\nrad", "settled\ns",
    "max|u|\nN m", "satur.\n%", "error\nrad/s",
)  # fmt: skip
"""Heads of the table."""
FIGURES = 4
"""Number of figures."""
LIMIT_CYCLE_JOINT = "elbow"
"""The joint of the filter figure: the lighter one, whose torque chatters most."""


def reproduction_figures(paths: Mapping[Case, xr.Dataset]) -> dict[str, Figure]:
    """The paper's Figures 1-1, 1-2 and 2 and the filter figure, by file name.

    Args:
        paths: Dataset of each case; FINITE_TIME, ASYMPTOTIC and EXPLICIT must be among them.
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
    """Content of summary.json: a row a case, and what is needed to run it again.

    ``quick`` is true of a quick look instead of the whole study.
    """
    return {
        "study": "Song, Zhao and Cui, Section V",
        "law": PRINTED,
        "quick": quick,
        "duration": duration,
        "seed": SEED,
        "path": 0,
        "settled_band": BAND,
        "versions": versions("ftcfa", "numpy", "pin", "matplotlib"),
        "units": {"duration": "s", "settled_band": "rad", **UNITS},
        "cases": [summary_row(case, path) for case, path in paths.items()],
    }


def summary_row(case: Case, dataset: xr.Dataset) -> dict[str, Any]:
    """The row of a case in the table, as plain data; `UNITS` gives its units.

    A mean or maximum over the last half is None if the path diverged. The largest torque and the
    share of saturation are those until it diverged.
    """
    time, ote = dataset["time"].values, dataset["ote"].values
    u, command = np.abs(dataset["u"].values), np.abs(dataset["u_command"].values)
    filter_error = np.abs(dataset["abar"].values - dataset["alpha"].values)
    valid, last_half = np.isfinite(ote), time >= time[-1] / 2
    return {
        **asdict(case),
        "rms_ote": finite(np.sqrt(np.mean(ote[last_half] ** 2))),
        "settled_after": finite(below_for_good(time, ote, BAND)),
        "largest_u": finite(np.max(u[valid])),
        "saturated_share": finite(np.mean(np.any(command[valid] > u[valid], axis=1))),
        "largest_filter_error": finite(np.max(filter_error[last_half])),
        "diverged_at": finite(dataset["diverged_at"]),
    }


def reproduction_files(
    paths: Mapping[Case, xr.Dataset],
    record: Mapping[str, Any],
    done: Callable[[], None] = lambda: None,
) -> dict[str, bytes]:
    """Files of ``ftcfa reproduce``, by name: PNG and SVG of each figure, and summary.json.

    ``done`` is called after each figure.
    """
    files = {}
    for name, figure in reproduction_figures(paths).items():
        for suffix, content in rendered(figure).items():
            files[f"{name}.{suffix}"] = content
        done()
    return {**files, "summary.json": summary_file(record)}


def print_summary(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `summary_record`: a table, and what its columns mean."""
    if record["quick"]:
        print_line(
            f"quick look: {len(record['cases'])} of {len(CASES)} cases, {record['duration']:g} s "
            f"of {DURATION:g} s; the paper's numbers need the whole study\n", console
        )  # fmt: skip
    print_table(HEADS, map(_cells, record["cases"]), console, "llllr")
    late = f"{record['duration'] / 2:g} s to {record['duration']:g} s"
    meanings = {
        "law": record["law"],
        "noise": "psd: varpi is the intensity; amplitude: its root, as the paper prints it",
        "rms OTE": f"root mean square of |q - q_d|, {late}",
        "settled": f"time from which |q - q_d| stays below {record['settled_band']:g} rad",
        "satur.": "share of time in which some joint asks for more torque than its limit",
        "error": f"largest filter error |abar - alpha|, {late}",
    }
    console.print()
    print_facts(meanings.items(), console)


def _cells(row: Mapping[str, Any]) -> list[str]:
    """The texts of a row of the table."""
    diverged, share = row["diverged_at"], row["saturated_share"]
    settled = number(row["settled_after"], ".2f", "never")
    return [
        row["plant"], row["noise"], f"{row['kappa']:g}", row["filter"], f"{1e3 * row['period']:g}",
        number(row["rms_ote"], ".4f"),
        settled if diverged is None else f"diverged\n{diverged:.2f}",
        number(row["largest_u"], ".4g"),
        number(None if share is None else 100 * share, ".1f"),
        number(row["largest_filter_error"], ".1e"),
    ]  # fmt: skip
