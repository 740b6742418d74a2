"""`simulate`: one path of a closed loop as an xarray Dataset."""

import json
from collections.abc import Iterable
from importlib.metadata import version

import numpy as np
import xarray as xr

from ftcfa.control.protocol import Signals
from ftcfa.engine.interpreted import run_interpreted
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.describe import describe

STANDARD = ("q", "q_d", "v", "u")
"""Signals that every Dataset has; the others are recorded on request."""

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


def simulate(
    loop: ClosedLoop,
    duration: float,
    *,
    seed: int = 0,
    path: int = 0,
    signals: Iterable[str] = (),
    record_every: int = 1,
) -> xr.Dataset:
    """Simulate one path.

    The noise of path i belongs to (seed, i) alone, so any path can be run again by itself.

    Args:
        loop: The closed loop.
        duration: Simulated time [s]; samples lie at 0, period, ... up to and including it.
        seed: Seed of the experiment, 0 <= seed < 2^64.
        path: Number of the path, 0 <= path < 2^64.
        signals: Internal signals to record beside q, q_d, v and u, or ``"all"``.
        record_every: Keep every so many samples.

    Returns:
        A Dataset with ``time`` [s]; ``q``, ``q_d``, ``v``, ``u`` over (time, joint); ``ote``, the
        overall tracking error |q - q_d|, over time; the asked signals; and ``diverged_at`` [s],
        NaN unless the path diverged, in which case all is NaN from then on.

    Raises:
        ParameterError, UnknownNameError: If an argument is out of range or a signal unknown.
    """
    samples = _samples(loop, duration)
    for subject, value in (("seed", seed), ("path", path)):
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, np.integer))
            or not 0 <= value < 2**64
        ):
            raise ParameterError(subject, repr(value), "an integer from 0 to 2^64 - 1")
    if isinstance(record_every, bool) or int(record_every) != record_every or record_every < 1:
        raise ParameterError("record_every", repr(record_every), "an integer >= 1")
    names = _signal_names(loop, signals)
    recorded, died = run_interpreted(loop, samples, record_every, int(seed), int(path), names)
    time = np.arange(0, samples, record_every) * loop.period
    dataset = _dataset(loop, time, recorded, died)
    dataset.attrs |= {"seed": int(seed), "path": int(path), "duration": float(duration)}
    return dataset


def _samples(loop: ClosedLoop, duration: float) -> int:
    if not (isinstance(duration, (int, float)) and np.isfinite(duration) and duration >= 0):
        raise ParameterError("duration", repr(duration), "a number >= 0 [s]")
    return round(duration / loop.period) + 1


def _signal_names(loop: ClosedLoop, signals: Iterable[str]) -> list[str]:
    known = list(loop.signal_shapes())
    asked = known if signals == "all" else [signals] if isinstance(signals, str) else list(signals)
    for name in asked:
        if name not in known:
            raise UnknownNameError("signal", name, known)
    return [*STANDARD, *(name for name in asked if name not in STANDARD)]


def _dataset(loop: ClosedLoop, time: np.ndarray, recorded: Signals, died: float) -> xr.Dataset:
    prismatic = "prismatic" in loop.arm.joint_types
    dataset = xr.Dataset(
        coords={
            "time": ("time", time, {"units": "s"}),
            "joint": ("joint", list(loop.arm.joint_names)),
            "joint_type": ("joint", list(loop.arm.joint_types)),
        },
        attrs={
            "ftcfa_version": version("ftcfa"),
            "experiment": json.dumps(describe(loop)),
        },
    )
    for name, values in recorded.items():
        per_joint = values.ndim == 2 and values.shape[1] == loop.arm.n
        unit, meaning = UNITS.get(name, ("", name))
        if prismatic and per_joint:
            unit = f"{unit} (prismatic joints: {_linear(unit)})"
        dims = ("time", "joint") if per_joint else ("time",)
        data = values if per_joint else values.reshape(len(time))
        dataset[name] = (dims, data, {"units": unit, "long_name": meaning})
    error = recorded["q"] - recorded["q_d"]
    dataset["ote"] = (
        ("time",),
        np.linalg.norm(error, axis=1),
        {"units": "rad", "long_name": "overall tracking error |q - q_d|"},
    )
    dataset["diverged_at"] = ((), died, {"units": "s", "long_name": "time of divergence"})
    return dataset


def _linear(unit: str) -> str:
    return {"N m": "N"}.get(unit, unit.replace("rad", "m"))
