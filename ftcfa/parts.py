"""Parts of a loop, which are frozen dataclasses or NamedTuples, and parameters that they declare.

A part declares its parameters in one table, by name:

    varies: ClassVar[Parameters] = number_fields("c1", "c2")
"""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import check_field, check_fields
from ftcfa.errors import ShapeError


class Part:
    """Base of the dataclasses that are parts: it checks every field as its type declares."""

    per_joint: ClassVar[tuple[str, ...]] = ()
    """Fields that have one number for all joints, or one for each; lists become arrays."""

    def __post_init__(self) -> None:
        check_fields(self)
        for name in self.per_joint:
            if isinstance(getattr(self, name), Sequence):
                object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))

    def check_joints(self, n: int) -> None:
        """Raise ShapeError unless each of the fields `per_joint` suits n joints."""
        for name in self.per_joint:
            values = getattr(self, name)
            if np.shape(values) not in ((), (n,)):
                subject, got = f"{type(self).__name__} {name}", f"{np.size(values)} numbers"
                expected = f"one number, or one for each of {n} joints"
                raise ShapeError(subject, got, expected, field=name)


def any_finite(part: Any, values: Array) -> None:
    """The check of a parameter that may have any finite values."""


@dataclass(frozen=True)
class Parameter:
    """A number or array of a part that may differ from path to path.

    Attributes:
        replace: (part, value) -> a copy of the part with that value, which may be symbols.
        check: (part, values of shape (paths, ...)): raises an FtcfaError if the part cannot have
            one of them.
        prepare: (part, values of shape (paths, ...)) -> what `replace` takes in compiled code,
            shape (paths, ...); None if it takes the values themselves.
        whole_steps: Whether it is a time in whole integration steps [s].
    """

    replace: Callable[[Any, Any], Any]
    check: Callable[[Any, Array], None] = any_finite
    prepare: Callable[[Any, Array], Array] | None = None
    whole_steps: bool = False


Parameters: TypeAlias = Mapping[str, Parameter]
"""The parameters of a part by name."""


def number_fields(*names: str) -> Parameters:
    """Parameters that are fields, each a number or an array.

    The smallest and largest value of a number are checked as the part's constructor checks them.
    """
    return {name: number_field(name) for name in names}


def number_field(
    name: str, check: Callable[[Any, Array], None] | None = None, whole_steps: bool = False
) -> Parameter:
    """A parameter that is a field; ``check`` replaces the check by the part's constructor."""

    def constructed(part: Any, values: Array) -> None:
        if values.ndim == 1 and len(values) and is_dataclass(part):
            for extreme in (values.min(), values.max()):
                replace(part, **{name: float(extreme)})  # type: ignore[type-var]

    def replaced(part: Any, value: Any) -> Any:
        return with_fields(part, {name: value})

    return Parameter(replaced, check or constructed, whole_steps=whole_steps)


def checked_fields(*names: str) -> Parameters:
    """Parameters that are fields with one number for all joints or one for each."""
    return {name: checked_field(name) for name in names}


def checked_field(name: str) -> Parameter:
    """A parameter that is a field, whose values the check that the field declares takes."""

    def check(part: Any, values: Array) -> None:
        if values.size:
            check_field(type(part), name, values.ravel(), f"varied {name}")

    return number_field(name, check)


def parameters_of(part: Any) -> Parameters:
    """Parameters that a part declares; empty if it declares none."""
    declared: Parameters = getattr(part, "varies", {})
    return declared


def fields_of(part: Any) -> dict[str, Any]:
    """Fields of a dataclass or a NamedTuple by name; empty for any other object."""
    if is_dataclass(part) and not isinstance(part, type):
        return {field.name: getattr(part, field.name) for field in fields(part)}
    return part._asdict() if hasattr(part, "_asdict") else {}


def with_fields(part: Any, values: Mapping[str, Any]) -> Any:
    """A copy of a part with other values in some fields, unchecked: they may be symbols.

    The copy computes every `cached_property` anew.
    """
    if hasattr(part, "_replace"):
        return part._replace(**values)
    changed = copy.copy(part)
    for name in cached(part):
        vars(changed).pop(name, None)
    for name, value in values.items():
        object.__setattr__(changed, name, value)
    return changed


def cached(part: Any) -> set[str]:
    """Names of the cached properties that a part has computed."""
    own = getattr(part, "__dict__", {})
    return {name for name in own if isinstance(getattr(type(part), name, None), cached_property)}
