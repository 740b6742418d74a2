"""Parts that the records of all commands share: numbers as JSON knows them, versions, the file."""

import json
import math
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any


def finite(value: Any) -> float | None:
    """A number for JSON, or None if it is infinite or not a number."""
    return float(value) if math.isfinite(value) else None


def interval(estimate: Iterable[Any]) -> dict[str, float | None]:
    """An estimate (value, low, high) and the ends of its interval, by name."""
    return dict(zip(("estimate", "low", "high"), map(finite, estimate), strict=True))


def versions(*packages: str) -> dict[str, str]:
    """Versions of Python and of installed packages, by name."""
    return {"python": platform.python_version(), **{name: version(name) for name in packages}}


def summary_file(record: Mapping[str, Any]) -> bytes:
    """Content of summary.json: plain data, without infinite numbers and NaN."""
    return (json.dumps(record, indent=2, allow_nan=False) + "\n").encode()
