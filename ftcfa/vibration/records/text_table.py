"""Tables in texts as loggers and spreadsheets write them, read with pandas.

Columns are parted by commas, semicolons, tabs or blanks; with the last three, a comma may be the
decimal sign. Comments begin with #, % or //. A header, and a row of units below it, may stand above
the numbers.
"""

import csv
import io
import re
import warnings
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from ftcfa.errors import ParameterError
from ftcfa.files import decoded, read_bounded

LOOKED_AT = 20
"""Number of lines from which the kind of table is told."""
QUOTED = 10
"""Largest number of lines of a header with line breaks in quotes."""
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[+-]?inf|nan", re.ASCII | re.IGNORECASE)
"""What every reader takes for a number."""
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
DATE = re.compile(r"\d{4}-?\d{2}-?\d{2}([T ]\d{2}.*)?", re.ASCII)
"""A time of ISO 8601."""


class TextTable(NamedTuple):
    """A table of a text."""

    header: tuple[str, ...] | None
    units: tuple[str, ...] | None
    columns: tuple[npt.NDArray[Any], ...]  # numbers, or texts where one of them is no number
    rows: npt.NDArray[np.intp]  # row of each sample in the file, counted from 1
    notes: tuple[str, ...]


def read_text(path: Path, skip: int = 0) -> TextTable:
    """Read a table without its first lines.

    Raises:
        ParameterError: If the file cannot be read, is empty, or has rows of different lengths.
    """
    text, odd = decoded(read_bounded(path))
    notes = () if odd is None else ("read as Latin-1",)
    numbered = _content(text, skip)
    if not numbered:
        raise ParameterError(str(path), "empty", "a header and rows of numbers")
    separator, decimal = _kind([line for _, line in islice(numbered, LOOKED_AT)])
    header, numbered = _header(numbered, separator, decimal)
    if header is not None and _column_numbers(header):
        got = f"the first row is {', '.join(header)}"
        remedy = "give skip=1 if these are numbers of columns, or name the columns"
        raise ParameterError(str(path), got, "a header or a sample", remedy)
    units = None
    if header is not None and numbered:
        cells = _cells(numbered[0][1], separator)
        if len(cells) == len(header) and not any(_is_value(cell, decimal) for cell in cells):
            units, numbered = tuple(cell.strip(" []()") for cell in cells), numbered[1:]
    width = len(header) if header else len(_cells(numbered[0][1], separator))
    rows = np.array([row for row, _ in numbered], dtype=np.intp)
    frame = _frame(path, [line for _, line in numbered], rows, width, separator, decimal)
    columns = tuple(frame[k].to_numpy() for k in range(width))
    return TextTable(header, units, columns, rows, notes)


def _content(text: str, skip: int) -> list[tuple[int, str]]:
    """Row and text of each line that is not blank and no comment, a quoted line break undone."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if "#" in text:
        lines = [line.split("#", 1)[0] for line in lines]
    numbered = [
        (row, line)
        for row, line in enumerate(lines[skip:], skip + 1)
        if line.strip() and not line.lstrip().startswith(("%", "//"))
    ]
    if numbered and numbered[0][1].count('"') % 2:
        for count in range(2, min(QUOTED, len(numbered)) + 1):
            joined = " ".join(line for _, line in numbered[:count])
            if joined.count('"') % 2 == 0:
                return [(numbered[0][0], joined), *numbered[count:]]
    return numbered


def _kind(lines: list[str]) -> tuple[str, str]:
    """The separator, "" for blanks, and the decimal sign of a table, by its last looked-at line."""
    last = lines[-1]
    words = last.split()
    if len(words) > 1 and all(map(_DECIMAL_COMMA.fullmatch, words)):
        return ("\t" if "\t" in last else ""), ","
    for separator in (";", "\t"):
        if separator in last:
            cells = [cell.strip() for line in lines for cell in line.split(separator)]
            return separator, "," if any(map(_DECIMAL_COMMA.fullmatch, cells)) else "."
    return ("," if "," in last or len(words) == 1 else ""), "."


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line, quotes undone."""
    if not separator:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _header(
    numbered: list[tuple[int, str]], separator: str, decimal: str
) -> tuple[tuple[str, ...] | None, list[tuple[int, str]]]:
    """The names in the first line, if there are, and the lines below."""
    cells = _cells(numbered[0][1], separator)
    if _is_value(cells[0], decimal) and not _column_numbers(cells):
        return None, numbered
    return tuple(cells), numbered[1:]


def _is_value(cell: str, decimal: str) -> bool:
    return bool(NUMBER.fullmatch(cell.replace(decimal, ".")) or DATE.fullmatch(cell))


def _column_numbers(cells: "list[str] | tuple[str, ...]") -> bool:
    """Whether cells are 0, 1, 2, ..., which pandas writes above columns without names."""
    return len(cells) > 1 and list(cells) == [str(k) for k in range(len(cells))]


def _frame(
    path: Path,
    lines: list[str],
    rows: npt.NDArray[np.intp],
    width: int,
    separator: str,
    decimal: str,
) -> pd.DataFrame:
    """The lines as a frame with the columns 0, 1, ..."""
    for line, row in zip(lines[:LOOKED_AT], rows, strict=False):
        _check_width(path, line, row, width, separator)
    options: dict[str, Any] = {"sep": separator or r"\s+", "decimal": decimal, "header": None}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of columns of mixed types
            frame = pd.read_csv(
                io.StringIO("\n".join(lines)), names=range(width), index_col=False,
                skipinitialspace=True, keep_default_na=False, na_values=[""],
                skip_blank_lines=False, float_precision="round_trip", low_memory=False, **options,
            )  # fmt: skip
    except Exception as error:  # the parser's own, of encodings, of memory
        for line, row in zip(lines, rows, strict=True):
            _check_width(path, line, row, width, separator)
        raise ParameterError(str(path), f"no table ({error})", "rows of numbers") from error
    if len(frame) != len(lines):
        raise ParameterError(str(path), "an open quote", "rows of numbers", "close it")
    empty = np.flatnonzero(frame.isna().any(axis=1).to_numpy())
    for k in empty[:1]:
        _check_width(path, lines[k], rows[k], width, separator)
    return frame


def _check_width(path: Path, line: str, row: int, width: int, separator: str) -> None:
    """Raise ParameterError unless a line has so many cells; one empty cell may follow them."""
    count = len(_cells(line, separator))
    if count != width and not (count == width + 1 and line.rstrip().endswith(separator or " ")):
        raise ParameterError(f"{path}: row {row}", f"{count} columns", f"{width} columns")
