"""The times of a record: their unit, which is never guessed, and whether they are even."""

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from ftcfa.arrays import Array
from ftcfa.checks import known_name, positive
from ftcfa.errors import ParameterError
from ftcfa.vibration.records.columns import Columns
from ftcfa.vibration.records.text_table import DATE

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Units of time in seconds."""
SPELLINGS = {"sec": "s", "msec": "ms", "µs": "us", "usec": "us"}
"""Other ways to write them."""
JITTER = 0.02
"""Largest relative deviation of a time step from the mean step that counts as rounding."""
GAP = 1.5
"""A time step this many times the median step is a gap."""
ROUNDED = 1.2
"""Spread of times about an even grid, in units of their last digit, that rounding can cause."""
STRETCHES, SHORTEST = 64, 16
"""Largest number of stretches of a record, and their smallest length, that may be rounded alike."""
SLACK = 1e-3
"""Distance from a whole number, in the last digit, that floating point makes."""
DIGITS = 12
"""Decimals of a time that are looked at."""
_NAME = re.compile(r"(time|t|timestamp|times|epoch|date ?time|seconds?)(?:[ _.-]*(s|ms|us|µs|ns))?")


def time_column(columns: Columns) -> int | None:
    """Number of the column of times, by its name or its dates; None if there is none."""
    for k, name in enumerate(columns.names):
        if _NAME.fullmatch(name.lower()):
            return k
    for k, column in enumerate(columns.data):
        if column.dtype.kind == "O" and DATE.fullmatch(str(column[0]).strip()):
            return k
    return None


def seconds(columns: Columns, k: int, unit: str | None) -> Array:
    """Times of a column since its first one, shape (samples,) [s].

    Args:
        columns: The file's columns.
        k: Number of the column.
        unit: Unit that the user gave, where the file states none.

    Raises:
        ParameterError: If the unit is not stated, or stated twice, or a time is none.
    """
    column, subject = columns.data[k], f"{columns.path}: column of times '{columns.names[k]}'"
    if column.dtype.kind == "O" and DATE.fullmatch(str(column[0]).strip()):
        return _dates(columns, k)
    stated = _stated_unit(columns.names[k], columns.units[k])
    if not stated and unit is None:
        remedy = 'write it in the header, such as "time [ms]", or give time_unit="ms"'
        raise ParameterError(subject, "no unit", "s, ms, us or ns", remedy)
    if stated and unit is not None and stated != unit:
        raise ParameterError(subject, f"unit {stated}", f"time_unit {unit}", "leave time_unit out")
    known_name(f"{subject} unit", stated or unit, TIME_UNITS)
    if column.dtype.kind not in "iu":  # whole numbers keep all digits of an epoch
        column = columns.numbers(k)
    since: Array = (column - column[0]).astype(float)
    return since * TIME_UNITS[stated or str(unit)]


def agrees_with(
    step: float, columns: Columns, k: int, time_unit: str | None, jitter: float
) -> None:
    """Raise ParameterError if the mean step of the times contradicts the one that the user gave.

    Times without a unit state no step.
    """
    dates = columns.data[k].dtype.kind == "O"
    if not (dates or time_unit or _stated_unit(columns.names[k], columns.units[k])):
        return
    time = seconds(columns, k, time_unit)
    own = float((time[-1] - time[0]) / max(1, len(time) - 1))
    if abs(own / step - 1.0) > jitter:
        subject = f"{columns.path}: column of times '{columns.names[k]}'"
        got, expected = f"steps of {own:.6g} s on average", f"steps of {step:.6g} s, as given"
        remedy = "leave step and rate out, or correct the file"
        raise ParameterError(subject, got, expected, remedy)


def _stated_unit(name: str, unit: str) -> str:
    """Unit of times by their header, such as ``t [ms]``, ``time_ms`` or ``seconds``; "" if none."""
    match = _NAME.fullmatch(name.lower())
    if not unit and match:
        unit = match[2] or ("s" if match[1].startswith("second") else "")
    return SPELLINGS.get(unit, unit)


def _dates(columns: Columns, k: int) -> Array:
    """Seconds since the first of a column of ISO 8601 times."""
    texts = [str(text).strip() for text in columns.data[k]]
    for row, text in zip(columns.rows, texts, strict=True):
        if not DATE.fullmatch(text):
            subject = f"{columns.path}: row {row}, column {k + 1}"
            raise ParameterError(subject, repr(text), "a time of ISO 8601, as in the first row")
    try:
        nanoseconds = pd.to_datetime(texts, format="ISO8601", utc=True).as_unit("ns").asi8
    except Exception as error:
        raise ParameterError(f"{columns.path}: column {k + 1}", str(error), "ISO 8601") from error
    return np.asarray((nanoseconds - nanoseconds[0]) * 1e-9)


def even_step(
    path: Path, time: Array, rows: npt.NDArray[np.intp], jitter: float
) -> tuple[float, str]:
    """Sampling step of even times [s], and a note where they are even but for their rounding.

    Raises:
        ParameterError: Naming the row of a time that does not rise, a gap or an uneven step.
    """
    positive("read_record jitter", jitter)
    rising(path, time, rows)
    steps = np.diff(time)
    step = float((time[-1] - time[0]) / (len(time) - 1))
    if np.all(np.abs(steps / step - 1.0) <= jitter):
        return step, ""
    digit = _last_digit(time)
    number = np.arange(len(time))
    slope, start = np.polyfit(number, time, 1)
    if digit <= step and np.ptp(time - (start + slope * number)) <= ROUNDED * digit:
        step = float(slope)
        return step, f"times rounded to {digit:g} s, read as even steps of {step:.6g} s"
    usual, even = float(np.median(steps)), "even time steps"

    def error(k: int, got: str, expected: str, remedy: str) -> ParameterError:
        return ParameterError(f"{path}: row {rows[k + 1]}", got, expected, remedy)

    gaps = np.flatnonzero(steps > GAP * usual)
    if gaps.size:
        got = f"a gap of {steps[gaps[0]]:.4g} s before it, where steps are {usual:.4g} s"
        remedy = "cut the record there or fill the gap (resample=RATE interpolates)"
        raise error(gaps[0], got, even, remedy)
    uneven = int(np.argmax(np.abs(steps / step - 1.0) > jitter))
    got = f"a time step of {steps[uneven]:.6g} s, where the mean is {step:.6g} s"
    remedy = "give resample=RATE to interpolate, or jitter= if the times are rounded"
    raise error(uneven, got, f"{even} to {100 * jitter:g} %", remedy)


def rising(path: Path, time: Array, rows: npt.NDArray[np.intp]) -> None:
    """Raise ParameterError unless times rise."""
    falls = np.flatnonzero(np.diff(time) <= 0)
    if falls.size:
        k = falls[0]
        got = f"time {time[k + 1]:.9g} s after {time[k]:.9g} s"
        raise ParameterError(
            f"{path}: row {rows[k + 1]}", got, "times that rise", "sort the record"
        )


def _last_digit(time: Array) -> float:
    """The coarsest digit to which some stretch of the times is rounded [s]; 0 if there is none.

    Seven significant digits, say, are finer at 9 s than at 100 s.
    """
    stretches = np.array_split(time, max(1, min(STRETCHES, len(time) // SHORTEST)))
    return max(map(_digit, stretches))


def _digit(time: Array) -> float:
    """The power of ten of which all times are multiples [s]; 0 if there is none."""
    for digits in range(DIGITS):
        scaled = time * 10.0**digits
        if np.all(np.abs(scaled - np.round(scaled)) <= SLACK):
            return float(10.0**-digits)
    return 0.0
