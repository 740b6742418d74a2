"""Theorem 1 as a reader gets it: its constants as plain data, as a table and as a figure."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ftcfa.report.figures import BLUE, DASHED, GREY, LIGHT, ORANGE, STYLE, WIDTH
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.theory.premises import TheoremPaths
from ftcfa.theory.theorem1 import Bounds

LINEAR = 0.1
"""Size of LV below which its axis is linear [1/s]."""


def bounds_record(found: Bounds, followed: TheoremPaths) -> dict[str, Any]:
    """All that ``ftcfa bounds`` shows, as plain data; None for what is infinite or not a number.

    Args:
        found: Of `ftcfa.bounds`.
        followed: Paths of the same loop.
    """
    heavier, tighter = found.best_weight()
    return {
        "verdict": found.verdict,
        "applies": found.applies,
        "informative": found.informative,
        "supplied": {name: getattr(found, name) for name in ("theta", "eps", "pi1", "sigma")},
        "joints": found.n,
        "kappa": found.kappa,
        "p": found.p,
        "weight": found.weight,
        "Mmin": found.Mmin,
        "Mmax": found.Mmax,
        "conditions": [
            {
                "name": each.name,
                "value": each.value,
                "relation": each.relation,
                "required": each.required,
                "holds": each.holds,
                "needed": each.needed,
                "replaces": each.replaces,
            }
            for each in found.conditions
        ],
        "filter_reach": found.filter_bound,
        "Delta": found.Delta,
        "Delta_terms": dict(found.Delta_terms),
        "Gamma": found.Gamma,
        "Gamma_terms": dict(found.Gamma_terms),
        "blame": found.largest_term,
        "V0": found.V0,
        "Vinf": _finite(found.Vinf),
        "ultimate_error": _finite(found.ultimate_error),
        "error_without_blame": _finite(found.error_without_largest_term),
        "best_weight": heavier,
        "error_at_best_weight": _finite(tighter),
        "reach": found.joint_range,
        "first_entry": _finite(found.first_entry),
        "measured": _measured(followed),
        "units": {
            "Mmin": "kg m^2 or kg",
            "Mmax": "kg m^2 or kg",
            "pi1": "rad/s",
            "filter_reach": "rad/s^3",
            "ultimate_error": "rad",
            "error_without_blame": "rad",
            "error_at_best_weight": "rad",
            "reach": "rad",
            "first_entry": "s",
        },
    }


def _measured(followed: TheoremPaths) -> dict[str, Any]:
    """The same quantities as the paths had them; None where one of them diverged."""
    values, needed = followed.values, followed.needed_Gamma.student()
    entry = followed.entry
    eps = followed.bounds.eps + max(0.0, float(np.max(followed.missing_eps)))
    pi1 = float(np.max(followed.filter_error))
    supplied = replace(followed.bounds, eps=eps, pi1=pi1)
    return {
        "paths": len(followed.z1),
        "duration": float(followed.time[-1]),
        "rms_error": _finite(np.sqrt(np.mean(followed.late_error**2))),
        "largest_error": _finite(np.max(followed.late_error)),
        "Gamma": _finite(np.max(needed.value)),
        "Gamma_high": _finite(np.max(needed.high)),
        "first_entry": _finite(np.mean(entry)),
        "entered": float(np.mean(np.isfinite(entry))),
        "pi1": _finite(pi1),
        "eps": _finite(eps),
        "theta": _finite(np.max(values.needed_theta)),
        "premises_hold": float(np.mean(followed.premises_hold)) if np.any(entry > 0) else None,
        "error_if_supplied": _finite(supplied.ultimate_error),
    }


def print_bounds(record: Mapping[str, Any], console: Console) -> None:
    """Write the record: the verdict, the gain conditions, the constants, and what was measured.

    Args:
        record: Of `bounds_record`.
        console: Where to write.
    """
    console.print(record["verdict"], style="bold", highlight=False)
    console.print()
    print_fitted(_condition_table(record["conditions"]), console)
    console.print()
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column(overflow="fold")
    for row in _facts(record):
        facts.add_row(*row)
    console.print(facts, highlight=False, markup=False)
    console.print()
    print_fitted(_comparison(record), console)
    measured = record["measured"]
    if measured["error_if_supplied"] is not None:
        console.print(
            f"\nWith the measured eps = {measured['eps']:.3g} and pi1 = {measured['pi1']:.3g} "
            f"rad/s supplied, |z1| <= {measured['error_if_supplied']:.3g} rad.",
            highlight=False,
        )


def _condition_table(conditions: list[dict[str, Any]]) -> Table:
    table = plain_table()
    table.add_column("gain", no_wrap=True)
    for header in ("is", "needs"):
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("holds", no_wrap=True)
    table.add_column("in place of", overflow="fold")
    for each in conditions:
        table.add_row(
            each["name"],
            f"{each['value']:.4g}",
            f"{each['relation']} {each['required']:.4g}",
            "yes" if each["holds"] else "no",
            each["replaces"],
        )
    return table


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    supplied = record["supplied"]
    facts = [
        ("supplied", ", ".join(f"{name} = {value:g}" for name, value in supplied.items())),
        ("Mmin, Mmax", f"{record['Mmin']:.4g}, {record['Mmax']:.4g} kg m^2 or kg"),
        ("w_s, p", f"{record['weight']:.4g}, {record['p']:.4g}"),
        ("Delta", _least(record["Delta_terms"])),
        ("Gamma", _sum(record["Gamma"], record["Gamma_terms"])),
        ("V0, Vinf", f"{record['V0']:.4g}, {_number(record['Vinf'])}"),
    ]
    if record["filter_reach"] is not None:
        reach = f"exact while |alpha''| <= {record['filter_reach']:.4g} rad/s^3"
        facts.append(("filter", f"{reach}; white noise in v leaves alpha'' without any bound"))
    if record["error_at_best_weight"] is not None:
        facts.append(
            (
                "other weight",
                f"|z1| <= {record['error_at_best_weight']:.3g} rad at w_s = "
                f"{record['best_weight']:.3g}, the best of those up to 1e6",
            )
        )
    return facts


def _least(terms: Mapping[str, float]) -> str:
    name = min(terms, key=lambda each: terms[each])
    return f"{terms[name]:.4g}, the least of {len(terms)}: {name}"


def _sum(total: float, terms: Mapping[str, float]) -> str:
    parts = [f"{name} {value:.4g}" for name, value in terms.items() if value]
    return f"{total:.4g} = {' + '.join(parts)}"


def _comparison(record: Mapping[str, Any]) -> Table:
    """Promise and measurement side by side."""
    measured, supplied = record["measured"], record["supplied"]
    table = plain_table()
    table.add_column(f"{measured['paths']} paths of {measured['duration']:g} s", no_wrap=True)
    table.add_column("promised\nor supplied", justify="right", no_wrap=True)
    table.add_column("measured", justify="right", no_wrap=True)
    rows = (
        ("rms |z1|, last half [rad]", record["ultimate_error"], measured["rms_error"]),
        ("largest |z1|, last half [rad]", record["ultimate_error"], measured["largest_error"]),
        ("E[LV + Delta V^p], largest", record["Gamma"], measured["Gamma"]),
        ("E[first entry] [s]", record["first_entry"], measured["first_entry"]),
        ("|abar - alpha| (pi1) [rad/s]", supplied["pi1"], measured["pi1"]),
        ("eps, given theta", supplied["eps"], measured["eps"]),
        ("theta, if eps = 0", supplied["theta"], measured["theta"]),
    )
    for label, promised, found in rows:
        table.add_row(escape(label), _number(promised), _number(found))
    held = measured["premises_hold"]
    if held is not None:
        table.add_row("premises hold until entry", "always", f"{100 * held:.3g} %")
    return table


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


@mpl.rc_context(STYLE)
def generator_figure(
    study: TheoremPaths, entering: TheoremPaths, title: str, notes: list[str]
) -> Figure:
    """Theorem 1 against simulated paths: its inequality, its promise, its first-entry time.

    Args:
        study: Paths of a loop, for the first two panels.
        entering: Paths of a loop whose first-entry bound says something, for the third.
        title: Heading.
        notes: What each panel shows, three lines.
    """
    layout = ConstrainedLayoutEngine(hspace=0.06)
    figure = Figure(figsize=(WIDTH, 8.4), layout=layout)
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    axes = figure.subplots(3, 1)
    for ax, note in zip(axes, notes, strict=True):
        ax.set_title(note, fontsize=8.5, color=GREY)
        ax.set_xlabel("time [s]")
    _draw_inequality(axes[0], study)
    _draw_promise(axes[1], study)
    _draw_entries(axes[2], entering)
    return figure


def _draw_inequality(ax: Axes, study: TheoremPaths) -> None:
    """E[LV] below -Delta E[V^p] + Gamma."""
    promised, values = study.bounds, study.values
    LV = np.mean(values.LV, axis=0)
    least = -promised.Delta * np.mean(values.V**promised.p, axis=0)
    ax.plot(study.time, least + promised.Gamma, color=ORANGE)
    ax.plot(study.time, LV, color=BLUE, linewidth=0.8)
    ax.set_yscale("symlog", linthresh=LINEAR)
    ax.set_ylabel("rate of $V$")
    ax.set_xlim(0, study.time[-1])
    _name(ax, promised.Gamma, r"$-\Delta\, E V^p + \Gamma$", ORANGE, above=False)
    _name(ax, 0.0, "$E[LV]$", BLUE)


def _draw_promise(ax: Axes, study: TheoremPaths) -> None:
    """Rms error against the bounds of |z1|."""
    promised = study.bounds
    ax.plot(study.time, np.sqrt(np.mean(study.z1**2, axis=0)), color=BLUE)
    ax.set_yscale("log")
    ax.set_xlim(0, study.time[-1])
    ax.set_ylabel("$|z_1|$ [rad]")
    without = f"promised without the {promised.largest_term} term"
    lines = ((promised.ultimate_error, "promised"), (promised.error_without_largest_term, without))
    for height, label in lines:
        ax.axhline(height, color=ORANGE, linestyle=DASHED, linewidth=1.0)
        _name(ax, height, f"{label}: {height:.3g} rad", ORANGE)
    rms = float(np.sqrt(np.mean(study.late_error**2)))
    _name(ax, 2 * rms, f"rms of the paths, {rms:.2g} rad", BLUE)


def _draw_entries(ax: Axes, entering: TheoremPaths) -> None:
    """Distribution of the first entry, its mean and the bound of the mean."""
    entry = np.sort(entering.entry[np.isfinite(entering.entry)])
    share = np.arange(1, len(entry) + 1) / len(entering.entry)
    ax.step(entry, share, where="post", color=BLUE)
    ax.axhline(1.0, color=LIGHT, linewidth=0.8)
    ax.set_xscale("log")
    ax.set_xlim(0.5 * entry[0], 1.3 * entering.bounds.first_entry)
    ax.set_ylim(0, 1.08)
    ax.set_ylabel("share that has entered")
    marks = (
        ("mean", float(np.mean(entry)), BLUE, "left"),
        ("bound", entering.bounds.first_entry, ORANGE, "right"),
    )
    for name, place, color, side in marks:
        ax.axvline(place, color=color, linestyle=DASHED, linewidth=1.0)
        ax.annotate(f" {name} {place:.3g} s ", (place, 0.5), color=color, fontsize=8, ha=side)


def _name(ax: Axes, height: float, label: str, color: str, above: bool = True) -> None:
    ax.annotate(
        label, (0.995, height), (0, 4 if above else -5), ha="right",
        va="bottom" if above else "top", color=color, fontsize=8,
        xycoords=("axes fraction", "data"), textcoords="offset points",
    )  # fmt: skip
