"""Parameters of a loop by dotted name, such as ``controller.gains.c1`` or ``arm.inertias``.

Any number or array that a part of the loop holds can differ from path to path.
"""

import copy
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from types import FunctionType, ModuleType
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError, TracingError, UnknownNameError

SHARED = ("period", "substeps", "reference")
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
        owner, value, seen = value, getattr(value, word), word
    if value is None or not _is_held(owner, word):
        raise ParameterError(
            f"parameter {name}",
            "not given" if value is None else "computed from others",
            "numbers that can be replaced",
            f"{type(owner).__name__} has {', '.join(_names(owner))}",
        )
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        inside = ", ".join(f"{name}.{word}" for word in _names(value))
        raise ParameterError(
            f"parameter {name}", f"a {type(value).__name__}", "numbers", inside and f"try {inside}"
        ) from error


def checked_values(part: Any, vary: Mapping[str, npt.ArrayLike], paths: int) -> dict[str, Array]:
    """Values of varied parameters, each of shape (paths, ...), checked.

    The smallest and largest value of a number pass the checks of the part that holds it; a part
    that asks more of ``word`` says so by ``check_word``.

    Raises:
        UnknownNameError, ParameterError, ShapeError: If a name, value or shape is wrong.
    """
    checked = {}
    for name, given in vary.items():
        if name.split(".")[0] in SHARED:
            raise ParameterError(
                f"varied {name}", "common to all paths", "another parameter", "make a loop for each"
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
            _check_derived(name, owner)
        if values.ndim == 1 and paths and is_dataclass(owner):
            for extreme in (values.min(), values.max()):
                replace(cast(Any, owner), **{word: float(extreme)})
        if hasattr(owner, f"check_{word}"):
            getattr(owner, f"check_{word}")(values)
        checked[name] = values
    return dict(sorted(checked.items(), key=lambda item: _place(part, item[0])))


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

    Raises:
        TracingError: If the part, a twin of the loop's own, knows nothing of that name.
    """
    *owners, word = name.split(".")
    for owner in owners:
        part = getattr(part, owner)
    if not _is_held(part, word):
        raise TracingError(
            f"parameter {name}", "a constant of compiled code", "", 'use engine="interpreted"'
        )
    return getattr(part, f"prepare_{word}", lambda values: values)


def replace_parts(part: Any, swap: Callable[[Any], Any], above: tuple[int, ...] = ()) -> Any:
    """A copy of a part in which every object for which ``swap`` gives another is replaced."""
    swapped = swap(part)
    if swapped is not part or id(part) in above:  # parts may hold each other
        return swapped

    def inner(value: Any) -> Any:
        return replace_parts(value, swap, (*above, id(part)))

    if type(part) in (list, tuple):
        changed = [inner(value) for value in part]
        same = all(new is old for new, old in zip(changed, part, strict=True))
        return part if same else type(part)(changed)
    for word, value in _attributes(part).items():
        changed = inner(value)
        if changed is not value:
            part = _with_attribute(part, word, changed)
    return part


def _check_derived(name: str, owner: Any) -> None:
    """Refuse to vary what a dataclass may have computed other things from when it was made."""
    derived = getattr(owner, "__dict__", {}).keys() - _attributes(owner).keys() - _cached(owner)
    if derived:
        raise ParameterError(
            f"varied {name}",
            f"{type(owner).__name__} computed {', '.join(sorted(derived))} when it was made",
            "a part that computes when asked",
            "make it a cached_property, or make a loop for each value",
        )


def _is_held(owner: Any, word: str) -> bool:
    """Whether a value can be replaced; others follow from those that the owner holds."""
    return word in {*_attributes(owner), *_cached(owner)} or hasattr(owner, f"with_{word}")


def _place(part: Any, name: str) -> tuple[bool, int]:
    """Where a parameter stands in the order of replacement.

    What stands in for a value that its part computes comes last, from the inside out: a part
    forgets such values when anything in it changes.
    """
    for depth, word in enumerate(name.split(".")):
        if word not in _attributes(part):
            return True, -depth
        part = getattr(part, word)
    return False, 0


def _attributes(part: Any) -> dict[str, Any]:
    """What a part holds, by name."""
    if isinstance(part, type | ModuleType | FunctionType | np.ndarray):
        return {}
    if is_dataclass(part):
        return {field.name: getattr(part, field.name) for field in fields(part)}
    if hasattr(part, "_asdict"):
        return part._asdict()
    inside = getattr(part, "__dict__", {})
    return {word: inside[word] for word in inside.keys() - _cached(part)}


def _cached(part: Any) -> set[str]:
    """Names of what a part computes from what it holds, once."""
    classes = type(part).__mro__
    return {k for c in classes for k, v in vars(c).items() if isinstance(v, cached_property)}


def _with_attribute(part: Any, word: str, value: Any) -> Any:
    """A shallow copy with one attribute set; what was cached from the others is forgotten."""
    if hasattr(part, "_replace"):
        return part._replace(**{word: value})
    changed = copy.copy(part)
    for cached in _cached(part):
        getattr(changed, "__dict__", {}).pop(cached, None)
    object.__setattr__(changed, word, value)
    return changed


def _names(part: Any) -> list[str]:
    return sorted(name for name in _attributes(part) if not name.startswith("_"))
