"""From plain data to a closed loop, or to everything that is wrong with the data at once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt
from cattrs import Converter
from cattrs.errors import (
    BaseValidationError,
    ClassValidationError,
    ForbiddenExtraKeysError,
    IterableValidationError,
    IterableValidationNote,
)
from cattrs.gen import make_dict_structure_fn

from ftcfa.description.faults import (
    Broken,
    ExperimentError,
    Faults,
    KindError,
    did_you_mean,
    one_of,
    shown,
)
from ftcfa.description.hints import (
    alternatives,
    choices,
    element,
    expected,
    fits,
    is_number,
    is_path,
)
from ftcfa.description.registry import arguments, maker
from ftcfa.description.write import NOT_REBUILDABLE
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.catalogue import catalogue

HOME = "home"
"""Stands for the arm's home posture wherever numbers, one for each joint, are expected."""
NO_KEY = "observer"
"""A field of `ClosedLoop` that no experiment has."""
BROKEN = object()
"""Stands for a part that could not be made, while the others are read."""
ERRORS = (BaseValidationError, FtcfaError, Broken)
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
    of_loop = [field.name for field in fields(ClosedLoop) if field.name != NO_KEY]
    own = [field.name for field in fields(cast(Any, cls)) if cls is not ClosedLoop]
    top = [name for name in own if name != "loop"] + of_loop
    faults = Faults(file, data, top)
    errors = [faults.unknown_key(key, top) for key in data if key not in top]
    reader = _Reader(folder)

    def attempt(read: Callable[[Any, Any], Any], given: Any, hint: Any, *keys: str) -> Any:
        try:
            return read(given, hint)
        except ERRORS as error:
            errors.extend(faults.messages(error, keys))
            return BROKEN

    given = {key: data[key] for key in of_loop if key in data}
    if "arm" in given:
        given["arm"] = reader.arm = attempt(reader.value, given["arm"], Dynamics, "arm")
    made = attempt(reader.part, given, ClosedLoop)
    if cls is not ClosedLoop:
        given = {"loop": made, **{key: data[key] for key in own if key in data}}
        made = attempt(reader.part, given, cls)
    if errors:
        raise ExperimentError(errors)
    return cast(Made, made)


def is_annotated(hint: Any) -> bool:
    """Whether a field declares a check."""
    return get_origin(hint) is Annotated


def type_of(data: Mapping[str, Any], parts: Sequence[type]) -> type:
    """The part that a table describes: by its type, or the one that is obvious."""
    by_name = {part.__name__: part for part in parts}
    obvious = Arm if Arm in parts else parts[0] if len(parts) == 1 else None
    if "type" not in data and obvious is not None:
        return obvious
    name = data.get("type")
    if not isinstance(name, str) or name not in by_name:
        got = shown(name) if "type" in data else "missing"
        raise KindError(got, one_of(by_name), did_you_mean(name, by_name), field="type")
    return by_name[name]


class _Reader:
    """Makes parts of data, by cattrs: all errors of a part are raised together.

    Args:
        folder: The folder from which relative paths count.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.arm: Any = BROKEN
        self.converter = Converter()
        self.converter.register_structure_hook_func(lambda _: True, self.value)
        self.converter.register_structure_hook_func(is_annotated, self.checked)
        for kind in (bool, int, float, str):
            self.converter.register_structure_hook(kind, self.value)

    def checked(self, data: Any, hint: Any) -> Any:
        """A value that passes the check that its field declares."""
        kind, check = get_args(hint)
        value = self.value(data, kind)
        if value is not None:
            check.run("", value)
        return value

    def value(self, data: Any, hint: Any) -> Any:
        """A value of a type."""
        if data is BROKEN:
            raise Broken
        if is_dataclass(data) or (data is None and NoneType in get_args(hint)):
            return data
        allowed = sorted(alternatives(hint), key=is_path, reverse=True)
        fitting = [one for one in allowed if fits(one, data)]
        if not fitting:
            raise KindError(shown(data), expected(hint))
        one = fitting[0]
        if one is npt.ArrayLike:
            return self.numbers(data)
        if get_origin(one) is np.ndarray:
            return self.array(data)
        if get_origin(one) is Literal and data not in get_args(one):
            known = get_args(one)
            raise KindError(shown(data), one_of(known), did_you_mean(data, known))
        if is_path(one):
            return self.path(data)
        if isinstance(data, list):
            return self.sequence(data, one)
        if isinstance(data, dict):
            return self.table(data, hint) if choices(hint) else self.mapping(data, one)
        return float(data) if one is float else data

    def table(self, data: dict[str, Any], hint: Any) -> Any:
        """A part, by the name of its type; unknown keys are errors beside those of the rest."""
        call = maker(type_of(data, choices(hint)), data)
        shape: Any = call if isinstance(call, type) else arguments(call)
        names = {field.name for field in fields(shape)}
        given = {key: value for key, value in data.items() if key in names}
        unknown = data.keys() - names - {"type"}
        errors: list[Exception] = []
        if unknown:
            errors.append(ForbiddenExtraKeysError("", shape, unknown))
        try:
            made = self.part(given, shape)
            if shape is not call:
                made = call(**{key: getattr(made, key) for key in given})
        except ERRORS as error:
            errors.append(error)
        if errors:
            raise ClassValidationError("", errors, shape)
        return made

    def part(self, data: Mapping[str, Any], cls: Any) -> Any:
        """A dataclass, from its fields; a nominal arm that is left out is the true one."""
        hints = get_type_hints(cls)
        given = dict(data)
        for field in fields(cls):
            required = field.default is MISSING and field.default_factory is MISSING
            if required and field.name not in data and cls is not ClosedLoop:
                if hints[field.name] is Dynamics:
                    given[field.name] = self.arm
                elif NoneType in get_args(hints[field.name]):
                    given[field.name] = None
        return make_dict_structure_fn(cls, self.converter)(given, cls)

    def numbers(self, data: Any) -> Any:
        """Numbers in lists in lists, as they stand; `HOME` is a row of them."""
        if isinstance(data, list):
            return self.each(data, [npt.ArrayLike] * len(data))
        if data == HOME:
            if self.arm is BROKEN:
                raise Broken
            return self.arm.home.tolist()
        if not is_number(data):
            text = isinstance(data, str)
            raise KindError(shown(data), f'numbers or "{HOME}"' if text else "numbers")
        return float(data)

    def array(self, data: Any) -> Any:
        """Numbers as an array."""
        rows = self.numbers(data)
        try:
            return np.array(rows, dtype=float)
        except ValueError:
            raise KindError(shown(data), "numbers in rows of one length") from None

    def path(self, data: str) -> str:
        """A path counts from the folder; a bare word that is no file there may be a name."""
        path = self.folder / Path(data).expanduser()
        named = data in catalogue() or "://" in data
        bare = len(Path(data).parts) == 1 and not Path(data).suffix and not path.exists()
        return data if named or bare else str(path)

    def sequence(self, data: list[Any], one: Any) -> tuple[Any, ...]:
        """Entries of one type, or as many as the type says."""
        hints = get_args(one)
        if get_origin(one) is tuple and Ellipsis not in hints:
            if len(data) != len(hints):
                raise KindError(f"{len(data)} entries", f"{len(hints)}")
            return tuple(self.each(data, hints))
        return tuple(self.each(data, [element(one)] * len(data)))

    def mapping(self, data: dict[str, Any], one: Any) -> dict[str, Any]:
        """Values of one type by names that are free."""
        values = self.each([*data.values()], [element(one)] * len(data), [*data])
        return dict(zip(data, values, strict=True))

    def each(
        self, data: list[Any], hints: Sequence[Any], keys: Sequence[str] | None = None
    ) -> list[Any]:
        """The values of all entries; the errors of all are raised together."""
        values, errors = [], list[Exception]()
        places: Sequence[str | int] = keys or range(len(data))
        for key, item, hint in zip(places, data, hints, strict=True):
            try:
                values.append(self.value(item, hint))
            except ERRORS as error:
                error.__notes__ = [IterableValidationNote("", key, hint)]
                errors.append(error)
        if errors:
            raise IterableValidationError("", errors, list)
        return values
