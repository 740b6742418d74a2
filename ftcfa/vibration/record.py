"""Recorded accelerations: evenly sampled values, read from a file and checked.

Each axis has a unit, stated by argument or in the header of the file, such as ``time [s], x [g],
roll [rad/s^2]``; a unit is never guessed.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from scipy import signal

from ftcfa.arrays import Array
from ftcfa.checks import Check, known_name, numbers, positive
from ftcfa.errors import ParameterError, ShapeError, UnknownNameError
from ftcfa.parts import Part
from ftcfa.vibration.columns import read_columns
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

Unit = Literal["m/s^2", "g", "rad/s^2", "deg/s^2"]

SIZES = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "rad/s^2": 1.0, "deg/s^2": np.pi / 180.0}
"""Units of accelerations in m/s^2, of angular ones in rad/s^2."""
JITTER = 0.02
"""Largest relative deviation of a time step from the mean step that counts as rounding."""
GAP = 1.5
"""A time step this many times the median step is a gap."""


def check_values(subject: str, given: npt.ArrayLike, unit: str) -> None:
    """Raise ParameterError unless values are finite, two samples or more of some axes."""
    values = numbers(subject, given)
    if values.ndim != 2 or len(values) < 2 or values.shape[1] == 0:
        got = f"shape {values.shape}"
        raise ParameterError(subject, got, "(samples, axes), two samples or more")
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        sample, axis = bad[0]
        got = f"{values[sample, axis]} in sample {sample + 1}, axis {axis + 1}"
        raise ParameterError(subject, got, f"finite numbers [{unit}]")


@dataclass(frozen=True, eq=False)
class Record(Part):
    """Linear or angular accelerations sampled at even steps.

    Attributes:
        step: h [s].
        values: Shape (samples, axes), two samples or more [m/s^2 or rad/s^2].
        axes: Names of the axes.
        notes: Its origin and the changes made to it, in order.
    """

    step: Annotated[float, Check(positive, "s")]
    values: Annotated[Array, Check(check_values, "m/s^2 or rad/s^2")]
    axes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        values = np.array(self.values, dtype=float)
        axes = self.axes or tuple(f"axis {k + 1}" for k in range(values.shape[1]))
        if len(axes) != values.shape[1]:
            expected = f"{values.shape[1]} names"
            raise ParameterError("Record axes", repr(axes), expected, field="axes")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "axes", tuple(axes))

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.step * (len(self.values) - 1)

    def rms(self) -> Array:
        """Root mean square of each axis, shape (axes,) [m/s^2 or rad/s^2]."""
        return np.sqrt(np.mean(self.values**2, axis=0))

    def detrended(self, kind: Literal["linear", "constant"] = "linear") -> "Record":
        """Record without its straight line or its mean (scipy.signal.detrend): gravity, drift."""
        if kind not in ("linear", "constant"):
            raise ParameterError("Record detrend", repr(kind), '"linear" or "constant"')
        removed = {"linear": "linear trend removed", "constant": "mean removed"}[kind]
        values = signal.detrend(self.values, axis=0, type=kind)
        return replace(self, values=values, notes=(*self.notes, removed))

    def __str__(self) -> str:
        count, axes = self.values.shape
        text = f"{count} samples of {axes} axes at {1e3 * self.step:g} ms"
        return "; ".join([text, *self.notes])


def read_record(
    file: str | Path,
    unit: Unit | Sequence[Unit] | None = None,
    step: float | None = None,
    columns: tuple[str, ...] | None = None,
    jitter: float = JITTER,
) -> Record:
    """Read and check recorded accelerations.

    Args:
        file: ``.csv``, ``.txt``, ``.npy`` or ``.npz``.
        unit: Unit of all axes, or one for each axis; None reads them from the header.
        step: Sampling step where the file has no column of times [s].
        columns: Names of the header to read as axes, in this order; None reads all.
        jitter: Allowed relative deviation of a time step from the mean step.

    Returns:
        The record in m/s^2 and rad/s^2, not detrended.

    Raises:
        ParameterError: Naming file and row of a gap, an uneven step, a time that does not rise, or
            a value that is no finite number; or if the file is empty or an axis has no unit.
        ShapeError: If the number of units is not the number of axes.
        UnknownNameError: If the header lacks one of ``columns``, or a unit is unknown.
    """
    path = Path(file)
    table = read_columns(path, times=step is None)
    axes, values = list(table.names), table.values
    if step is None:
        if values.shape[1] < 2:
            expected, remedy = "times and one axis or more", "give step if there are none"
            raise ParameterError(str(path), "one column", expected, remedy)
        time, axes = axes[0], axes[1:]
        unit_of_time = _split_unit(time)[1]
        if unit_of_time not in ("", "s"):
            subject = f"{path}: column of times '{time}'"
            raise ParameterError(subject, unit_of_time, "s", "give it in seconds")
        step, values = _step(path, values[:, 0], table.rows, jitter), values[:, 1:]
    if columns is not None:
        bare = [_split_unit(name)[0] for name in axes]
        for column in columns:
            known_name(f"{path}: column", column, bare)
        chosen = [bare.index(column) for column in columns]
        axes, values = [axes[k] for k in chosen], values[:, chosen]
    names = tuple(_split_unit(header)[0] for header in axes)
    units = [_split_unit(header)[1] or table.unit for header in axes]
    if unit is not None:
        units = [unit] * len(axes) if isinstance(unit, str) else list(unit)
    if len(units) != len(axes):
        raise ShapeError(f"{path}: unit", f"{len(units)} units", f"one, or {len(axes)}")
    sizes = [_size(path, *pair) for pair in zip(names, units, strict=True)]
    return Record(step, values * sizes, names, (path.name,))


def _split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a header such as ``x [m/s^2]`` or ``x (g)``; "" without one."""
    match = re.fullmatch(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*", name)
    return (match[1], match[2]) if match else (name, "")


def _size(path: Path, axis: str, unit: str) -> float:
    """Size of an axis's unit in m/s^2 or rad/s^2."""
    if not unit:
        remedy = 'unit="g" or unit="m/s^2", or a header such as "x [g]"'
        raise ParameterError(f"{path}: unit of {axis}", "not stated", remedy)
    usual = re.sub(r"s(2|²|\*\*2)", "s^2", unit)  # other ways to write s^2
    if usual not in SIZES:
        raise UnknownNameError(f"{path}: unit of {axis}", unit, SIZES)
    return SIZES[usual]


def _step(path: Path, time: Array, rows: npt.NDArray[np.intp], jitter: float) -> float:
    """Sampling step of evenly rising times [s]."""
    positive("read_record jitter", jitter)
    steps = np.diff(time)
    usual, step = float(np.median(steps)), float((time[-1] - time[0]) / (len(time) - 1))
    even, remedy = "even time steps", "cut the record there or fill the gap"

    def error(k: int, got: str, expected: str, remedy: str) -> ParameterError:
        return ParameterError(f"{path}: row {rows[k + 1]}", got, expected, remedy)

    falls = np.flatnonzero(steps <= 0)
    if falls.size:
        got = f"time {time[falls[0] + 1]:.9g} s after {time[falls[0]]:.9g} s"
        raise error(falls[0], got, "times that rise", "sort the record")
    gaps = np.flatnonzero(steps > GAP * usual)
    if gaps.size:
        got = f"a gap of {steps[gaps[0]]:.4g} s before it, where steps are {usual:.4g} s"
        raise error(gaps[0], got, even, remedy)
    uneven = np.flatnonzero(np.abs(steps / step - 1.0) > jitter)
    if uneven.size:
        got = f"a time step of {steps[uneven[0]]:.6g} s, where the mean is {step:.6g} s"
        remedy = "interpolate the record to even steps, or give jitter= if the times are rounded"
        raise error(uneven[0], got, f"{even} to {100 * jitter:g} %", remedy)
    return step
