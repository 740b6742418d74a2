"""Which data fits which type hint, and how messages put either into words."""

import difflib
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import numpy as np
import numpy.typing as npt

from ftcfa.description.registry import choices

MAX_SHOWN = 60
"""Characters of a wrong value that a message shows."""
HOME = "home"
"""Stands for the arm's home posture wherever numbers, one a joint, are expected."""
EXPECTED: Mapping[Any, str] = {
    bool: "true or false",
    float: "a number",
    int: "an integer",
    str: "a text",
    np.ndarray: "numbers",
    npt.ArrayLike: "numbers",
}


def fits(one: Any, told: Any) -> bool:
    """Whether a type takes data of this kind."""
    origin = get_origin(one)
    if isinstance(told, dict):
        return bool(choices(one)) or origin in (dict, Mapping)
    if isinstance(told, list):
        return one is npt.ArrayLike or origin in (np.ndarray, tuple, list, Sequence, Iterable)
    if isinstance(told, str):
        text = origin in (Sequence, Iterable) and get_args(one) == (str,)
        return one in (str, npt.ArrayLike) or origin is Literal or text or is_path(one)
    if is_number(told):
        floats = one is float or one is npt.ArrayLike or origin is np.ndarray
        return floats or (one is int and type(told) is int)
    return one is bool and isinstance(told, bool)


def is_number(told: Any) -> bool:
    """Whether data is a number of a float's range; true and false are none."""
    return type(told) is float or (type(told) is int and abs(told) <= sys.float_info.max)


def reads_as_number(text: str) -> bool:
    """Whether NumPy would take a text for a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def is_path(one: Any) -> bool:
    """Whether a type is that of a path."""
    return one is Path or get_origin(one) is os.PathLike


def expected(one: Any) -> str:
    """A type in words; nothing where a path goes as a text."""
    if choices(one) or get_origin(one) in (dict, Mapping):
        return "a table"
    if get_origin(one) in (tuple, list, Sequence, Iterable):
        return "a text or an array" if get_args(one) == (str,) else "an array"
    if get_origin(one) is Literal:
        return one_of(get_args(one))
    return EXPECTED.get(one) or EXPECTED.get(get_origin(one), "")


def shown(told: Any) -> str:
    """A wrong value in a message."""
    if isinstance(told, dict):
        return "a table"
    if isinstance(told, bool):
        return str(told).lower()
    text = repr(told)
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 3]}..."


def one_of(known: Iterable[Any]) -> str:
    """What would have been right."""
    return f"one of: {', '.join(map(str, known))}"


def did_you_mean(name: Any, known: Iterable[str]) -> str:
    """The nearest of the known names, as a remedy; nothing if none is near."""
    near = difflib.get_close_matches(str(name), map(str, known), n=1)
    return f"did you mean '{near[0]}'?" if near else ""
