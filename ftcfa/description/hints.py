"""Type hints of a part's arguments: which data fits them, and how messages name them."""

import os
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import is_dataclass
from functools import cache
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from ftcfa.description.registry import PARTS
from ftcfa.errors import one_of

TABLE, TEXT, ARRAY = ("a table", (dict,)), ("a text", (str,)), ("an array", (list,))
NUMBERS = ("numbers", (float, int, list))
KINDS: Mapping[Any, tuple[str, tuple[type, ...]]] = {
    bool: ("true or false", (bool,)),
    int: ("an integer", (int,)),
    float: ("a number", (float, int)),
    str: TEXT,
    Path: TEXT,
    os.PathLike: TEXT,
    np.ndarray: NUMBERS,
    npt.ArrayLike: NUMBERS,
    tuple: ARRAY,
    Sequence: ARRAY,
    Iterable: ARRAY,
    Mapping: TABLE,
}
"""Types, or their origins: how messages name them, and the types of plain data that fit them."""


def kind(one: Any) -> tuple[str, tuple[type, ...]]:
    """The name of a type and the data that fits it: none, if only a program can make it."""
    if choices(one):
        return TABLE
    if get_origin(one) is Literal:
        words = get_args(one)
        return one_of(words) if len(words) > 1 else f'"{words[0]}"', (str,)
    return KINDS.get(one) or KINDS.get(get_origin(one)) or ("", ())


def checked(hint: Any) -> tuple[Any, Any]:
    """A type, and the `Check` that is declared with it or None."""
    return get_args(hint) if get_origin(hint) is Annotated else (hint, None)


@cache
def alternatives(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows, without None; `numpy.typing.ArrayLike` is one of them.

    A text that may be the path of a file is a path: str comes last.
    """
    hint, _ = checked(hint)
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
    """The hint of an entry of the sequence or mapping that a hint allows, or None."""
    for one in alternatives(hint):
        if kind(one) in (ARRAY, TABLE) and get_args(one):
            return get_args(one)[-1 if kind(one) is TABLE else 0]
    return None


def unit(hint: Any) -> str:
    """The unit that is declared with a hint; empty if there is none."""
    _, check = checked(hint)
    return check.unit if check else ""


def expected(hint: Any) -> str:
    """A hint in words, with its unit."""
    words = dict.fromkeys(filter(None, (kind(one)[0] for one in alternatives(hint))))
    return f"{' or '.join(words)}{unit(hint) and f' [{unit(hint)}]'}"


@cache
def arguments(make: Callable[..., Any]) -> dict[str, Any]:
    """The hints of the arguments of a class or function that data can give, by name."""
    hints = get_type_hints(make, include_extras=True)
    return {name: hints[name] for name in signature(make).parameters if expected(hints[name])}


def required(make: Callable[..., Any]) -> set[str]:
    """Names of the arguments of a class or function that data must give."""
    given = signature(make).parameters
    return {name for name in arguments(make) if given[name].default is Parameter.empty}
