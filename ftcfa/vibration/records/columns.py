"""Columns of a file, each read when it is asked for."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.vibration.records.array_file import read_npy, read_npz
from ftcfa.vibration.records.text_table import NUMBER, TextTable, read_text

LONGEST = 40
"""Characters of a wrong cell that a message shows."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of a file: text in which numbers are looked for when they are asked for.

    Attributes:
        path: The file.
        names: Names, without units.
        units: Units as the file states them; "" where it states none.
        data: Arrays of numbers or of texts, shape (samples,) each.
        rows: Row of each sample in the file, counted from 1, shape (samples,).
        header: Whether the names are those of the file.
        notes: What was decided in reading it.
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    data: tuple[npt.NDArray[Any], ...]
    rows: npt.NDArray[np.intp]
    header: bool = False
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def numbers(self, k: int) -> Array:
        """Column k, shape (samples,).

        Raises:
            ParameterError: Naming the row of a value that is no finite number.
        """
        column = self.data[k]
        if column.dtype.kind not in "fiu":
            for i, text in enumerate(column):
                if not NUMBER.fullmatch(cell := str(text).strip()):
                    raise self._error(i, k, repr(cell[:LONGEST]), "a number")
            column = np.array([float(str(text)) for text in column])
        values = column.astype(float)
        if not np.isfinite(values).all():
            bad = int(np.argmin(np.isfinite(values)))
            remedy = "cut the record there or fill the gap"
            raise self._error(bad, k, f"{values[bad]}", "a finite number", remedy)
        return values

    def _error(
        self, sample: int, k: int, got: str, expected: str, remedy: str = ""
    ) -> ParameterError:
        name = f" ({self.names[k]})" if self.header else ""
        subject = f"{self.path}: row {self.rows[sample]}, column {k + 1}{name}"
        return ParameterError(subject, got, expected, remedy)


def read_columns(path: Path, skip: int = 0) -> Columns:
    """Read a file's columns.

    Args:
        path: ``.csv``, ``.tsv``, ``.txt``, ``.npy`` or ``.npz``.
        skip: Number of lines at the start that are left out.

    Raises:
        ParameterError: Naming the file, and the row that is wrong.
        UnknownNameError: If the kind of file is none of these.
    """
    readers: dict[str, Callable[[], Columns]] = {
        **dict.fromkeys((".csv", ".tsv", ".txt"), lambda: read_text_columns(path, skip)),
        ".npy": lambda: _of_arrays(path, *read_npy(path)),
        ".npz": lambda: _of_arrays(path, *read_npz(path)),
    }
    if path.suffix.lower() not in readers:
        raise UnknownNameError(f"{path}: kind of file", path.suffix, readers)
    return _long_enough(readers[path.suffix.lower()]())


def read_text_columns(path: Path, skip: int = 0) -> Columns:
    """Columns of a text, whatever its name ends with; see `read_columns`."""
    return _long_enough(_of_text(path, read_text(path, skip)))


def _of_text(path: Path, table: TextTable) -> Columns:
    named = [split_unit(name) for name in table.header or ()]
    names = tuple(name for name, _ in named) or default_names(len(table.columns))
    units = tuple(unit for _, unit in named) or ("",) * len(names)
    if table.units:
        units = tuple(a or b for a, b in zip(units, table.units, strict=True))
    return Columns(path, names, units, table.columns, table.rows, bool(table.header), table.notes)


def _of_arrays(path: Path, values: Array, timed: bool, unit: str) -> Columns:
    rows, axes = np.arange(1, len(values) + 1), default_names(values.shape[1] - timed)
    names = ("time", *axes) if timed else axes
    units = tuple("s" if name == "time" else unit for name in names)
    return Columns(path, names, units, tuple(values.T), rows, header=False)


def _long_enough(table: Columns) -> Columns:
    if len(table) < 2:
        got = f"{len(table)} samples" if len(table) else "no samples"
        raise ParameterError(str(table.path), got, "two or more")
    return table


def default_names(width: int) -> tuple[str, ...]:
    """Names of columns without a header."""
    return tuple("xyz") if width == 3 else tuple(f"axis {k + 1}" for k in range(width))


def split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a header such as ``x [m/s^2]`` or ``x (g)``; "" without one."""
    name = " ".join(name.split())
    match = re.fullmatch(r"(.*?)\s*(?:\[(.*)\]|\((.*)\))", name)
    return (match[1], (match[2] or match[3] or "").strip()) if match else (name, "")
