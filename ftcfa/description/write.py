"""A closed loop as plain data: what results remember, files hold and other machines receive."""

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

from ftcfa.description.hints import choices, element
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.urdf.description import read_urdf
from ftcfa.model.urdf.source import has_path, is_as_loaded

LARGE = 1_000_000
"""Entries above which results remember an array by its digest; 20 MB as text."""
NOT_REBUILDABLE = "not_rebuildable"
"""Key under which results say why no loop can be made of what they remember."""


def describe(part: Any, largest: int | None = None) -> Any:
    """Any part of an experiment as numbers, strings, lists and dictionaries.

    An Arm becomes the keywords that load it; any other dataclass its type, where that is not
    obvious, and fields. Other objects are described by their type.

    Args:
        part: The part.
        largest: Arrays of more entries become their shape and SHA-256; None writes all out.
    """
    if isinstance(part, Arm):
        return {"type": "Arm", **(part.source or {"robot": part.name})}
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        return {"type": type(part).__name__, **_fields(part, largest)}
    if largest is not None and isinstance(part, np.ndarray) and part.size > largest:
        digest = hashlib.sha256(np.ascontiguousarray(part).tobytes()).hexdigest()
        return {"type": "array", "shape": list(part.shape), "sha256": digest}
    if isinstance(part, np.ndarray | np.generic):
        return part.tolist()
    if isinstance(part, list | tuple):
        return [describe(item, largest) for item in part]
    if isinstance(part, Mapping):
        return {str(key): describe(value, largest) for key, value in part.items()}
    if part is None or isinstance(part, bool | int | float | str):
        return part
    return {"type": type(part).__name__}


def _fields(part: Any, largest: int | None) -> dict[str, Any]:
    data = {}
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        data[field.name] = describe(value, largest)
        hint = get_args(field.type)[0] if get_origin(field.type) is Annotated else field.type
        allowed = [t for t in get_args(hint) or (hint,) if t is not NoneType]
        if dataclasses.is_dataclass(value) and allowed == [type(value)]:
            del data[field.name]["type"]  # it is obvious
    return data


def document(loop: ClosedLoop) -> dict[str, Any]:
    """A loop as data from which `ftcfa.description.read.rebuild` makes the same one, bit for bit.

    What is None is left out, and so is a nominal arm that is the true one.

    Raises:
        ParameterError: If a part is a user's own, or an Arm was changed after it was loaded.
    """
    _check(loop, ClosedLoop, "loop")
    return _document(loop)


def provenance(loop: ClosedLoop) -> dict[str, Any]:
    """What results remember of their loop: a `document` that needs no file of this machine.

    Where no loop can be made of it (a part is a user's own, an Arm was changed by hand, an array
    has more than `LARGE` entries), the entry `NOT_REBUILDABLE` says why, and the document shows
    what can be shown.
    """
    try:
        _check(loop, ClosedLoop, "loop", LARGE)
    except ParameterError as error:
        return {NOT_REBUILDABLE: str(error), **_document(loop, LARGE)}
    return self_contained(_document(loop))


def self_contained(data: Mapping[str, Any]) -> dict[str, Any]:
    """A document that needs no file of this machine: texts in place of the paths of URDFs."""
    whole = _tidy(data, None)  # a copy
    for arm in arms(whole):
        if has_path(arm):
            path = Path(arm["robot"])
            arm |= {"robot": path.name, "urdf": read_urdf(path).text}
    return whole


def differences(first: Any, second: Any, name: str = "") -> str:
    """Names of the entries in which two pieces of plain data differ."""
    if isinstance(first, dict) and isinstance(second, dict):
        keys = [key for key in {**first, **second} if first.get(key) != second.get(key)]
        inner = [differences(first.get(k), second.get(k), f"{name}.{k}".strip(".")) for k in keys]
        return ", ".join(inner)
    return name


def arms(data: Any) -> Iterator[dict[str, Any]]:
    """The arms of a document."""
    if isinstance(data, dict):
        if data.get("type") == "Arm":
            yield data
        for value in data.values():
            yield from arms(value)


def _document(loop: ClosedLoop, largest: int | None = None) -> dict[str, Any]:
    data = describe(loop, largest)
    del data["type"]
    arm = data.pop("arm")
    return {"arm": _tidy(arm, None), **_tidy(data, arm)}


def _tidy(data: Any, arm: Any) -> Any:
    """Data without what is None or equals the true arm."""
    if isinstance(data, Mapping):
        return {k: _tidy(v, arm) for k, v in data.items() if v is not None and v != arm}
    return [_tidy(item, arm) for item in data] if isinstance(data, list) else data


def _check(part: Any, hint: Any, name: str, largest: int | None = None) -> None:
    """Refuse a part that no document can describe."""
    subject = f"{name} of the experiment"
    if isinstance(part, np.ndarray) and largest is not None and part.size > largest:
        remedy = "results hold its digest: keep the loop"
        raise ParameterError(subject, f"{part.size} numbers", f"at most {largest}", remedy)
    if part is None or isinstance(part, bool | int | float | str | np.ndarray | np.generic):
        return
    if isinstance(part, list | tuple):
        for i, item in enumerate(part):
            _check(item, element(hint), f"{name}[{i}]", largest)
    elif isinstance(part, Mapping):
        for key, value in part.items():
            _check(value, element(hint), f"{name}.{key}", largest)
    elif type(part) not in choices(hint):
        raise ParameterError(
            subject,
            f"a {type(part).__name__}",
            "a part of ftcfa",
            "a part of your own cannot be written: run its loop with simulate",
        )
    elif isinstance(part, Arm):
        _check_arm(part, subject)
    else:
        kind: Any = type(part)
        hints = _hints(kind)
        for field in dataclasses.fields(part):
            inner = field.name if name == "loop" else f"{name}.{field.name}"
            _check(getattr(part, field.name), hints[field.name], inner, largest)


@cache
def _hints(part: Any) -> dict[str, Any]:
    """Types of the fields of a part, by name."""
    return get_type_hints(part)


def _check_arm(arm: Arm, subject: str) -> None:
    """Refuse an Arm that is not what its source gives when it is loaded again."""
    if arm.source is None:
        got = f"{arm!r}, made by hand"
        raise ParameterError(subject, got, "an Arm that load_arm gave")
    if not is_as_loaded(arm):
        raise ParameterError(
            subject,
            f"{arm!r}, which is no longer what {arm.source['robot']} gives",
            "an Arm as load_arm gave it",
            "load it again if the file has changed; change it with load_arm's arguments",
        )
