"""A document as TOML with a comment at every key, and every other key as a comment.

The comments are the meanings, units and defaults that the dataclasses declare.
"""

import json
import re
from collections.abc import Callable, Mapping
from inspect import Parameter, cleandoc, signature
from typing import Any

import numpy as np

from ftcfa.description.hints import arguments, choices, expected, unit
from ftcfa.description.registry import maker

_ENTRY = re.compile(r"^    (\w+): (.*?)(?=^    \w+: |^\S|\Z)", re.MULTILINE | re.DOTALL)
"""An attribute or argument of a docstring in Google's style, without its first indentation."""
_END = re.compile(r"(?<=\.) |(?<=[;:]) |, or None\b|, or the name\b|, such as\b")
"""Where the first clause of a meaning ends."""
Maker = Callable[..., Any]


def commented(data: Mapping[str, Any], makers: Mapping[str, Maker], *tops: Maker) -> str:
    """A document as TOML.

    Args:
        data: The document: numbers and texts, then a table for each part.
        makers: What is made of each table of the top, by its key.
        tops: What the keys of the top are arguments of.
    """
    blocks = [_keys(data, *tops, without=makers.keys())]
    for key, table in data.items():
        if isinstance(table, Mapping):
            blocks += _tables(key, table, makers[key])
    return "\n\n".join(blocks) + "\n"


def _tables(path: str, table: Mapping[str, Any], make: Maker) -> list[str]:
    """A table, then the tables in it."""
    keys = _keys(table, make)
    blocks = [f"[{path}]\n{keys}" if keys else f"[{path}]"]
    hints = arguments(make)
    for key, inner in table.items():
        if isinstance(inner, Mapping):
            parts = choices(hints[key])
            named = [part for part in parts if part.__name__ == inner.get("type")]
            blocks += _tables(f"{path}.{key}", inner, maker((named or [*parts])[0], inner))
    return blocks


def _keys(data: Mapping[str, Any], *makes: Maker, without: Any = ()) -> str:
    """The keys of a table, those that are given first."""
    lines, others = [], []
    described = {key: (make, hint) for make in makes for key, hint in arguments(make).items()}
    for key, value in data.items():
        if not isinstance(value, Mapping):
            what = _comment(*described[key], key) if key in described else ""
            lines.append(f"{key} = {toml_value(value)}{what}")
    for key, (make, hint) in described.items():
        if key not in data and key not in without:
            default = signature(make).parameters[key].default
            value = _plain(default)
            shown = "..." if value is None else toml_value(value)
            others.append(f"# {key} = {shown}{_comment(make, hint, key)}")
    return "\n".join([*lines, *others])


def _plain(default: Any) -> Any:
    """A default as plain data, or None if a file cannot say it."""
    if default is Parameter.empty:
        return None
    if isinstance(default, np.ndarray):
        return default.tolist()
    return default if isinstance(default, bool | int | float | str | tuple) else None


def _comment(make: Maker, hint: Any, key: str) -> str:
    """What a key means, and its unit."""
    meaning = meanings(make).get(key, "")
    own = unit(hint)
    if own and f"[{own}]" not in meaning:
        meaning = f"{meaning} [{own}]".strip()
    return f"  # {meaning or expected(hint)}"


def meanings(make: Maker) -> dict[str, str]:
    """What each attribute or argument means, in the first clause that the docstring says of it.

    Of several classes in a row, as `dataclass` inherits fields, the first that says it counts.
    """
    found: dict[str, str] = {}
    for one in getattr(make, "__mro__", (make,)):
        text = cleandoc(one.__doc__ or "")
        for name, words in _ENTRY.findall(text):
            sentence = " ".join(words.split())
            first = _END.split(sentence, maxsplit=1)[0]
            found.setdefault(name, first.replace("``", "").replace("`", "").rstrip(".;:,"))
    return found


def toml_value(value: Any) -> str:
    """A value as TOML on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        entries = ", ".join(f"{key} = {toml_value(one)}" for key, one in value.items())
        return f"{{ {entries} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value)
