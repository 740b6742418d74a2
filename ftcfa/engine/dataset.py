"""Recorded signals as an xarray Dataset, with units and the description of their loop."""

import json
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.control.protocol import Quantity
from ftcfa.description.write import provenance
from ftcfa.engine.compiler.kernels.table import KERNELS
from ftcfa.engine.paths import Paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.command import LOOP_QUANTITIES


def trajectories(
    loop: ClosedLoop,
    time: Array,
    run: Paths,
    paths: npt.NDArray[np.uint64],
    varied: Mapping[str, Array],
) -> xr.Dataset:
    """Recorded signals as a Dataset over paths.

    Args:
        loop: The closed loop that ran.
        time: Times of the samples, shape (T,) [s].
        run: The paths that ran.
        paths: Numbers of the paths.
        varied: Parameters that differ from path to path, each of shape (paths, ...); they become
            coordinates.
    """
    numbers = paths if np.any(paths >= 2**63) else paths.astype(np.int64)  # as usual, if all fit

    def inner(name: str, shape: tuple[int, ...]) -> list[str]:
        return ["joint"] if shape == (loop.arm.n,) else [f"{name}_{i}" for i in range(len(shape))]

    coordinates: dict[str, Any] = {
        "path": ("path", numbers, {"long_name": "number of the path"}),
        "time": ("time", time, {"units": "s"}),
        "joint": ("joint", list(loop.arm.joint_names)),
        "joint_type": ("joint", list(loop.arm.joint_types)),
    }
    for name, values in varied.items():
        coordinates[name] = (("path", *inner(name, values.shape[1:])), values)
    labels = attributes(loop, *LOOP_QUANTITIES["q_d"], True)
    variables: dict[str, Any] = {}
    q_d = run.signals.get("q_d")  # where it differs from path to path
    if q_d is None:
        q_d = loop.desired(time).q[None]
        variables["q_d"] = (("time", "joint"), q_d[0], labels)
    quantities = loop.quantities
    for name, values in run.signals.items():
        dims = inner(name, values.shape[2:])
        quantity = quantities.get(name, Quantity("", name))
        labels = attributes(loop, *quantity, "joint" in dims)
        variables[name] = (("path", "time", *dims), values, labels)
    squares = sum((run.signals["q"][:, :, j] - q_d[:, :, j]) ** 2 for j in range(loop.arm.n))
    unit = variables["q"][2]["units"]
    labels = {"units": unit, "long_name": "overall tracking error |q - q_d|"}
    variables["ote"] = (("path", "time"), np.sqrt(squares), labels)
    labels = {"units": "s", "long_name": "time of divergence, NaN for a path that did not diverge"}
    variables["diverged_at"] = (("path",), run.diverged_at, labels)
    attrs = {**versions(), "experiment": json.dumps(provenance(loop))}
    return xr.Dataset(variables, coordinates, attrs)


@cache
def versions() -> dict[str, Any]:
    """What the numbers depend on beside their loop, for the attributes of a Dataset."""
    return {"ftcfa_version": version("ftcfa"), "kernels": KERNELS}


def attributes(loop: ClosedLoop, unit: str, meaning: str, per_joint: bool) -> dict[str, str]:
    """Attributes of a variable: unit and meaning; prismatic joints have m instead of rad."""
    if per_joint and "prismatic" in loop.arm.joint_types:
        linear = "N" if unit == "N m" else unit.replace("rad", "m")
        unit = f"{unit} (prismatic joints: {linear})"
    return {"units": unit, "long_name": meaning}
