"""The errors of a reader as messages, each with file, table and key."""

from collections.abc import Iterator
from dataclasses import MISSING
from typing import Any

from cattrs.errors import AttributeValidationNote, ClassValidationError, IterableValidationError

from ftcfa.errors import CompoundError, FtcfaError, ParameterError, UnknownNameError

Keys = tuple[str | int, ...]
"""Where something stands: names of tables and a key, and numbers of entries in arrays."""
MAX_SHOWN = 60
"""Characters of a wrong value that a message shows."""


class BrokenError(FtcfaError):
    """A part needs another one that could not be made, which has an error of its own."""


def faults(error: Exception, keys: Keys = ()) -> Iterator[tuple[Keys, FtcfaError]]:
    """Every error in the groups of cattrs, with the keys of what it is about.

    Raises:
        Exception: The error itself, if no data can cause it.
    """
    if isinstance(error, ClassValidationError | IterableValidationError):
        noted, others = error.group_exceptions()
        for inner, note in noted:
            key = note.name if isinstance(note, AttributeValidationNote) else note.index
            yield from faults(inner, (*keys, key))
        for inner in others:
            yield from faults(inner, keys)
    elif isinstance(error, CompoundError):
        for each in error.errors:
            yield (*keys, *filter(None, error.field.split("."))), each
    elif not isinstance(error, FtcfaError):
        raise error
    elif not isinstance(error, BrokenError):
        yield (*keys, *filter(None, error.field.split("."))), error


def message(file: str, data: Any, keys: Keys, error: FtcfaError) -> ParameterError:
    """An error with the place of what it is about as its subject.

    Args:
        file: How messages name the description.
        data: The description.
        keys: The place in it; an error of a whole table names the table.
        error: The error; its own subject is left out where it repeats the name of the key.
    """
    names: list[str] = []
    for key in keys:
        if isinstance(key, int):
            names[-1] += f"[{key}]"
        else:
            names.append(key)
        data = data[key] if isinstance(key, int) or key in data else MISSING
    last = names.pop() if names and not isinstance(data, dict) else ""
    place = " ".join(filter(None, [f"[{'.'.join(names)}]" if names else "", last]))
    subject = ": ".join(filter(None, [file, place]))
    if isinstance(error, UnknownNameError) and error.name == data:
        return ParameterError(subject, shown(data), error.expected, error.remedy)
    if error.subject and not (keys and error.subject.endswith(f" {keys[-1]}")):
        return ParameterError(subject, str(error))
    return ParameterError(subject, error.got, error.expected, error.remedy)


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
