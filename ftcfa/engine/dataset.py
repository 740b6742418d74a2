"""Recorded signals as an xarray Dataset, with units and what is needed to run them again."""

import json
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.description.write import LARGE, describe
from ftcfa.engine.paths import Paths
from ftcfa.loop.closed_loop import ClosedLoop

UNITS = {
    "q": ("rad", "position"),
    "q_d": ("rad", "desired position"),
    "v": ("rad/s", "velocity"),
    "u": ("N m", "torque that acts, within the effort limits"),
    "u_command": ("N m", "torque that the controller asks for"),
    "alpha": ("rad/s", "virtual control (7)"),
    "abar": ("rad/s", "filtered virtual control (6)"),
    "z1": ("rad", "tracking error (5)"),
    "z2": ("rad/s", "velocity error (5)"),
    "v1": ("rad", "compensated tracking error (12)"),
    "v2": ("rad/s", "compensated velocity error (12)"),
    "s1": ("rad", "error compensation of the position (10)"),
    "s2": ("rad/s", "error compensation of the velocity (10)"),
    "rho": ("rad/s", "anti-saturation state (11)"),
    "theta": ("1", "estimated squared norm of the network's weights (9)"),
}
"""Units and meaning of the signals of revolute joints; prismatic joints have m for rad."""


def trajectories(
    loop: ClosedLoop,
    time: Array,
    run: Paths,
    paths: npt.NDArray[np.uint64],
    varied: Mapping[str, Array],
) -> xr.Dataset:
    """A Dataset over paths.

    Args:
        loop: The closed loop that ran.
        time: Times of the samples, shape (T,) [s].
        run: Signals over paths and time, and times of divergence.
        paths: Numbers of the paths.
        varied: Parameters that differ from path to path, each of shape (paths, ...); they become
            coordinates.
    """
    dataset = xr.Dataset(
        coords={
            "path": ("path", _signed(paths), {"long_name": "number of the path"}),
            "time": ("time", time, {"units": "s"}),
            "joint": ("joint", list(loop.arm.joint_names)),
            "joint_type": ("joint", list(loop.arm.joint_types)),
        },
        attrs={
            "ftcfa_version": version("ftcfa"),
            "experiment": json.dumps(describe(loop, LARGE)),
        },
    )

    def inner(name: str, shape: tuple[int, ...]) -> list[str]:
        return ["joint"] if shape == (loop.arm.n,) else [f"{name}_{i}" for i in range(len(shape))]

    for name, values in varied.items():
        dataset = dataset.assign_coords({name: (("path", *inner(name, values.shape[1:])), values)})
    q_d = loop.reference.at(time).q
    dataset["q_d"] = (("time", "joint"), q_d, attributes(loop, *UNITS["q_d"], True))
    for name, values in run.signals.items():
        dims = inner(name, values.shape[2:])
        told = attributes(loop, *UNITS.get(name, ("", name)), "joint" in dims)
        dataset[name] = (("path", "time", *dims), values, told)
    squares = sum((run.signals["q"][:, :, j] - q_d[:, j]) ** 2 for j in range(loop.arm.n))
    dataset["ote"] = (
        ("path", "time"),
        np.sqrt(squares),
        {"units": dataset["q"].units, "long_name": "overall tracking error |q - q_d|"},
    )
    dataset["diverged_at"] = (
        ("path",),
        run.died,
        {"units": "s", "long_name": "time of divergence, NaN if none"},
    )
    return dataset


def _signed(paths: npt.NDArray[np.uint64]) -> npt.NDArray[np.integer[Any]]:
    """The numbers as ordinary integers, if they all fit."""
    return paths if np.any(paths >= 2**63) else paths.astype(np.int64)


def attributes(loop: ClosedLoop, unit: str, meaning: str, per_joint: bool) -> dict[str, str]:
    """Units and meaning of a variable; prismatic joints have m for rad."""
    if per_joint and "prismatic" in loop.arm.joint_types:
        unit = f"{unit} (prismatic joints: {_linear(unit)})"
    return {"units": unit, "long_name": meaning}


def _linear(unit: str) -> str:
    return {"N m": "N"}.get(unit, unit.replace("rad", "m"))
