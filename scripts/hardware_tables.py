"""Tables of README about sensors and motors, from the records of their scripts."""

from typing import Any

import numpy as np
from records import record, table

MARGIN_LAWS = {
    "FTCF": "FTCF",
    "CommandFilteredBackstepping": "command-filtered",
    "ComputedTorque": "computed torque",
    "FiniteTimeBackstepping": "finite-time, no filter",
    "PDGravity": "PD + gravity",
    "PositionFeedback": "positions alone",
    "SlotineLi": "Slotine-Li",
    "SuperTwisting": "super-twisting",
}
"""Columns of the table of margins."""


def velocities() -> str:
    """How well FTCF does with velocities from positions."""
    found = record("velocities")

    def encoder(row: dict[str, Any]) -> str:
        noisy = f", noise of {row['noise']:g} step" if row["noise"] else ""
        return f"{row['bits']} bit{noisy}" if row["bits"] else "exact"

    rows = [
        [
            row["estimator"], encoder(row), f"{1e3 * row['error']:.1f} mrad",
            f"{row['rate']:,.0f} N m/s",
            f"{row['settling']:.2f} s" if np.isfinite(row["settling"]) else "never",
        ]
        for row in found["rows"]
    ]  # fmt: skip
    return table(["velocity", "encoder", "rms error", "torque rate", "settled"], rows)


def margins() -> str:
    """Latency, resolution and delay at which the error doubles and the loop is lost."""
    found = record("margins")["arms"]

    def number(value: float | None, end: str) -> str:
        return end if value is None else f"{float(f'{1e3 * value:.3g}'):,g}"

    def cell(row: dict[str, dict[str, Any]], key: str) -> str:
        if all(one["lost"] == 0 for one in row.values() if one is not row["resolution"]):
            return "lost"  # with ideal hardware
        ends = {"latency": "> 30", "resolution": "> 1,000", "delay": "> 30"}
        return " / ".join(number(row[name][key], ends[name]) for name in row)

    tables = [
        table(
            [f"{words}, arm", *MARGIN_LAWS.values()],
            [[arm, *(cell(laws[law], key) for law in MARGIN_LAWS)] for arm, laws in found.items()],
        )
        for key, words in (("doubled", "error doubles"), ("lost", "loop lost"))
    ]
    return "\n\n".join(tables)


def bases() -> str:
    """Displacements of the arms on a truck and a ship, by rate limit and by delay."""
    found = record("sensors-and-motors")["arms"]

    def cell(one: dict[str, float | None]) -> str:
        numbers = (one["without"], one["with"])
        return " → ".join("lost" if x is None else f"{1e3 * x:.2g}" for x in numbers)

    first = next(iter(found.values()))["bases"]["truck"]
    rates = [x if x == "no limit" else f"{x} N m/s" for x in first["rates"]]
    heads = ["arm, base [mrad]", *rates, *(f"{x} ms" for x in first["delays"])]
    rows = [
        [f"{arm}, {base}", *(cell(it) for group in one.values() for it in group.values())]
        for arm, bases in found.items()
        for base, one in bases["bases"].items()
    ]
    return table(heads, rows)


def whole_band() -> str:
    """Errors of Panda with a whole reading fed forward through motors of 1,000 N m/s."""
    rows = [
        [base, *("lost" if x is None else f"{1e3 * x:.3g}" for x in errors)]
        for base, errors in record("sensors-and-motors")["whole band"].items()
    ]
    return table(["base [mrad]", "without", "1 ms late", "10 ms late"], rows)
