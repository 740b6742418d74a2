"""Delays of whole integration steps, and the other small blocks that sensors and motors share."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Traceable, is_known, is_off
from ftcfa.checks import numbers
from ftcfa.errors import ParameterError

Line = tuple[Traceable, ...]
"""The last values of a signal, the newest first: its values one, two, ... steps ago."""
ROUNDING = 1e-9
"""Distance from a whole number of steps that is rounding, relative."""


def whole_steps(subject: str, times: npt.ArrayLike, step: float) -> None:
    """Raise ParameterError unless times [s] are whole numbers of steps [s]."""
    for time in np.ravel(numbers(subject, times)):
        below = float(np.floor(time / step + ROUNDING))
        if abs(time / step - round(time / step)) > ROUNDING * max(1.0, float(time) / step):
            nearest = f"{below * step:.6g} or {(below + 1) * step:.6g} s"
            got, remedy = f"{time:.6g} s", f"take {nearest}, or other substeps"
            raise ParameterError(subject, got, f"whole integration steps of {step:.6g} s", remedy)


def steps_in(time: float, step: float) -> int:
    """Number of steps in a time, both in seconds."""
    return round(time / step)


def filled(value: Traceable, time: float, step: float) -> Line:
    """A line that reaches back a time [s], with the same value everywhere."""
    return (value,) * steps_in(time, step)


def pushed(line: Line, now: Traceable) -> Line:
    """The line one step later."""
    return (now, *line)[: len(line)]


def delayed(line: Line, now: Traceable, time: Any, step: float) -> Traceable:
    """The value of a signal some time ago [s], a number or a symbol, rounded to whole steps."""
    values = (now, *line)
    if is_known(time):
        return values[steps_in(time, step)]
    value = now
    for age, older in enumerate(line, 1):
        value = np.where(time > (age - 0.5) * step, older, value)
    return value


def quantised(x: Traceable, resolution: Any) -> Traceable:
    """The nearest multiple of a resolution, component by component; x where that is zero."""
    if is_off(resolution):
        return x
    size = np.where(resolution > 0, resolution, 1.0)
    return np.where(resolution > 0, size * np.floor(x / size + 0.5), x)
