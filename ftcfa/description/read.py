"""From plain data to a closed loop, or to everything that is wrong with the data at once."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import MISSING, is_dataclass
from functools import cache
from inspect import Parameter, signature
from pathlib import Path
from types import GenericAlias, NoneType
from typing import (
    Annotated,
    Any,
    Literal,
    NotRequired,
    TypedDict,
    TypeVar,
    cast,
    get_args,
    get_origin,
    is_typeddict,
)

import numpy as np
import numpy.typing as npt
from cattrs import Converter
from cattrs.cols import list_structure_factory, mapping_structure_factory
from cattrs.errors import BaseValidationError, ClassValidationError, ForbiddenExtraKeysError

from ftcfa.description.faults import Broken, ExperimentError, Faults, WrongKind
from ftcfa.description.hints import TEXT, alternatives, arguments, choices, element, kind, unchecked
from ftcfa.description.registry import maker
from ftcfa.description.write import NOT_REBUILDABLE
from ftcfa.errors import FtcfaError, ParameterError, UnknownNameError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.catalogue import catalogue

HOME = "home"
"""Stands for the arm's home posture wherever numbers, one for each joint, are expected."""
BROKEN = object()
"""Stands for an arm that could not be made, while the other parts are read."""
ERRORS = (BaseValidationError, FtcfaError, WrongKind, Broken)
"""Errors that data can cause."""
Made = TypeVar("Made")


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
    kind: Any = cls
    own = {name: hint for name, hint in arguments(kind).items() if name != "loop"}
    top = own | arguments(ClosedLoop)
    faults = Faults(file, data, top)
    errors = [faults.unknown_key(key, top) for key in data if key not in top]
    given = {key: value for key, value in data.items() if key in top}
    reader = Reader(folder)
    with suppress(*ERRORS):  # an arm that is wrong is read again below, where errors have keys
        given["arm"] = reader.arm = reader.value(given.get("arm"), Dynamics)
    if cls is not ClosedLoop:
        given["loop"] = {key: given.pop(key) for key in arguments(ClosedLoop) if key in given}
    try:
        made = reader.part(given, cls)
    except ERRORS as error:
        errors.extend(faults.messages(error))
    if errors:
        raise ExperimentError(errors)
    return cast(Made, made)


class Reader:
    """Makes parts of data: all errors of a part are raised together.

    cattrs reads the tables of a part, arrays and tables with free names, and notes on each error
    the key where it was raised; `value` reads every entry of them.

    Args:
        folder: The folder from which relative paths count.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.arm: Any = BROKEN
        self.converter = Converter()
        self.converter.register_structure_hook_func(lambda it: not is_typeddict(it), self.value)
        for simple in (bool, int, float, str):
            self.converter.register_structure_hook(simple, self.value)

    def value(self, data: Any, hint: Any) -> Any:
        """A value of a type, which passes the check that its field declares."""
        if get_origin(hint) is Annotated:
            hint, check = get_args(hint)
            value = self.value(data, hint)
            if value is not None:
                check.run("", value)
            return value
        if data is BROKEN:
            raise Broken
        if is_dataclass(data) or (data is None and NoneType in get_args(hint)):
            return data
        one = next((one for one in alternatives(hint) if type(data) in kind(one).data), None)
        if one is None or (get_origin(one) is Literal and data not in get_args(one)):
            raise WrongKind
        if get_origin(one) is np.ndarray:
            rows = self.value(data, npt.ArrayLike)
            try:
                return np.array(rows, dtype=float)
            except ValueError:
                raise WrongKind("numbers in rows of one length") from None
        if isinstance(data, dict):
            return self.table(data, hint, one)
        if isinstance(data, list):
            return self.array(data, one)
        if isinstance(data, str):
            return self.text(data, one)
        if one in (bool, int):
            return data
        try:
            return float(data)
        except OverflowError:
            raise WrongKind from None

    def table(self, data: dict[str, Any], hint: Any, one: Any) -> Any:
        """A part, by its type or because only one is possible; or values with free names."""
        parts = {part.__name__: part for part in choices(hint)}
        if not parts:
            return mapping_structure_factory(one, self.converter)(data, one)
        obvious = (name for name, part in parts.items() if part is Arm or len(parts) == 1)
        name = data.get("type", next(obvious, MISSING))
        if not isinstance(name, str) or name not in parts:
            raise UnknownNameError("", name, parts, field="type")
        return self.part(data, maker(parts[name], data))

    def part(self, data: Mapping[str, Any], make: Callable[..., Any]) -> Any:
        """What a class or function makes of the values of a table's keys.

        A nominal arm that is left out is the true one.
        """
        hints, table = arguments(make), table_type(make)
        missing = table.__required_keys__ - data.keys()
        given = {key: None for key in missing if NoneType in get_args(unchecked(hints[key]))}
        given |= {key: value for key, value in data.items() if key in hints}
        if "nominal" in missing:
            given["nominal"] = self.arm
        errors: list[Exception] = []
        unknown = data.keys() - hints.keys() - {"type"}
        if unknown:
            errors.append(ForbiddenExtraKeysError("", cast(Any, make), unknown))
        try:
            made = make(**self.converter.structure(given, table))
        except ERRORS as error:
            errors.append(error)
        if errors:
            raise ClassValidationError("", errors, cast(Any, make))
        return made

    def array(self, data: list[Any], one: Any) -> Any:
        """Numbers in lists in lists, or entries of another type, as many as it says."""
        numbers = one is npt.ArrayLike
        entries = get_args(one)
        if get_origin(one) is tuple and Ellipsis not in entries and len(data) != len(entries):
            raise WrongKind(f"{len(entries)} entries")
        hint: Any = GenericAlias(list, one if numbers else element(one))
        values = list_structure_factory(hint, self.converter)(data, hint)
        return values if numbers else tuple(values)

    def text(self, data: str, one: Any) -> Any:
        """A text, the path of a file, or the numbers for which `HOME` stands.

        A path counts from the folder; a bare word that is no file there may be a name.
        """
        if one is npt.ArrayLike:
            if data != HOME:
                raise WrongKind(f'numbers or "{HOME}"')
            return self.value(self.arm, Dynamics).home.tolist()
        if kind(one) is not TEXT or one is str:
            return data
        path = self.folder / Path(data).expanduser()
        named = data in catalogue() or "://" in data
        bare = len(Path(data).parts) == 1 and not Path(data).suffix and not path.exists()
        return data if named or bare else str(path)


@cache
def table_type(make: Callable[..., Any]) -> Any:
    """The type, for cattrs, of the tables that hold the arguments of a class or function."""
    given = signature(make).parameters
    hints: dict[str, Any] = {
        name: hint if given[name].default is Parameter.empty else NotRequired[hint]
        for name, hint in arguments(make).items()
    }
    return cast(Any, TypedDict)("Table", hints)
