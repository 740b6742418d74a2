"""Theorem 1 for a loop as plain data and as tables: its constants, and what a few paths did."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from rich.console import Console

from ftcfa.report.records import finite
from ftcfa.report.terminal import number, print_facts, print_line, print_table
from ftcfa.theory.premises import TheoremPaths
from ftcfa.theory.theorem1 import Bounds

UNITS = {
    "Mmin": "kg m^2 or kg",
    "Mmax": "kg m^2 or kg",
    "pi1": "rad/s",
    "filter_bound": "rad/s^3",
    "ultimate_error": "rad",
    "error_without_largest_term": "rad",
    "error_at_best_weight": "rad",
    "joint_range": "rad",
    "first_entry": "s",
}
"""Units of the entries of `bounds_record`."""
CONDITION = ("name", "value", "relation", "required", "holds", "needed", "replaces")
"""Attributes of a condition on the gains in the record."""


def bounds_record(promised: Bounds, paths: TheoremPaths) -> dict[str, Any]:
    """All that ``ftcfa bounds`` shows, as plain data; None for what is infinite or not a number.

    Args:
        promised: Result of `ftcfa.bounds`.
        paths: Paths of the same loop.
    """
    weight, error = promised.best_weight()
    return {
        "verdict": promised.verdict,
        "applies": promised.applies,
        "informative": promised.informative,
        "anti_saturation": promised.law.anti_saturation,
        "supplied": {name: getattr(promised, name) for name in ("theta", "eps", "pi1", "sigma")},
        "joints": promised.n,
        "kappa": promised.kappa,
        "p": promised.p,
        "weight": promised.weight,
        "Mmin": promised.Mmin,
        "Mmax": promised.Mmax,
        "conditions": [
            {name: getattr(each, name) for name in CONDITION} for each in promised.conditions
        ],
        "filter_bound": promised.filter_bound,
        "network_box": promised.law.network.half_range,
        "Delta": promised.Delta,
        "Delta_terms": dict(promised.Delta_terms),
        "Gamma": promised.Gamma,
        "Gamma_terms": dict(promised.Gamma_terms),
        "largest_term": promised.largest_term,
        "V0": promised.V0,
        "Vinf": finite(promised.Vinf),
        "ultimate_error": finite(promised.ultimate_error),
        "error_without_largest_term": finite(promised.error_without_largest_term),
        "best_weight": weight,
        "error_at_best_weight": finite(error),
        "joint_range": promised.joint_range,
        "first_entry": finite(promised.first_entry),
        "measured": _measured(paths),
        "units": UNITS,
    }


def _measured(paths: TheoremPaths) -> dict[str, Any]:
    """The same quantities measured on the paths; None if a path diverged."""
    values, needed = paths.values, paths.needed_Gamma.student()
    entry, inside = paths.entry, paths.bounds.Vinf >= values.V
    eps = paths.bounds.eps + max(0.0, float(np.max(paths.missing_eps)))
    pi1 = float(np.max(paths.filter_error))
    supplied = replace(paths.bounds, eps=eps, pi1=pi1)
    return {
        "paths": len(paths.z1),
        "duration": float(paths.time[-1]),
        "rms_error": finite(np.sqrt(np.mean(paths.late_error**2))),
        "error_inside": finite(np.max(paths.z1, where=inside, initial=0.0)),
        "Gamma": finite(np.max(needed.value)),
        "Gamma_high": finite(np.max(needed.high)),
        "first_entry": finite(np.mean(entry)),
        "entered": float(np.mean(np.isfinite(entry))),
        "pi1": finite(pi1),
        "network_input": finite(np.max(paths.network_input)),
        "eps": finite(eps),
        "theta": finite(np.max(values.needed_theta)),
        "premises_hold": float(np.mean(paths.premises_hold)) if np.any(entry > 0) else None,
        "error_if_supplied": finite(supplied.ultimate_error),
    }


def print_bounds(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `bounds_record`: verdict, gain conditions, constants, measurements."""
    print_line(f"{record['verdict']}\n", console, "bold")
    conditions = (
        [each["name"], f"{each['value']:.4g}", f"{each['relation']} {each['required']:.4g}",
         "yes" if each["holds"] else "no", each["replaces"]]
        for each in record["conditions"]
    )  # fmt: skip
    print_table(("gain", "is", "needs", "holds", "instead of"), conditions, console, "lrrlf")
    console.print()
    print_facts(_facts(record), console)
    console.print()
    _print_comparison(record, console)
    measured = record["measured"]
    if measured["error_if_supplied"] is not None:
        print_line(
            f"\nWith the measured eps = {measured['eps']:.3g} and pi1 = {measured['pi1']:.3g} "
            f"rad/s supplied, |z1| <= {measured['error_if_supplied']:.3g} rad.", console
        )  # fmt: skip


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of the constants."""
    supplied = record["supplied"]
    facts = [
        ("law", f'(11) as printed, anti_saturation = "{record["anti_saturation"]}"'),
        ("supplied", ", ".join(f"{name} = {value:g}" for name, value in supplied.items())),
        ("Mmin, Mmax", f"{record['Mmin']:.4g}, {record['Mmax']:.4g} kg m^2 or kg"),
        ("w_s, p", f"{record['weight']:.4g}, {record['p']:.4g}"),
        ("Delta", _least(record["Delta_terms"])),
        ("Gamma", _sum(record["Gamma"], record["Gamma_terms"])),
        ("V0, Vinf", f"{record['V0']:.4g}, {number(record['Vinf'], missing='none')}"),
    ]
    if record["filter_bound"] is not None:
        exact = f"exact while |alpha''| <= {record['filter_bound']:.4g} rad/s^3"
        facts.append(("filter", f"{exact}; white noise in v gives alpha'' no bound"))
    if record["error_at_best_weight"] is not None:
        error = f"|z1| <= {record['error_at_best_weight']:.3g} rad"
        best = f"w_s = {record['best_weight']:.3g}, the best of those up to 1e6"
        facts.append(("other weight", f"{error} at {best}"))
    return facts


def _least(terms: Mapping[str, float]) -> str:
    """The least of several terms, with its name."""
    name = min(terms, key=lambda each: terms[each])
    return f"{terms[name]:.4g}, the least of {len(terms)}: {name}"


def _sum(total: float, terms: Mapping[str, float]) -> str:
    """A sum with its terms."""
    parts = [f"{name} {value:.4g}" for name, value in terms.items() if value]
    return f"{total:.4g} = {' + '.join(parts)}"


def _print_comparison(record: Mapping[str, Any], console: Console) -> None:
    """Print promises and measurements side by side."""
    measured, supplied = record["measured"], record["supplied"]
    pairs = (
        ("|z1| where V <= Vinf [rad]", record["ultimate_error"], measured["error_inside"]),
        ("rms |z1|, last half [rad]", None, measured["rms_error"]),
        ("E[LV + Delta V^p], largest", record["Gamma"], measured["Gamma"]),
        ("E[first entry] [s]", record["first_entry"], measured["first_entry"]),
        ("|abar - alpha| (pi1) [rad/s]", supplied["pi1"], measured["pi1"]),
        ("|X_i|, the network's box", record["network_box"], measured["network_input"]),
        ("eps, given theta", supplied["eps"], measured["eps"]),
        ("theta, if eps = 0", supplied["theta"], measured["theta"]),
    )
    rows = [[label, *(number(x, missing="none") for x in pair)] for label, *pair in pairs]
    held = measured["premises_hold"]
    if held is not None:
        rows.append(["premises hold until entry", "always", f"{100 * held:.3g} %"])
    paths = f"{measured['paths']} paths of {measured['duration']:g} s"
    print_table([paths, "promised\nor supplied", "measured"], rows, console)
