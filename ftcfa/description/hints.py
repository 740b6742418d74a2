"""Type hints of a part's keys: which data fits them, and how messages name them."""

import os
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import is_dataclass
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from ftcfa.description.registry import PARTS


class Kind(NamedTuple):
    """What a type reads."""

    name: str
    """Name in messages."""
    data: tuple[type, ...]
    """Types of plain data that it takes."""


TABLE = Kind("a table", (dict,))
TEXT = Kind("a text", (str,))
ARRAY = Kind("an array", (list,))
KINDS: Mapping[Any, Kind] = {
    bool: Kind("true or false", (bool,)),
    int: Kind("an integer", (int,)),
    float: Kind("a number", (float, int)),
    str: TEXT,
    Path: TEXT,
    os.PathLike: TEXT,
    np.ndarray: Kind("numbers", (float, int, list)),
    npt.ArrayLike: Kind("numbers", (float, int, list, str)),
    Sequence[str]: Kind("a text or an array", (str, list)),
    tuple: ARRAY,
    list: ARRAY,
    Sequence: ARRAY,
    Iterable: ARRAY,
    dict: TABLE,
    Mapping: TABLE,
}
"""Types, and origins of types, that data fits."""


def kind(one: Any) -> Kind:
    """What a type reads: nothing, if no data fits it."""
    if choices(one):
        return TABLE
    if get_origin(one) is Literal:
        return Kind(one_of(get_args(one)), (str,))
    return KINDS.get(one) or KINDS.get(get_origin(one)) or Kind("", ())


def unchecked(hint: Any) -> Any:
    """A hint without the check that it declares."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


@cache
def alternatives(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows, without None; `numpy.typing.ArrayLike` is one of them.

    A text that may be the path of a file is a path: str comes last.
    """
    hint = unchecked(hint)
    if get_origin(hint) not in (Union, types.UnionType):
        return (hint,)
    allowed = [one for one in get_args(hint) if one is not types.NoneType]
    array = get_args(npt.ArrayLike)
    if set(array) <= set(allowed):
        return (*(one for one in allowed if one not in array), npt.ArrayLike)
    return tuple(sorted(allowed, key=lambda one: one is str))


@cache
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


def expected(hint: Any) -> str:
    """A hint in words."""
    return " or ".join(dict.fromkeys(filter(None, (kind(one).name for one in alternatives(hint)))))


def one_of(known: Iterable[Any]) -> str:
    """The known names as what is expected."""
    return f"one of: {', '.join(map(str, known))}"


@cache
def hints_of(make: Callable[..., Any]) -> dict[str, Any]:
    """The type hints of a class or function, by name."""
    return get_type_hints(make, include_extras=True)


@cache
def arguments(make: Callable[..., Any]) -> dict[str, Any]:
    """The hints of the arguments of a class or function that data can give, by name."""
    hints = {name: hints_of(make)[name] for name in signature(make).parameters}
    return {name: hint for name, hint in hints.items() if expected(hint)}
