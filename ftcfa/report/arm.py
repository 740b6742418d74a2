"""An arm as plain data and as a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import mass_matrix_bounds
from ftcfa.report.records import finite
from ftcfa.report.terminal import number, plain_table, print_facts, print_fitted

NAMED_ZEROS = 4
"""Number of joints locked at zero that the table names, of the dozens of a hand."""


def arm_record(arm: Arm) -> dict[str, Any]:
    """All that ``ftcfa inspect`` shows, as plain data; None where a limit is infinite.

    Units: rad, rad/s, N m, N m s/rad for revolute joints; m, m/s, N, N s/m for prismatic ones.
    """
    names = list(arm.model.names[1:])
    locked = [name for name, row in zip(names, arm.G, strict=True) if not row.any()]
    mimics = [name for name in names if name not in (*arm.joint_names, *locked)]
    Mmin, Mmax = mass_matrix_bounds(arm)
    return {
        "name": arm.name,
        "source": dict(arm.source or {}),
        "joints": [_joint(arm, i, names.index(name)) for i, name in enumerate(arm.joint_names)],
        "locked": {name: float(arm.g0[names.index(name)]) for name in locked},
        "mimic": {name: _mimic(arm, names.index(name)) for name in mimics},
        "moving_mass": arm.moving_mass,
        "mass_matrix_bounds": {"Mmin": Mmin, "Mmax": Mmax},
        "warnings": list(arm.warnings),
    }


def _joint(arm: Arm, i: int, row: int) -> dict[str, Any]:
    """Record of the moving joint i, whose joint of the model is number ``row``."""
    limits = {
        "lower": arm.lower[i],
        "upper": arm.upper[i],
        "velocity_limit": arm.velocity_limit[i],
        "effort_limit": arm.effort_limit[i],
        "damping": arm.damping[row],
        "friction": arm.friction[row],
        "home": arm.home[i],
    }
    numbers = {key: finite(value) for key, value in limits.items()}
    return {"name": arm.joint_names[i], "type": arm.joint_types[i], **numbers}


def _mimic(arm: Arm, row: int) -> dict[str, Any]:
    """Rule of a mimic joint: multiplier times the joint that it follows, plus offset."""
    leader = int(np.argmax(arm.G[row] != 0))
    return {
        "joint": arm.joint_names[leader],
        "multiplier": float(arm.G[row, leader]),
        "offset": float(arm.g0[row]),
    }


def print_arm(record: Mapping[str, Any], console: Console, description: str = "") -> None:
    """Print an arm: a table of its joints, then what is true of the whole arm.

    Args:
        record: Result of `arm_record`.
        console: Where to print.
        description: What the arm is, in a phrase; may be empty.
    """
    joints = record["joints"]
    title = f"{record['name']}: {description}" if description else record["name"]
    console.print(title, style="bold", highlight=False, markup=False)
    print_fitted(_joint_table(joints), console)
    console.print()
    print_facts(_facts(record), console)
    for warning in record["warnings"]:
        console.print(f"warning: {warning}", style="yellow", highlight=False, markup=False)


def print_catalogue(descriptions: Mapping[str, str], console: Console) -> None:
    """Print the names of the arms that need no path, with what each is."""
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold", no_wrap=True)
    for name, description in descriptions.items():
        table.add_row(name, description)
    console.print(table, highlight=False, markup=False)


COLUMNS = {
    "lower": (".3f", "lower", "rad", "m"),
    "upper": (".3f", "upper", "rad", "m"),
    "velocity_limit": (".4g", "velocity", "rad/s", "m/s"),
    "effort_limit": (".4g", "effort", "N m", "N"),
    "damping": (".3g", "damping", "Nms/rad", "N s/m"),
    "friction": (".3g", "friction", "N m", "N"),
    "home": (".3f", "home", "rad", "m"),
}
"""Columns of numbers: format, header, unit of revolute joints and unit of prismatic joints."""


def _joint_table(joints: list[dict[str, Any]]) -> Table:
    """A table of one row a joint; without damping or friction if no joint has any."""
    shown = [key for key in COLUMNS if key not in _absent(joints)]
    kinds = sorted({joint["type"] == "prismatic" for joint in joints})
    table = plain_table()
    table.add_column("joint", overflow="fold", min_width=10)
    table.add_column("type", no_wrap=True)
    for _, header, *units in (COLUMNS[key] for key in shown):
        lines = [header, *(units[kind] for kind in kinds)]
        table.add_column("\n".join(lines), justify="right", no_wrap=True)
    for joint in joints:
        numbers = (number(joint[key], COLUMNS[key][0], "none") for key in shown)
        table.add_row(joint["name"], joint["type"], *numbers)
    return table


def _absent(joints: list[dict[str, Any]]) -> list[str]:
    """The names, of damping and friction, that no joint has."""
    return [key for key in ("damping", "friction") if not any(joint[key] for joint in joints)]


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Labels and texts of what is true of the whole arm."""
    joints, bounds = record["joints"], record["mass_matrix_bounds"]
    linear = any(joint["type"] == "prismatic" for joint in joints)
    facts = [
        ("moving mass", f"{record['moving_mass']:.4g} kg"),
        (
            "Mmin, Mmax",
            f"{bounds['Mmin']:.4g}, {bounds['Mmax']:.4g} {'kg m^2 or kg' if linear else 'kg m^2'}"
            " (extreme eigenvalues of M over the joint range)",
        ),
    ]
    if absent := _absent(joints):
        facts.append((" and ".join(absent), "none in the URDF"))
    if gravity := record["source"].get("gravity"):
        facts.append(("gravity", f"({', '.join(f'{g:g}' for g in gravity)}) m/s^2"))
    if record["locked"]:
        facts.append(("locked", _locked(record["locked"])))
    if record["mimic"]:
        facts.append(("mimic", ", ".join(_rule(*item) for item in record["mimic"].items())))
    return facts


def _locked(locked: Mapping[str, float]) -> str:
    """Locked joints with their values; only the first few of those at zero by name."""
    away = [f"{name} = {value:.4g}" for name, value in locked.items() if value]
    zero = [name for name, value in locked.items() if not value]
    words = away + [f"{name} = 0" for name in zero[:NAMED_ZEROS]]
    if len(zero) > NAMED_ZEROS:
        words.append(f"and {len(zero) - NAMED_ZEROS} more at 0")
    return ", ".join(words)


def _rule(name: str, rule: Mapping[str, Any]) -> str:
    """The rule of a mimic joint as a formula."""
    offset = f" {rule['offset']:+.4g}" if rule["offset"] else ""
    return f"{name} = {rule['multiplier']:g} {rule['joint']}{offset}"
