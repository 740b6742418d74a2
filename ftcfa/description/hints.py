"""Type hints of a part's fields: which data fits them, and how messages name them."""

import os
import sys
import types
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import is_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
import numpy.typing as npt

from ftcfa.description.registry import PARTS

NAMES: Mapping[Any, str] = {
    bool: "true or false",
    float: "a number",
    int: "an integer",
    str: "a text",
    np.ndarray: "numbers",
    npt.ArrayLike: "numbers",
}


def alternatives(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows, without None; `numpy.typing.ArrayLike` is one, and the last."""
    if get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if get_origin(hint) not in (Union, types.UnionType):
        return (hint,)
    allowed = [one for one in get_args(hint) if one is not types.NoneType]
    array = get_args(npt.ArrayLike)
    if set(array) <= set(allowed):
        return (*(one for one in allowed if one not in array), npt.ArrayLike)
    return tuple(allowed)


def choices(hint: Any) -> tuple[type, ...]:
    """The parts that a hint allows."""
    parts: list[type] = []
    for one in alternatives(hint):
        if one in PARTS:
            parts.extend(PARTS[one])
        elif isinstance(one, type) and is_dataclass(one):
            parts.append(one)
    return tuple(parts)


def element(hint: Any) -> Any:
    """The hint of an entry of a sequence or mapping, None if the hint allows neither."""
    for one in alternatives(hint):
        if get_origin(one) in (tuple, list, Sequence, Iterable):
            return get_args(one)[0]
        if get_origin(one) in (dict, Mapping):
            return get_args(one)[1]
    return None


def fits(one: Any, data: Any) -> bool:
    """Whether a type takes data of this kind."""
    origin = get_origin(one)
    if isinstance(data, dict):
        return bool(choices(one)) or origin in (dict, Mapping)
    if isinstance(data, list):
        return one is npt.ArrayLike or origin in (np.ndarray, tuple, list, Sequence, Iterable)
    if isinstance(data, str):
        text = origin in (Sequence, Iterable) and get_args(one) == (str,)
        return one in (str, npt.ArrayLike) or origin is Literal or text or is_path(one)
    if is_number(data):
        floats = one is float or one is npt.ArrayLike or origin is np.ndarray
        return floats or (one is int and type(data) is int)
    return one is bool and isinstance(data, bool)


def is_number(data: Any) -> bool:
    """Whether data is a number that a float can hold; true and false are not."""
    return type(data) is float or (type(data) is int and abs(data) <= sys.float_info.max)


def is_path(one: Any) -> bool:
    """Whether a type is that of a path."""
    return one is Path or get_origin(one) is os.PathLike


def expected(hint: Any) -> str:
    """A hint in words."""
    allowed = sorted(alternatives(hint), key=is_path, reverse=True)
    return " or ".join(dict.fromkeys(filter(None, map(_name, allowed))))


def _name(one: Any) -> str:
    """A type in words; nothing for a path, which is a text."""
    if choices(one) or get_origin(one) in (dict, Mapping):
        return "a table"
    if get_origin(one) in (tuple, list, Sequence, Iterable):
        return "a text or an array" if get_args(one) == (str,) else "an array"
    if get_origin(one) is Literal:
        return f"one of: {', '.join(get_args(one))}"
    return NAMES.get(one) or NAMES.get(get_origin(one), "")
