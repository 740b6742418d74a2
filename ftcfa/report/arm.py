"""An arm as plain data and as a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console

from ftcfa.model.arm import Arm
from ftcfa.model.gravity_load import GravityLoad, gravity_load
from ftcfa.model.mass_matrix_bounds import mass_matrix_bounds
from ftcfa.report.records import finite
from ftcfa.report.terminal import number, print_facts, print_line, print_table

GRAVITY = "gravity_load"
COLUMNS = {
    "lower": (".3f", "lower", "rad", "m"),
    "upper": (".3f", "upper", "rad", "m"),
    "velocity_limit": (".4g", "speed", "rad/s", "m/s"),
    "effort_limit": (".4g", "effort", "N m", "N"),
    GRAVITY: (".3g", "load", "N m", "N"),
    "damping": (".3g", "damping", "Nms/rad", "N s/m"),
    "friction": (".3g", "friction", "N m", "N"),
    "armature": (".3g", "armature", "kg m^2", "kg"),
    "home": (".3f", "home", "rad", "m"),
}
"""Columns of numbers: format, header, unit of revolute joints and unit of prismatic joints."""
OF_EVERY_JOINT = ("damping", "friction", "armature")
"""Columns whose arrays have an entry for each joint of the model, not for each moving joint."""
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
    load = gravity_load(arm)
    return {
        "name": arm.name,
        "source": dict(arm.source or {}),
        "joints": [
            _joint(arm, i, names.index(name), load) for i, name in enumerate(arm.joint_names)
        ],
        "locked": {name: float(arm.g0[names.index(name)]) for name in locked},
        "mimic": {name: _mimic(arm, names.index(name)) for name in mimics},
        "moving_mass": arm.moving_mass,
        "mass_matrix_bounds": {"Mmin": Mmin, "Mmax": Mmax},
        "warnings": list(arm.warnings),
    }


def _joint(arm: Arm, i: int, row: int, load: GravityLoad) -> dict[str, Any]:
    """Record of the moving joint i, whose joint of the model is number ``row``."""
    places = {key: row if key in OF_EVERY_JOINT else i for key in COLUMNS if key != GRAVITY}
    numbers = {key: finite(getattr(arm, key)[place]) for key, place in places.items()}
    loads = {GRAVITY: float(load.worst[i]), f"{GRAVITY}_at_home": float(load.home[i])}
    return {"name": arm.joint_names[i], "type": arm.joint_types[i], **numbers, **loads}


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
    absent = [key for key in OF_EVERY_JOINT if not any(joint[key] for joint in joints)]
    title = f"{record['name']}: {description}" if description else record["name"]
    print_line(title, console, "bold")
    _print_joints(joints, [key for key in COLUMNS if key not in absent], console)
    console.print()
    print_facts(_facts(record, absent), console)
    for warning in record["warnings"]:
        print_line(f"warning: {warning}", console, "yellow")


def print_catalogue(descriptions: Mapping[str, str], console: Console) -> None:
    """Print the names of the arms that need no path, with what each is."""
    print_facts(descriptions.items(), console, "bold")


def _print_joints(joints: list[dict[str, Any]], shown: list[str], console: Console) -> None:
    """Print a row for each joint, with the columns of numbers that are shown."""
    kinds = sorted({joint["type"] == "prismatic" for joint in joints})
    heads = ["joint", "type"]
    for _, header, *units in (COLUMNS[key] for key in shown):
        heads.append("\n".join([header, *(units[kind] for kind in kinds)]))
    rows = (
        [joint["name"], joint["type"], *(number(joint[x], COLUMNS[x][0], "none") for x in shown)]
        for joint in joints
    )
    print_table(heads, rows, console, "flr")


def _facts(record: Mapping[str, Any], absent: list[str]) -> list[tuple[str, str]]:
    """Labels and texts of what is true of the whole arm."""
    bounds = record["mass_matrix_bounds"]
    linear = any(joint["type"] == "prismatic" for joint in record["joints"])
    extremes = (
        f"{bounds['Mmin']:.4g}, {bounds['Mmax']:.4g} {'kg m^2 or kg' if linear else 'kg m^2'}"
    )
    facts = [
        ("moving mass", f"{record['moving_mass']:.4g} kg"),
        ("Mmin, Mmax", f"{extremes} (extreme eigenvalues of M over the joint range)"),
    ]
    facts.append(("load", "largest force of gravity found over the joint range"))
    if absent:
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
