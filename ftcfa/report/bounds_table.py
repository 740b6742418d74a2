"""The tables of Theorem 1 for a loop: verdict, gain conditions, constants, measurements."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ftcfa.report.terminal import number, plain_table, print_facts, print_fitted


def print_bounds(record: Mapping[str, Any], console: Console) -> None:
    """Print the verdict, the gain conditions, the constants, and what was measured.

    Args:
        record: Result of `bounds_record`.
        console: Where to print.
    """
    console.print(record["verdict"], style="bold", highlight=False)
    console.print()
    print_fitted(_condition_table(record["conditions"]), console)
    console.print()
    print_facts(_facts(record), console)
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
    """A table of the conditions on the gains, a row each."""
    table = plain_table()
    table.add_column("gain", no_wrap=True)
    for header in ("is", "needs"):
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("holds", no_wrap=True)
    table.add_column("instead of", overflow="fold")
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
    """Labels and texts of the constants."""
    supplied = record["supplied"]
    facts = [
        ("supplied", ", ".join(f"{name} = {value:g}" for name, value in supplied.items())),
        ("Mmin, Mmax", f"{record['Mmin']:.4g}, {record['Mmax']:.4g} kg m^2 or kg"),
        ("w_s, p", f"{record['weight']:.4g}, {record['p']:.4g}"),
        ("Delta", _least(record["Delta_terms"])),
        ("Gamma", _sum(record["Gamma"], record["Gamma_terms"])),
        ("V0, Vinf", f"{record['V0']:.4g}, {number(record['Vinf'], missing='none')}"),
    ]
    if record["filter_reach"] is not None:
        reach = f"exact while |alpha''| <= {record['filter_reach']:.4g} rad/s^3"
        facts.append(("filter", f"{reach}; white noise in v gives alpha'' no bound"))
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
    """The least of several terms, with its name."""
    name = min(terms, key=lambda each: terms[each])
    return f"{terms[name]:.4g}, the least of {len(terms)}: {name}"


def _sum(total: float, terms: Mapping[str, float]) -> str:
    """A sum with its terms."""
    parts = [f"{name} {value:.4g}" for name, value in terms.items() if value]
    return f"{total:.4g} = {' + '.join(parts)}"


def _comparison(record: Mapping[str, Any]) -> Table:
    """A table of promises and measurements side by side."""
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
    for label, *values in rows:
        table.add_row(escape(label), *(number(value, missing="none") for value in values))
    held = measured["premises_hold"]
    if held is not None:
        table.add_row("premises hold until entry", "always", f"{100 * held:.3g} %")
    return table
