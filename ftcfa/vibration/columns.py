"""Columns of numbers from a file, such as a record's times and axes.

A CSV file has a column for each quantity. A ``.npy`` file holds the same as a matrix, a ``.npz``
file the arrays ``time`` and ``acceleration`` and optionally ``unit``.
"""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, UnknownNameError


class Columns(NamedTuple):
    """Columns of a file, all values finite."""

    values: Array  # (samples, columns)
    rows: npt.NDArray[np.intp]  # row of each sample in the file, counted from 1 (samples,)
    names: tuple[str, ...]
    unit: str  # of the whole file, or ""
    header: bool = False  # whether the names are those of the file


def read_columns(path: Path, times: bool) -> Columns:
    """Read a file's columns.

    Args:
        path: ``.csv``, ``.txt``, ``.npy`` or ``.npz``.
        times: Whether the first column holds times.

    Raises:
        ParameterError: Naming the file, and the row of a value that is no finite number.
        UnknownNameError: If the kind of file is none of these.
    """
    readers = {".csv": _read_csv, ".txt": _read_csv, ".npy": _read_npy, ".npz": _read_npz}
    if path.suffix.lower() not in readers:
        raise UnknownNameError(f"{path}: kind of file", path.suffix, readers)
    return _checked(path, readers[path.suffix.lower()], times)


def read_csv(path: Path, times: bool) -> Columns:
    """Read the columns of a text file, whatever its name ends with; see `read_columns`."""
    return _checked(path, _read_csv, times)


def _checked(path: Path, read: Callable[[Path, bool], Columns], times: bool) -> Columns:
    try:
        table = read(path, times)
    except OSError as error:
        raise ParameterError(str(path), error.strerror or str(error), "a readable file") from error
    if len(table.values) < 2:
        got = f"{len(table.values)} samples" if len(table.values) else "no samples"
        raise ParameterError(str(path), got, "two or more")
    bad = np.argwhere(~np.isfinite(table.values))
    if len(bad):
        sample, column = bad[0]
        subject = f"{path}: row {table.rows[sample]}, column {column + 1}"
        got, remedy = f"{table.values[sample, column]}", "cut the record there or fill the gap"
        raise ParameterError(subject, got, "a finite number", remedy)
    return table


def _read_csv(path: Path, times: bool) -> Columns:
    """Commas, semicolons or tabs; an optional header; what follows a # is a comment."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ParameterError(str(path), str(error), "a text in UTF-8") from error
    uncommented = enumerate((line.split("#")[0] for line in lines), 1)
    numbered = [(k, line) for k, line in uncommented if line.strip()]
    if not numbered:
        raise ParameterError(str(path), "empty", "a header and rows of numbers")
    delimiter = max(",;\t", key=numbered[0][1].count)
    cells = list(csv.reader((line for _, line in numbered), delimiter=delimiter))
    width = len(cells[0])
    names, header = _default_names(width, times), False
    if not _reads_as_number(cells[0][0]):
        header = True
        names, numbered, cells = tuple(c.strip() for c in cells[0]), numbered[1:], cells[1:]
    values = np.empty((len(cells), width))
    for i, ((row, _), line) in enumerate(zip(numbered, cells, strict=True)):
        if len(line) != width:
            raise ParameterError(f"{path}: row {row}", f"{len(line)} columns", f"{width} columns")
        for j, cell in enumerate(line):
            if not _reads_as_number(cell):
                subject = f"{path}: row {row}, column {j + 1} ({names[j]})"
                raise ParameterError(subject, repr(cell.strip()), "a number")
            values[i, j] = float(cell)
    rows = np.array([row for row, _ in numbered], dtype=np.intp)
    return Columns(values, rows, names, "", header)


def _read_npy(path: Path, times: bool) -> Columns:
    try:
        values = np.load(path, allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise ParameterError(str(path), str(error), "a NumPy array of numbers") from error
    return _columns(path, values, times, "")


def _read_npz(path: Path, times: bool) -> Columns:
    needed = ("time", "acceleration") if times else ("acceleration",)
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except (ValueError, EOFError) as error:
        raise ParameterError(str(path), str(error), "NumPy arrays of numbers") from error
    if not set(needed) <= arrays.keys():
        expected = f"arrays {' and '.join(needed)}"
        raise ParameterError(str(path), f"arrays {sorted(arrays)}", expected)
    parts = [arrays[name] for name in needed]
    parts = [part[:, None] if part.ndim == 1 else part for part in parts]
    if len({len(part) for part in parts}) > 1 or any(part.ndim != 2 for part in parts):
        shapes = ", ".join(str(part.shape) for part in parts)
        raise ParameterError(str(path), f"shapes {shapes}", "(samples,) and (samples, axes)")
    return _columns(path, np.hstack(parts), times, str(arrays.get("unit", "")))


def _columns(path: Path, values: Array, times: bool, unit: str) -> Columns:
    if values.dtype.kind not in "fiu":
        raise ParameterError(str(path), f"an array of {values.dtype}", "real numbers")
    if values.ndim == 1 and not times:
        values = values[:, None]
    if values.ndim != 2 or values.size == 0:
        raise ParameterError(str(path), f"shape {values.shape}", "(samples, columns)")
    names = _default_names(values.shape[1], times)
    return Columns(values.astype(float), np.arange(1, len(values) + 1), names, unit)


def _default_names(width: int, times: bool) -> tuple[str, ...]:
    """Names of columns without a header."""
    count = width - times
    axes = tuple("xyz") if count == 3 else tuple(f"axis {k + 1}" for k in range(count))
    return ("time", *axes) if times else axes


def _reads_as_number(cell: str) -> bool:
    """Whether a text is a number, such as "1e-3" or "nan"."""
    try:
        float(cell)
    except ValueError:
        return False
    return True
