"""All that is wrong with a description, each fault with file, table and key."""

import difflib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING
from typing import Annotated, Any, Literal, get_args, get_origin

from cattrs.errors import (
    AttributeValidationNote,
    ClassValidationError,
    ForbiddenExtraKeysError,
    IterableValidationError,
)

from ftcfa.description.hints import alternatives, arguments, choices, expected, one_of
from ftcfa.errors import FtcfaError, ParameterError, UnknownNameError

Keys = tuple[str | int, ...]
"""Where something stands: names of tables and a key, and numbers of entries in arrays."""
MAX_SHOWN = 60
"""Characters of a wrong value that a message shows."""


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


class WrongKind(Exception):  # noqa: N818 (it never leaves the room)
    """Data does not fit its hint; the argument says what is expected, if the hint does not."""


class Broken(Exception):  # noqa: N818 (it never leaves the room)
    """A part needs another one that could not be made, which has an error of its own."""


class Faults:
    """Turns the errors of a reader into messages.

    Args:
        file: How messages name the description.
        data: The description.
        top: The keys that may stand at its top, with their hints.
    """

    def __init__(self, file: str, data: Mapping[str, Any], top: Mapping[str, Any]) -> None:
        self.file, self.data, self.top = file, data, top

    def messages(self, error: Exception, keys: Keys = (), hint: Any = None) -> Iterator[FtcfaError]:
        """One error for every fault, whatever groups cattrs made of them.

        Args:
            error: The error of a reader.
            keys: Where it was raised.
            hint: Type hint of what stands there.

        Raises:
            Exception: The error itself, if no data can cause it.
        """
        value = self._value(keys)
        if isinstance(error, ClassValidationError | IterableValidationError):
            noted, others = error.group_exceptions()
            for inner, note in noted:
                key = note.name if isinstance(note, AttributeValidationNote) else note.index
                inside = () if (*keys, key) == ("loop",) else (*keys, key)
                yield from self.messages(inner, inside, note.type)
            for inner in others:
                yield from self.messages(inner, keys, hint)
        elif isinstance(error, ForbiddenExtraKeysError):
            for key in sorted(error.extra_fields):
                yield self.unknown_key(key, arguments(error.cl), keys)
        elif isinstance(error, WrongKind) or (isinstance(error, KeyError) and value is MISSING):
            stated = (
                error.args[0] if isinstance(error, WrongKind) and error.args else expected(hint)
            )
            words = [get_args(one) for one in alternatives(hint) if get_origin(one) is Literal]
            remedy = did_you_mean(value, sum(words, ()))
            table = value is MISSING and bool(choices(hint))
            yield self._fault(keys, shown(value), stated, remedy, table=table)
        elif isinstance(error, FtcfaError):
            yield self._of_part(error, (*keys, *filter(None, error.field.split("."))))
        elif not isinstance(error, Broken):
            raise error

    def unknown_key(self, key: str, known: Mapping[str, Any], keys: Keys = ()) -> FtcfaError:
        """The error of a key that is not among the known ones of this place."""
        if keys and key in self.top:
            remedy = "it belongs at the top, before the first table"
        else:
            remedy = did_you_mean(key, known)
        return self._fault((*keys, key), "unknown key", "" if remedy else one_of(known), remedy)

    def _of_part(self, error: FtcfaError, keys: Keys) -> FtcfaError:
        """The error that a part raised, at the place of what it refuses."""
        value = self._value(keys)
        table = isinstance(value, dict)
        if isinstance(error, UnknownNameError) and error.name == value:
            remedy = did_you_mean(value, error.known)
            return self._fault(keys, shown(value), one_of(error.known), remedy)
        if not error.subject or (keys and error.subject.split()[-1] == keys[-1]):
            return self._fault(keys, error.got, error.expected, error.remedy, table=table)
        return self._fault(keys, str(error), table=table)

    def _fault(
        self, keys: Keys, got: str, expected: str = "", remedy: str = "", *, table: bool = False
    ) -> ParameterError:
        """An error at a key, or at a ``table``."""
        names: list[str] = []
        for key in keys:
            if isinstance(key, int):
                names[-1] += f"[{key}]"
            else:
                names.append(key)
        last = "" if table or not names else names.pop()
        place = " ".join(filter(None, [f"[{'.'.join(names)}]" if names else "", last]))
        subject = ": ".join(filter(None, [self.file, place]))
        return ParameterError(subject, got, expected, remedy)

    def _value(self, keys: Keys) -> Any:
        """The data at a place, MISSING if there is none."""
        value: Any = self.data
        for key in keys:
            try:
                value = value[key]
            except (KeyError, IndexError, TypeError):
                return MISSING
        return value


def shown(data: Any) -> str:
    """A wrong value in a message."""
    if data is MISSING:
        return "missing"
    if isinstance(data, dict):
        return "a table"
    if isinstance(data, bool):
        return str(data).lower()
    text = repr(data)
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 3]}..."


def did_you_mean(name: Any, known: Iterable[str]) -> str:
    """The nearest of the known names as a remedy, with its unit if it is known with its hint."""
    near = difflib.get_close_matches(str(name), known, n=1)
    hint = known[near[0]] if near and isinstance(known, Mapping) else None
    unit = get_args(hint)[1].unit if get_origin(hint) is Annotated else ""
    return f"did you mean '{near[0]}'{unit and f' [{unit}]'}?" if near else ""
