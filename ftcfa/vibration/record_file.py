"""Reading recorded accelerations, and refusing what is no even record.

A CSV file has a column of times and a column an axis; ``.npy`` holds the same as a matrix, and
``.npz`` the arrays ``time`` and ``acceleration`` and perhaps ``unit``. With ``step`` given there is
no column of times. Each axis has a unit, stated by argument or in the header, such as
``time [s], x [g], roll [rad/s^2]``; it is never guessed.
"""

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.errors import ParameterError, ShapeError, UnknownNameError
from ftcfa.vibration.record import Record
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

Unit = Literal["m/s^2", "g", "rad/s^2", "deg/s^2"]

SIZES = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "rad/s^2": 1.0, "deg/s^2": np.pi / 180.0}
"""Units of accelerations in m/s^2, of angular ones in rad/s^2."""
SQUARES = ("s2", "s²", "s**2")
"""How else s^2 may be written."""
JITTER = 0.02
"""Largest deviation of a time step from the mean that counts as rounding, relative to it."""
GAP = 1.5
"""A time step this many times the usual one is a gap."""


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
        unit: Of all axes, or one an axis; None reads them from the header.
        step: Sampling step where the file has no column of times [s].
        columns: Names of the header to read as axes, in this order; None reads all.
        jitter: Allowed deviation of a time step from the mean, relative to it.

    Returns:
        In m/s^2 and rad/s^2, as recorded.

    Raises:
        ParameterError: Naming file and row of a gap, an uneven step, a time that does not rise, a
            value that is no finite number; or if the file is empty or states no unit of an axis.
        ShapeError: If there is not a unit an axis.
        UnknownNameError: If the header has not all ``columns``, or a unit is none.
    """
    path = Path(file)
    table = _read(path, step is not None)
    headers = list(table.names)
    if step is None:
        if table.values.shape[1] < 2:
            raise ParameterError(
                str(path), "one column", "times and one axis or more", "give step if there are none"
            )
        _check_unit_of_time(path, headers[0])
        step = _step(path, table.values[:, 0], table.rows, jitter)
        axes, values = headers[1:], table.values[:, 1:]
    else:
        axes, values = headers, table.values
    if columns is not None:
        bare = [_split_unit(name)[0] for name in axes]
        for column in columns:
            if column not in bare:
                raise UnknownNameError(f"{path}: column", column, tuple(bare))
        chosen = [bare.index(column) for column in columns]
        axes, values = [axes[k] for k in chosen], values[:, chosen]
    names = tuple(_split_unit(header)[0] for header in axes)
    units = [_split_unit(header)[1] or table.unit for header in axes]
    if unit is not None:
        units = [unit] * len(axes) if isinstance(unit, str) else list(unit)
    if len(units) != len(axes):
        raise ShapeError(f"{path}: unit", f"{len(units)} units", f"one, or {len(axes)}")
    pairs = zip(names, units, strict=True)
    sizes = [_size(path, name, own) for name, own in pairs]
    return Record(step, values * sizes, names, (path.name,))


class _Table(NamedTuple):
    """Columns of a file, all finite."""

    values: Array  # (samples, columns)
    rows: npt.NDArray[np.intp]  # where each sample stands, counted from 1 (samples,)
    names: tuple[str, ...]
    unit: str  # of the whole file, or ""


def _read(path: Path, without_time: bool) -> _Table:
    readers = {".csv": _read_csv, ".txt": _read_csv, ".npy": _read_npy, ".npz": _read_npz}
    if path.suffix.lower() not in readers:
        raise UnknownNameError(f"{path}: kind of file", path.suffix, tuple(readers))
    try:
        table = readers[path.suffix.lower()](path, without_time)
    except OSError as error:
        raise ParameterError(str(path), error.strerror or str(error), "a readable file") from error
    if len(table.values) < 2:
        got = f"{len(table.values)} samples" if len(table.values) else "no samples"
        raise ParameterError(str(path), got, "two or more")
    bad = np.argwhere(~np.isfinite(table.values))
    if len(bad):
        sample, column = bad[0]
        raise ParameterError(
            f"{path}: row {table.rows[sample]}, column {column + 1}",
            f"{table.values[sample, column]}",
            "a finite number",
            "cut the record there or fill the gap knowingly",
        )
    return table


def _read_csv(path: Path, without_time: bool) -> _Table:
    """Commas, semicolons or tabs; an optional header; lines that begin with # are comments."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ParameterError(str(path), str(error), "a text in UTF-8") from error
    numbered = [(k, s) for k, s in enumerate(lines, 1) if s.strip() and not s.startswith("#")]
    if not numbered:
        raise ParameterError(str(path), "empty", "a header and rows of numbers")
    delimiter = max(",;\t", key=numbered[0][1].count)
    cells = list(csv.reader((line for _, line in numbered), delimiter=delimiter))
    width = len(cells[0])
    names = _default_names(width, without_time)
    if not all(_is_number(cell) for cell in cells[0]):
        names, numbered, cells = tuple(c.strip() for c in cells[0]), numbered[1:], cells[1:]
    values = np.empty((len(cells), width))
    for i, ((row, _), line) in enumerate(zip(numbered, cells, strict=True)):
        if len(line) != width:
            raise ParameterError(f"{path}: row {row}", f"{len(line)} columns", f"{width} columns")
        for j, cell in enumerate(line):
            if not _is_number(cell):
                subject = f"{path}: row {row}, column {j + 1} ({names[j]})"
                raise ParameterError(subject, repr(cell.strip()), "a number")
            values[i, j] = float(cell)
    return _Table(values, np.array([row for row, _ in numbered], dtype=np.intp), names, "")


def _read_npy(path: Path, without_time: bool) -> _Table:
    try:
        values = np.load(path, allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise ParameterError(str(path), str(error), "a NumPy array of numbers") from error
    return _table(path, values, without_time, "")


def _read_npz(path: Path, without_time: bool) -> _Table:
    needed = ("acceleration",) if without_time else ("time", "acceleration")
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except (ValueError, EOFError) as error:
        raise ParameterError(str(path), str(error), "NumPy arrays of numbers") from error
    for name in needed:
        if name not in arrays:
            raise ParameterError(
                str(path), f"arrays {sorted(arrays)}", f"arrays {' and '.join(needed)}"
            )
    parts = [arrays[name] for name in needed]
    parts = [part[:, None] if part.ndim == 1 else part for part in parts]
    if len({len(part) for part in parts}) > 1 or any(part.ndim != 2 for part in parts):
        shapes = ", ".join(str(part.shape) for part in parts)
        raise ParameterError(str(path), f"shapes {shapes}", "(samples,) and (samples, axes)")
    return _table(path, np.hstack(parts), without_time, str(arrays.get("unit", "")))


def _table(path: Path, values: Array, without_time: bool, unit: str) -> _Table:
    if values.dtype.kind not in "fiu":
        raise ParameterError(str(path), f"an array of {values.dtype}", "real numbers")
    if values.ndim == 1 and without_time:
        values = values[:, None]
    if values.ndim != 2 or values.size == 0:
        raise ParameterError(str(path), f"shape {values.shape}", "(samples, columns)")
    names = _default_names(values.shape[1], without_time)
    return _Table(values.astype(float), np.arange(1, len(values) + 1), names, unit)


def _default_names(width: int, without_time: bool) -> tuple[str, ...]:
    axes = "xyz" if width - (not without_time) == 3 else ""
    count = width - (not without_time)
    names = tuple(axes) if axes else tuple(f"axis {k + 1}" for k in range(count))
    return names if without_time else ("time", *names)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a header such as ``x [m/s^2]`` or ``x (g)``; "" without one."""
    match = re.fullmatch(r"(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*", name)
    return (match[1], match[2]) if match else (name, "")


def _check_unit_of_time(path: Path, name: str) -> None:
    unit = _split_unit(name)[1]
    if unit not in ("", "s"):
        raise ParameterError(f"{path}: column of times '{name}'", unit, "s", "give it in seconds")


def _size(path: Path, axis: str, unit: str) -> float:
    """A unit in m/s^2 or rad/s^2."""
    if not unit:
        raise ParameterError(
            f"{path}: unit of {axis}",
            "not stated",
            'unit="g" or unit="m/s^2", or a header such as "x [g]"',
        )
    usual = unit
    for square in SQUARES:
        usual = usual.replace(square, "s^2")
    if usual not in SIZES:
        raise UnknownNameError(f"{path}: unit of {axis}", unit, tuple(SIZES))
    return SIZES[usual]


def _step(path: Path, time: Array, rows: npt.NDArray[np.intp], jitter: float) -> float:
    """The sampling step of evenly rising times [s]."""
    positive("read_record jitter", jitter)
    steps = np.diff(time)
    usual = float(np.median(steps))
    back = np.flatnonzero(steps <= 0)
    if back.size:
        k = back[0]
        raise ParameterError(
            f"{path}: row {rows[k + 1]}",
            f"time {time[k + 1]:.9g} s after {time[k]:.9g} s",
            "times that rise",
            "sort the record",
        )
    gaps = np.flatnonzero(steps > GAP * usual)
    if gaps.size:
        k = gaps[0]
        raise ParameterError(
            f"{path}: row {rows[k + 1]}",
            f"a gap of {steps[k]:.4g} s before it, where steps are {usual:.4g} s",
            "even time steps",
            "cut the record there or fill the gap knowingly",
        )
    step = float((time[-1] - time[0]) / (len(time) - 1))
    uneven = np.flatnonzero(np.abs(steps / step - 1.0) > jitter)
    if uneven.size:
        k = uneven[0]
        raise ParameterError(
            f"{path}: row {rows[k + 1]}",
            f"a time step of {steps[k]:.6g} s, where the mean is {step:.6g} s",
            f"even time steps to {100 * jitter:g} %",
            "interpolate the record to even steps, or give jitter= if the times are rounded",
        )
    return step
