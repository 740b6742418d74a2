"""Parameters of a loop by dotted name, such as ``controller.gains.c1`` or ``arm.inertias``.

Any number or array that a part of the loop holds can differ from path to path.
"""

import copy
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from types import FunctionType, ModuleType
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError, UnknownNameError

SHARED = ("period", "substeps")
"""What all paths of a run have in common."""


def parameter(part: Any, name: str) -> Array:
    """The value of a parameter as a float array.

    Raises:
        UnknownNameError: If the loop has no part or number of that name; it lists those it has.
        ParameterError: If the name stands for something else than numbers.
    """
    value, seen = part, ""
    for word in name.split("."):
        if not hasattr(value, word) or word.startswith("_"):
            raise UnknownNameError(f"parameter {name}: {seen or 'loop'}", word, _names(value))
        value, seen = getattr(value, word), word
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"parameter {name}", f"a {type(value).__name__}", f"numbers; it has {_names(value)}"
        ) from error


def checked_values(part: Any, vary: Mapping[str, npt.ArrayLike], paths: int) -> dict[str, Array]:
    """Values of varied parameters, each of shape (paths, ...), checked.

    The smallest and largest value of a number pass the checks of the part that holds it.

    Raises:
        UnknownNameError, ParameterError, ShapeError: If a name, value or shape is wrong.
    """
    checked = {}
    for name, given in vary.items():
        if name in SHARED:
            raise ParameterError(
                f"varied {name}", "a sampling time", "another parameter", "make a loop for each"
            )
        shape = (paths, *parameter(part, name).shape)
        try:
            values = np.asarray(given, dtype=float)
        except (TypeError, ValueError) as error:
            raise ParameterError(f"varied {name}", repr(given), "numbers") from error
        if values.shape != shape:
            raise ShapeError(f"varied {name}", f"shape {values.shape}", f"shape {shape}")
        if not np.all(np.isfinite(values)):
            raise ParameterError(f"varied {name}", "values that are not finite", "finite numbers")
        *owners, word = name.split(".")
        owner = part
        for above in owners:
            owner = getattr(owner, above)
        if values.ndim == 1 and paths and is_dataclass(owner):
            for extreme in (values.min(), values.max()):
                replace(cast(Any, owner), **{word: float(extreme)})
        checked[name] = values
    return checked


def with_parameter(part: Any, name: str, value: Any) -> Any:
    """A copy of a part with one parameter replaced, unchecked: the value may be symbols."""
    word, _, rest = name.partition(".")
    if rest:
        value = with_parameter(getattr(part, word), rest, value)
    elif hasattr(part, f"with_{word}"):
        return getattr(part, f"with_{word}")(value)
    return _with_attribute(part, word, value)


def preparation(part: Any, name: str) -> Callable[[Array], Array]:
    """What turns values of a parameter, shape (paths, ...), into what the part computes with.

    A part that computes with something else than ``word`` says so by ``prepare_word``.
    """
    *owners, word = name.split(".")
    for owner in owners:
        part = getattr(part, owner)
    return getattr(part, f"prepare_{word}", lambda values: values)


def replace_parts(part: Any, swap: Callable[[Any], Any]) -> Any:
    """A copy of a part in which every object for which ``swap`` gives another is replaced."""
    swapped = swap(part)
    if swapped is not part:
        return swapped
    if not _has_parts(part):
        return part
    for word, value in _attributes(part).items():
        changed = replace_parts(value, swap)
        if changed is not value:
            part = _with_attribute(part, word, changed)
    return part


def _has_parts(part: Any) -> bool:
    opaque = type | ModuleType | FunctionType | np.ndarray
    return hasattr(part, "__dict__") and not isinstance(part, opaque)


def _attributes(part: Any) -> dict[str, Any]:
    if is_dataclass(part):
        return {field.name: getattr(part, field.name) for field in fields(part)}
    return dict(vars(part))


def _with_attribute(part: Any, word: str, value: Any) -> Any:
    """A shallow copy with one attribute set; what was cached from the others is forgotten."""
    changed = copy.copy(part)
    if is_dataclass(part):
        kept = {field.name for field in fields(part)}
        for cached in vars(changed).keys() - kept:
            vars(changed).pop(cached)
    vars(changed)[word] = value
    return changed


def _names(part: Any) -> list[str]:
    names = {*_attributes(part)} if _has_parts(part) else set()
    return sorted(name for name in names if not name.startswith("_"))
