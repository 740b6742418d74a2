"""From plain data to a closed loop, or to everything that is wrong with the data at once."""

import os
from collections.abc import Callable, Hashable, Mapping
from contextlib import suppress
from dataclasses import MISSING, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypedDict, TypeVar, cast, get_args, get_origin, is_typeddict

from cattrs import Converter
from cattrs.errors import BaseValidationError, ClassValidationError

from ftcfa.description import hints
from ftcfa.description.faults import BrokenError, Keys, faults, message, shown
from ftcfa.description.registry import made_by, maker
from ftcfa.description.write import NOT_REBUILDABLE
from ftcfa.errors import ExperimentError, FtcfaError, ParameterError, did_you_mean, one_of
from ftcfa.files import local_path
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.catalogue import catalogue

HOME = ("home",)
"""The text that stands for the arm's home posture where a posture is expected."""
BROKEN = object()
"""Stands for an arm or a loop that could not be made, while the other parts are read."""
BY_CATTRS: tuple[Any, ...] = (list, dict)
"""What cattrs reads by itself, entry by entry."""
ERRORS = (BaseValidationError, FtcfaError)
"""Errors that data can cause."""
Made = TypeVar("Made", bound=Hashable)


def rebuild(cls: type[Made], data: Mapping[str, Any], file: str, folder: Path) -> Made:
    """The loop or experiment that a document describes.

    Args:
        cls: `ClosedLoop`, or a dataclass with a field ``loop`` whose other fields stand in the
            document beside those of the loop.
        data: The document, such as `ftcfa.description.write.document` gives.
        file: How messages name it.
        folder: The folder from which its relative paths count.

    Raises:
        ExperimentError: If anything is wrong with it; it holds all errors.
    """
    if NOT_REBUILDABLE in data:
        raise ExperimentError([ParameterError(file, "no whole loop", remedy=data[NOT_REBUILDABLE])])
    own, of_loop = hints.arguments(cls), hints.arguments(ClosedLoop)
    reader = Reader(folder, {key: own[key] for key in own if key != "loop"} | of_loop)
    found: list[tuple[Keys, FtcfaError]] = []
    found += [((key,), reader.unknown(key)) for key in data if key not in reader.top]
    given, made = dict(data), BROKEN
    with suppress(*ERRORS):  # an arm that is wrong is read again below, where errors have keys
        given["arm"] = reader.arm = reader.value(given.get("arm"), Dynamics)
    for make, keys in {ClosedLoop: of_loop, cls: own}.items():
        try:
            made = reader.part({key: given[key] for key in keys if key in given}, cast(Any, make))
        except ERRORS as error:
            found.extend(faults(error))
        given["loop"] = made
    if found:
        raise ExperimentError(message(file, data, *each) for each in found)
    return cast(Made, made)


class Reader:
    """Makes parts of data: all errors of a part are raised together.

    cattrs reads the keys of a part and the entries of arrays and tables, and notes on each error
    where it was raised; `value` reads every one of them.

    Args:
        folder: The folder from which relative paths count.
        top: The keys that may stand at the top of the document, with their hints.
    """

    def __init__(self, folder: Path, top: Mapping[str, Any]) -> None:
        self.folder, self.top = folder, top
        self.arm: Any = BROKEN
        self.converter = Converter()
        self.converter.register_structure_hook_func(
            lambda it: get_origin(it) not in BY_CATTRS and not is_typeddict(it), self.value
        )
        for simple in (bool, int, float, str):
            self.converter.register_structure_hook(simple, self.value)

    def value(self, data: Any, hint: Any) -> Any:
        """A value of a type, which passes the check that its field declares."""
        if data is BROKEN:
            raise BrokenError("a part", "broken")
        if is_dataclass(data):
            return data
        fits = (one for one in hints.alternatives(hint) if type(data) in hints.kind(one)[1])
        one = next(fits, None)
        words = get_args(one) if get_origin(one) is Literal else ()
        if one is None or (words and data not in words):
            raise ParameterError("", shown(data), hints.expected(hint), did_you_mean(data, words))
        value = self.fitting(data, hint, one)
        _, check = hints.checked(hint)
        if check:
            check.run("", value)
        return value

    def fitting(self, data: Any, hint: Any, one: Any) -> Any:
        """A value of the one type among those of the hint that the data fits."""
        if isinstance(data, dict):
            return self.table(data, hint, one)
        if isinstance(data, list):
            return self.array(data, hint, one)
        if get_args(one) == HOME:
            return self.value(self.arm, Dynamics).home.tolist()
        is_path = hints.kind(one) is hints.TEXT and one is not str
        return self.path(data) if is_path else data

    def table(self, data: dict[str, Any], hint: Any, one: Any) -> Any:
        """A part, by its type or because only one is possible; or values with free names."""
        parts = {part.__name__: part for part in hints.choices(hint)}
        if not parts:
            entries: Any = hints.element(one)
            return self.converter.structure(data, dict[str, entries])
        obvious = (name for name, part in parts.items() if part is Arm or len(parts) == 1)
        named = made_by(parts.values(), data)
        fallback = named[0] if len(named) == 1 else MISSING
        name = data.get("type", next(obvious, fallback))
        if not isinstance(name, str) or name not in parts:
            got, remedy = shown(name), did_you_mean(name, list(parts))
            raise ParameterError("", got, one_of(parts), remedy, field="type")
        rest = {key: value for key, value in data.items() if key != "type"}
        return self.part(rest, maker(parts[name], data))

    def part(self, data: Mapping[str, Any], make: Callable[..., Any]) -> Any:
        """What a class or function makes of the values of a table's keys.

        A nominal arm that is left out is the true one.
        """
        known = hints.arguments(make)
        given = {key: value for key, value in data.items() if key in known}
        if "nominal" in known:
            given.setdefault("nominal", self.arm)
        errors: list[Exception] = [
            ParameterError("", "missing", hints.expected(known[key]), field=key)
            for key in hints.required(make) - given.keys()
        ]
        missing = bool(errors)
        errors += [self.unknown(key, known) for key in data if key not in known]
        try:
            values = self.converter.structure(given, table_type(make))
            made = None if missing else make(**values)
        except ERRORS as error:
            errors.append(error)
        if errors:
            raise ClassValidationError("", errors, cast(Any, make))
        return made

    def unknown(self, key: str, table: Mapping[str, Any] | None = None) -> FtcfaError:
        """The error of a key that is none of a table's; without a table, none of the top's."""
        known = self.top if table is None else table
        if known is not self.top and key in self.top:
            remedy = "it belongs at the top, before the first table"
        else:
            remedy = did_you_mean(key, {name: hints.unit(hint) for name, hint in known.items()})
        return ParameterError("", "unknown key", "" if remedy else one_of(known), remedy, field=key)

    def array(self, data: list[Any], hint: Any, one: Any) -> Any:
        """Numbers in lists in lists, or entries of another type, as many as it says."""
        numbers, entries = hints.kind(one) is hints.NUMBERS, get_args(one)
        if get_origin(one) is tuple and Ellipsis not in entries and len(data) != len(entries):
            raise ParameterError("", f"{len(data)} entries", f"{len(entries)}")
        nested: Any = hints.checked(hint)[0] if numbers else hints.element(one)
        values = self.converter.structure(data, list[nested])
        return values if numbers else tuple(values)

    def path(self, data: str) -> str:
        """A path, counted from the folder; a bare word that is no file there may be a name."""
        path = self.folder / (Path(data) if "://" in data else local_path(data))
        named = data in catalogue() or "://" in data
        exists = os.path.exists(path)  # noqa: PTH110 (pathlib raises where a name is too long)
        bare = len(Path(data).parts) == 1 and not Path(data).suffix and not exists
        return data if named or bare else str(path)


@cache
def table_type(make: Callable[..., Any]) -> Any:
    """The type, for cattrs, of the tables that hold the arguments of a class or function."""
    return cast(Any, TypedDict)("Table", hints.arguments(make), total=False)
