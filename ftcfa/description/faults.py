"""All that is wrong with a description, each fault with file, table and key."""

import difflib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from cattrs.errors import (
    AttributeValidationNote,
    BaseValidationError,
    ForbiddenExtraKeysError,
    IterableValidationNote,
)

from ftcfa.checks import declared
from ftcfa.description.hints import choices, expected
from ftcfa.errors import FtcfaError, ParameterError, UnknownNameError

Keys = tuple[str | int, ...]
"""Where something stands: names of tables and a key, and numbers of entries in arrays."""
MAX_SHOWN = 60
"""Characters of a wrong value that a message shows."""
NO_UNITS: Mapping[str, str] = MappingProxyType({})


class ExperimentError(FtcfaError):
    """All that is wrong with an experiment file or description.

    Args:
        errors: Each with file, table and key.
    """

    def __init__(self, errors: Iterable[FtcfaError]) -> None:
        self.errors = tuple(errors)
        first = self.errors[0]
        super().__init__(first.subject, first.got, first.expected, first.remedy)
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(map(str, self.errors))


class KindError(FtcfaError):
    """Data of the wrong kind; the subject is the place where it stands."""

    def __init__(self, got: str, expected: str, remedy: str = "", *, field: str = "") -> None:
        super().__init__("", got, expected, remedy, field=field)


class Broken(Exception):  # noqa: N818 (it never leaves the reader)
    """A part needs another one that could not be made, which has an error of its own."""


class Faults:
    """Turns the errors of a reader into messages.

    Args:
        file: How messages name the description.
        data: The description.
        top: Keys that may stand at its top.
    """

    def __init__(self, file: str, data: Mapping[str, Any], top: Iterable[str]) -> None:
        self.file, self.data, self.top = file, data, tuple(top)

    def messages(self, error: Exception, keys: Keys = ()) -> Iterator[FtcfaError]:
        """One error for every fault, whatever groups cattrs made of them.

        Raises:
            Exception: The error itself, if no data can cause it.
        """
        if isinstance(error, BaseValidationError):
            for inner in error.exceptions:
                yield from self.messages(inner, (*keys, *_place(inner)))
        elif isinstance(error, ForbiddenExtraKeysError):
            names, checks = [field.name for field in fields(error.cl)], declared(error.cl)
            units = {name: checks[name][0].unit for name in names if name in checks}
            for key in sorted(error.extra_fields):
                yield self.unknown_key(key, names, keys, units)
        elif isinstance(error, KeyError) and (note := _note(error)) is not None:
            table = bool(choices(note.type))
            yield self._fault(keys, "missing", expected(note.type), table=table)
        elif isinstance(error, FtcfaError):
            inside = tuple(error.field.split(".")) if error.field else ()
            yield self._of_part(error, (*keys, *inside))
        elif not isinstance(error, Broken):
            raise error

    def unknown_key(
        self, key: str, known: Iterable[str], keys: Keys = (), units: Mapping[str, str] = NO_UNITS
    ) -> FtcfaError:
        """The error of a key that no part of this place has."""
        remedy = did_you_mean(key, known, units)
        if keys and key in self.top:
            remedy = "it belongs at the top, before the first table"
        return self._fault((*keys, key), "unknown key", "" if remedy else one_of(known), remedy)

    def _of_part(self, error: FtcfaError, keys: Keys) -> FtcfaError:
        """The error of a part, or of data that is none."""
        value = self._value(keys)
        if isinstance(error, KindError):
            return self._fault(keys, error.got, error.expected, error.remedy)
        table = isinstance(value, dict)
        if isinstance(error, UnknownNameError) and error.name == value:
            remedy = did_you_mean(value, error.known)
            return self._fault(keys, shown(value), one_of(error.known), remedy)
        if not error.subject or error.subject.endswith(f" {keys[-1] if keys else ''}"):
            return self._fault(keys, error.got, error.expected, error.remedy, table)
        return self._fault(keys, str(error), table=table)

    def _fault(
        self, keys: Keys, got: str, expected: str = "", remedy: str = "", table: bool = False
    ) -> ParameterError:
        """An error at a key, or at a ``table``."""
        names: list[str] = []
        for key in keys:
            if isinstance(key, int):
                names[-1] += f"[{key}]"
            else:
                names.append(key)
        *tables, key = (*names, "") if table or not names else names
        place = " ".join(filter(None, [f"[{'.'.join(tables)}]" if tables else "", key]))
        subject = f"{self.file}: {place}" if place else self.file
        return ParameterError(subject, got, expected, remedy)

    def _value(self, keys: Keys) -> Any:
        """The data at a place, None if there is none."""
        value: Any = self.data
        for key in keys:
            try:
                value = value[key]
            except (KeyError, IndexError, TypeError):
                return None
        return value


def _note(error: BaseException) -> AttributeValidationNote | IterableValidationNote | None:
    """What cattrs noted on an error: the field, or the entry of an array, that it is about."""
    kinds = (AttributeValidationNote, IterableValidationNote)
    return next((n for n in getattr(error, "__notes__", ()) if isinstance(n, kinds)), None)


def _place(error: BaseException) -> Keys:
    note = _note(error)
    if note is None:
        return ()
    return (note.name if isinstance(note, AttributeValidationNote) else note.index,)


def shown(data: Any) -> str:
    """A wrong value in a message."""
    if isinstance(data, dict):
        return "a table"
    if isinstance(data, bool):
        return str(data).lower()
    text = repr(data)
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 3]}..."


def one_of(known: Iterable[Any]) -> str:
    """The known names as what was expected."""
    return f"one of: {', '.join(map(str, known))}"


def did_you_mean(name: Any, known: Iterable[str], units: Mapping[str, str] = NO_UNITS) -> str:
    """The nearest of the known names, with its unit, as a remedy; nothing if none is near."""
    near = difflib.get_close_matches(str(name), map(str, known), n=1)
    unit = units.get(near[0], "") if near else ""
    return f"did you mean '{near[0]}'{unit and f' [{unit}]'}?" if near else ""
