"""A description as a text, and the number that is the same for the same descriptions."""

import hashlib
import json
import re
from typing import Any

import tomli_w

_NUMBERS = re.compile(r"\[\n([^\[\]\"{}]*)\]")
"""An array of plain numbers as tomli-w writes it, one a line; texts hold no bare line break."""


def toml_text(data: dict[str, Any]) -> str:
    """Data as TOML, with arrays of numbers on one line."""
    return _NUMBERS.sub(_on_one_line, tomli_w.dumps(data))


def digest(data: Any) -> str:
    """SHA-256 of data, in which 1 and 1.0 are the same."""
    return hashlib.sha256(json.dumps(_canonical(data), sort_keys=True).encode()).hexdigest()


def _on_one_line(array: re.Match[str]) -> str:
    return f"[{' '.join(array[1].split()).rstrip(',')}]"


def _canonical(data: Any) -> Any:
    """Data in which 1 and 1.0 are the same."""
    if isinstance(data, dict):
        return {key: _canonical(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_canonical(item) for item in data]
    integer = isinstance(data, int) and not isinstance(data, bool)
    return float(data) if integer and abs(data) <= 2**53 else data
