"""Recorded accelerations: evenly sampled values, read from a file and checked.

Each axis has a unit, stated by argument or in the header of the file, such as ``time [s], x [g],
roll [rad/s^2]``; a unit is never guessed.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from scipy import signal

from ftcfa.arrays import Array
from ftcfa.checks import Check, known_name, natural, numbers, positive
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.files import local_path
from ftcfa.parts import Part
from ftcfa.vibration.records.columns import Columns, default_names, read_columns
from ftcfa.vibration.records.quantities import Unit, acceleration, derivation, quantity, same_unit
from ftcfa.vibration.records.time_axis import (
    JITTER,
    agrees_with,
    even_step,
    rising,
    seconds,
    time_column,
)

TimeUnit = Literal["s", "ms", "us", "ns"]
MAX_SAMPLES = 10**8
"""Largest number of samples that are made of uneven ones."""
_COUNT = re.compile(r"|unnamed: \d+|count|index|idx|sample|samples|no\.?|#|n|row", re.IGNORECASE)
"""Names of columns that count samples."""


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
        units: Unit of each axis, m/s^2 or rad/s^2; m/s^2 where none are given.
    """

    step: Annotated[float, Check(positive, "s")]
    values: Annotated[Array, Check(check_values, "m/s^2 or rad/s^2")]
    axes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

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
        object.__setattr__(self, "units", tuple(self.units) or ("m/s^2",) * len(axes))

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
        means = (f"{n} {m:.3g}" for n, m in zip(self.axes, self.values.mean(axis=0), strict=True))
        removed += f" (mean of {', '.join(means)})"
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
    *,
    rate: float | None = None,
    time_unit: TimeUnit | None = None,
    skip: int = 0,
    resample: float | None = None,
) -> Record:
    """Read and check recorded accelerations, or rates or positions, from which they follow.

    A column named time, t or timestamp, or one of ISO 8601 times, holds the times; columns that
    count samples are left out.

    Args:
        file: ``.csv``, ``.tsv``, ``.txt``, ``.npy`` or ``.npz``.
        unit: Unit of all axes, or one for each axis, where the file states none.
        step: Sampling step where the file has no column of times [s].
        columns: Names of the header to read as axes, in this order; None reads all.
        jitter: Allowed relative deviation of a time step from the mean step.
        rate: Sampling rate, instead of ``step`` [Hz].
        time_unit: Unit of the times where the file states none: s, ms, us or ns.
        skip: Number of lines above the table.
        resample: Rate to which uneven times are interpolated, linearly [Hz]; None refuses them.

    Returns:
        The record in m/s^2 and rad/s^2, not detrended.

    Raises:
        ParameterError: Naming file and row of a gap, an uneven step, a time that does not rise, or
            a value that is no finite number; or if the file is empty, or a unit is not stated, or
            stated otherwise by the file.
        ShapeError: If the number of units is not the number of axes.
        UnknownNameError: If the header lacks one of ``columns``, or a unit is unknown.
    """
    path = local_path(file)
    step = _given_step(step, rate)
    table = read_columns(path, natural("read_record skip", skip))
    at = time_column(table)
    if at is None and not table.header and step is None and len(table.names) > 1:
        at = 0  # without a header, the first column is time
    chosen = _axes(table, at, columns)
    values = np.column_stack([table.numbers(k) for k in chosen])
    notes = [path.name, *table.notes, *_left_out(table, at if step is None else None, chosen)]
    if step is None:
        values, step, note = _in_time(table, at, values, time_unit, resample, jitter)
        notes.append(note)
    elif at is not None:
        agrees_with(step, table, at, time_unit, jitter)
    named = table.header or at is None
    names = tuple(table.names[k] for k in chosen) if named else default_names(len(chosen))
    units = _units(path, names, [table.units[k] for k in chosen], unit)
    kinds = [quantity(f"{path}: unit of {n}", u) for n, u in zip(names, units, strict=True)]
    made = [acceleration(values[:, k], kind, step) for k, kind in enumerate(kinds)]
    notes += [f"{n}: {derivation(k)}" for n, k in zip(names, kinds, strict=True) if derivation(k)]
    si = tuple(kind.unit for kind in kinds)
    return Record(step, np.column_stack(made), names, tuple(filter(None, notes)), si)


def _left_out(table: Columns, at: int | None, chosen: Sequence[int]) -> Iterator[str]:
    """A note of the named columns that are neither times nor axes."""
    others = [n for k, n in enumerate(table.names) if n and k != at and k not in chosen]
    if table.header and others:
        yield f"left out: {', '.join(others)}"


def _in_time(
    table: Columns,
    at: int | None,
    values: Array,
    time_unit: TimeUnit | None,
    resample: float | None,
    jitter: float,
) -> tuple[Array, float, str]:
    """Values at even times, their step [s], and a note of what was done to the times."""
    if at is None:
        got = "no column of times" if len(table.names) > 1 else "one column"
        remedy = "name it time [s], or give step or rate"
        raise ParameterError(str(table.path), got, "times and one axis or more", remedy)
    time = seconds(table, at, time_unit)
    if resample is None:
        return values, *even_step(table.path, time, table.rows, jitter)
    rising(table.path, time, table.rows)
    return *_resampled(time, values, resample), f"interpolated linearly to {resample:g} Hz"


def _given_step(step: float | None, rate: float | None) -> float | None:
    """The step that the user gave, also as a rate [s]."""
    if rate is None:
        return step
    if step is not None:
        raise ParameterError("read_record", "step and rate", "one of them", field="rate")
    positive("read_record rate", rate, "Hz", field="rate")
    return 1.0 / rate


def _axes(table: Columns, at: int | None, columns: tuple[str, ...] | None) -> list[int]:
    """Numbers of the columns that are axes."""
    if columns is not None:
        for column in columns:
            known_name(f"{table.path}: column", column, [n for n in table.names if n])
        return [table.names.index(column) for column in columns]
    counts = {k for k, name in enumerate(table.names) if table.header and _COUNT.fullmatch(name)}
    chosen = [k for k in range(len(table.names)) if k != at and k not in counts]
    if not chosen:
        expected = "times and one axis or more"
        raise ParameterError(str(table.path), "one column", expected, "give step if there are none")
    return chosen


def _units(
    path: Path, names: tuple[str, ...], stated: list[str], unit: Unit | Sequence[Unit] | None
) -> list[str]:
    """The unit of each axis; an argument fills gaps and must not contradict the file."""
    if unit is None:
        return stated
    given = [unit] * len(names) if isinstance(unit, str) else list(unit)
    if len(given) != len(names):
        raise ShapeError(f"{path}: unit", f"{len(given)} units", f"one, or {len(names)}")
    for name, own, other in zip(names, stated, given, strict=True):
        if own and same_unit(own) != same_unit(other):
            remedy = "leave unit out, or correct the header"
            raise ParameterError(f"{path}: unit of {name}", f"{own} in the file", other, remedy)
    return list(given)


def _resampled(time: Array, values: Array, rate: float) -> tuple[Array, float]:
    """Values (samples, axes) at even times, and their step [s]."""
    positive("read_record resample", rate, "Hz", field="resample")
    count = int(np.floor((time[-1] - time[0]) * rate)) + 1
    if not 2 <= count <= MAX_SAMPLES:
        got, expected = f"{count} samples", f"from 2 to {MAX_SAMPLES:g}"
        raise ParameterError("read_record resample", got, expected, field="resample")
    even = time[0] + np.arange(count) / rate
    return np.column_stack([np.interp(even, time, axis) for axis in values.T]), 1.0 / rate
