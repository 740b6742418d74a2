"""What each joint of an ensemble does, as plain data and as a table."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console

from ftcfa.report.records import finite
from ftcfa.report.terminal import number, print_table

OF_JOINTS: Mapping[str, Any] = {
    "late_rms_joint_error": np.median,
    "late_peak_joint_error": np.max,
    "joint_saturated": np.median,
    "rms_torque": np.median,
    "peak_torque": np.max,
    "rms_torque_rate": np.median,
    "rate_limited": np.median,
}
"""Metrics of the table of joints, and what of all paths it shows."""


def joint_records(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """What each joint does: medians over the paths, and the worst path's peaks."""
    kinds = dataset["joint_type"].values
    return [
        {
            "joint": str(joint),
            "unit": "m" if kind == "prismatic" else "rad",
            "torque_unit": "N" if kind == "prismatic" else "N m",
            "effort_limit": finite(dataset["effort_limit"].values[k]),
            "torque_rate_limit": finite(dataset["torque_rate_limit"].values[k]),
            "failed": int(np.sum(dataset["outcome_joint"].values == k)),
            **{
                name: finite(take(np.nan_to_num(dataset[name].values[:, k], nan=np.inf)))
                for name, take in OF_JOINTS.items()
            },
        }
        for k, (joint, kind) in enumerate(zip(dataset["joint"].values, kinds, strict=True))
    ]


def print_joints(joints: list[dict[str, Any]], console: Console) -> None:
    """Print a line a joint: errors, torques beside the limit, and what was limited."""

    def share(x: float | None) -> str:
        return "-" if x is None else f"{100 * x:.2g}"

    rows = [
        [
            it["joint"] if it["unit"] == "rad" else f"{it['joint']} [m, N]",
            number(it["late_rms_joint_error"], ".2g"), number(it["late_peak_joint_error"], ".2g"),
            *(_of_limit(it[name], it["effort_limit"]) for name in ("rms_torque", "peak_torque")),
            share(it["joint_saturated"]), number(it["rms_torque_rate"], ".3g"),
            share(it["rate_limited"]), str(it["failed"]),
        ]
        for it in joints
    ]  # fmt: skip
    heads = [
        "joint", "rms\nrad", "peak\nrad", "rms u\n%", "peak u\n%", "satur.\n%", "rate\nN m/s",
        "limited\n%", "fail",
    ]  # fmt: skip
    print_table(heads, rows, console)


def _of_limit(torque: float | None, limit: float | None) -> str:
    """A torque in per cent of its limit."""
    return "-" if torque is None or limit is None else f"{100 * torque / limit:.2g}"
