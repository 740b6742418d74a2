"""An arm as a roboticist wants to see it: as plain data and as a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import mass_matrix_bounds
from ftcfa.report.terminal import plain_table, print_fitted

NAMED_ZEROS = 4
"""A hand has dozens of joints locked at zero: the table names so many, --json names all."""


def arm_record(arm: Arm) -> dict[str, Any]:
    """All that `ftcfa inspect` shows, as plain data; None where a limit is infinite.

    Units: rad, rad/s, N m, N m s/rad for revolute joints; m, m/s, N, N s/m for prismatic ones.
    """
    names = list(arm.model.names[1:])
    still = [name for name, row in zip(names, arm.G, strict=True) if not row.any()]
    followers = [name for name in names if name not in (*arm.joint_names, *still)]
    Mmin, Mmax = mass_matrix_bounds(arm)
    return {
        "name": arm.name,
        "source": dict(arm.source or {}),
        "joints": [_joint(arm, i, names.index(name)) for i, name in enumerate(arm.joint_names)],
        "locked": {name: float(arm.g0[names.index(name)]) for name in still},
        "mimic": {name: _follows(arm, names.index(name)) for name in followers},
        "moving_mass": arm.moving_mass,
        "mass_matrix_bounds": {"Mmin": Mmin, "Mmax": Mmax},
        "warnings": list(arm.warnings),
    }


def _joint(arm: Arm, i: int, row: int) -> dict[str, Any]:
    limits = {
        "lower": arm.lower[i],
        "upper": arm.upper[i],
        "velocity_limit": arm.velocity_limit[i],
        "effort_limit": arm.effort_limit[i],
        "damping": arm.damping[row],
        "friction": arm.friction[row],
        "home": arm.home[i],
    }
    finite = {key: float(value) if np.isfinite(value) else None for key, value in limits.items()}
    return {"name": arm.joint_names[i], "type": arm.joint_types[i], **finite}


def _follows(arm: Arm, row: int) -> dict[str, Any]:
    leader = int(np.argmax(arm.G[row] != 0))
    return {
        "joint": arm.joint_names[leader],
        "multiplier": float(arm.G[row, leader]),
        "offset": float(arm.g0[row]),
    }


def print_arm(record: Mapping[str, Any], description: str, console: Console) -> None:
    """Write the record of an arm as a table with what does not fit in one below it.

    Args:
        record: Of `arm_record`.
        description: What the arm is, in a phrase; may be empty.
        console: Where to write.
    """
    joints = record["joints"]
    title = f"{record['name']}: {description}" if description else record["name"]
    console.print(title, style="bold", highlight=False, markup=False)
    print_fitted(_joint_table(joints), console)
    console.print()
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column(overflow="fold")
    for label, text in _facts(record):
        facts.add_row(label, text)
    console.print(facts, highlight=False, markup=False)
    for warning in record["warnings"]:
        console.print(f"warning: {warning}", style="yellow", highlight=False, markup=False)


def print_catalogue(descriptions: Mapping[str, str], console: Console) -> None:
    """Write the names of the arms that need no path."""
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
"""Columns of numbers: format, header, and unit of revolute and of prismatic joints."""


def _joint_table(joints: list[dict[str, Any]]) -> Table:
    """One row a joint; no column for damping or friction that no joint has."""
    shown = [key for key in COLUMNS if key not in _absent(joints)]
    kinds = sorted({joint["type"] == "prismatic" for joint in joints})
    table = plain_table()
    table.add_column("joint", overflow="fold", min_width=10)
    table.add_column("type", no_wrap=True)
    for _, header, *units in (COLUMNS[key] for key in shown):
        lines = [header, *(units[kind] for kind in kinds)]
        table.add_column("\n".join(lines), justify="right", no_wrap=True)
    for joint in joints:
        numbers = (_number(joint[key], COLUMNS[key][0]) for key in shown)
        table.add_row(joint["name"], joint["type"], *numbers)
    return table


def _absent(joints: list[dict[str, Any]]) -> list[str]:
    """What no joint has, of damping and friction."""
    return [key for key in ("damping", "friction") if not any(joint[key] for joint in joints)]


def _facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
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
        facts.append(("locked", _held(record["locked"])))
    if record["mimic"]:
        facts.append(("mimic", ", ".join(_rule(*item) for item in record["mimic"].items())))
    return facts


def _held(locked: Mapping[str, float]) -> str:
    """Locked joints with their values; of those at zero the first few by name."""
    away = [f"{name} = {value:.4g}" for name, value in locked.items() if value]
    zero = [name for name, value in locked.items() if not value]
    words = away + [f"{name} = 0" for name in zero[:NAMED_ZEROS]]
    if len(zero) > NAMED_ZEROS:
        words.append(f"and {len(zero) - NAMED_ZEROS} more at 0")
    return ", ".join(words)


def _rule(name: str, rule: Mapping[str, Any]) -> str:
    offset = f" {rule['offset']:+.4g}" if rule["offset"] else ""
    return f"{name} = {rule['multiplier']:g} {rule['joint']}{offset}"


def _number(value: float | None, spec: str) -> str:
    return "none" if value is None else format(value, spec)
