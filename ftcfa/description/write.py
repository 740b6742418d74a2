"""A closed loop as plain data: what results remember, files hold and other machines receive."""

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

import numpy as np

from ftcfa.description.registry import arm_loader, choices, element, parameters
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.model.urdf.description import read_urdf

LARGE = 10_000
"""Entries above which results remember an array by its digest."""
COMPARED = ("G", "g0", "effort_limit", "damping", "friction", "inertias")
"""What must be the same when an Arm is loaded again."""


def describe(part: Any, largest: int | None = None) -> Any:
    """Any part of an experiment as numbers, strings, lists and dictionaries.

    An Arm becomes what loaded it; any other dataclass its type, where that is not obvious, and
    fields. What cannot be shown goes by its type.

    Args:
        part: The part.
        largest: Arrays of more entries go by their shape and SHA-256; None tells them all.
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
    told = {}
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        told[field.name] = describe(value, largest)
        hint = get_args(field.type)[0] if get_origin(field.type) is Annotated else field.type
        allowed = [t for t in get_args(hint) or (hint,) if t is not NoneType]
        if dataclasses.is_dataclass(value) and allowed == [type(value)]:
            del told[field.name]["type"]  # it is obvious
    return told


def document(loop: ClosedLoop) -> dict[str, Any]:
    """A loop as data from which `ftcfa.description.read` makes the same one, bit for bit.

    What is None is left out, and so is a nominal arm that is the true one.

    Raises:
        ParameterError: If a part is a user's own, or an Arm was changed after it was loaded.
    """
    _check(loop, ClosedLoop, "loop")
    told = describe(loop)
    arm = told["arm"]
    del told["type"]
    return {"arm": _tidy(told.pop("arm"), None), **_tidy(told, arm)}


def self_contained(told: Mapping[str, Any]) -> dict[str, Any]:
    """A document that needs no file of this machine: texts in place of the paths of URDFs."""
    whole = _tidy(told, None)  # a copy
    for arm in arms(whole):
        if has_path(arm):
            path = Path(arm["robot"])
            arm |= {"robot": path.name, "urdf": read_urdf(path).text}
    return whole


def provenance(loop: ClosedLoop) -> dict[str, Any]:
    """What results remember of their loop: all of it, or what can be told of a user's own parts."""
    try:
        return self_contained(document(loop))
    except ParameterError:
        return describe(loop)


def differences(found: Any, told: Any, name: str = "") -> str:
    """Names of the entries in which two pieces of plain data differ."""
    if isinstance(found, dict) and isinstance(told, dict):
        keys = [key for key in {**found, **told} if found.get(key) != told.get(key)]
        inner = [differences(found.get(k), told.get(k), f"{name}.{k}".strip(".")) for k in keys]
        return ", ".join(inner)
    return name


def arms(told: Any) -> Iterator[dict[str, Any]]:
    """The arms that a document tells of."""
    if isinstance(told, dict):
        if told.get("type") == "Arm":
            yield told
        for value in told.values():
            yield from arms(value)


def has_path(arm: Mapping[str, Any]) -> bool:
    """Whether an arm is told by the path of its URDF, not by its text or a name we know."""
    return "urdf" not in arm and arm["robot"] not in catalogue()


def _tidy(told: Any, arm: Any) -> Any:
    """Data without what is None or equals the true arm."""
    if isinstance(told, Mapping):
        return {k: _tidy(v, arm) for k, v in told.items() if v is not None and v != arm}
    return [_tidy(item, arm) for item in told] if isinstance(told, list) else told


def _check(part: Any, hint: Any, name: str) -> None:
    """Refuse a part that no document can tell."""
    if part is None or isinstance(part, bool | int | float | str | np.ndarray | np.generic):
        return
    if isinstance(part, list | tuple):
        for i, item in enumerate(part):
            _check(item, element(hint), f"{name}[{i}]")
    elif isinstance(part, Mapping):
        for key, value in part.items():
            _check(value, element(hint), f"{name}.{key}")
    elif type(part) not in choices(hint):
        raise ParameterError(
            f"{name} of the experiment",
            f"a {type(part).__name__}",
            "a part of ftcfa",
            "a part of your own cannot be written: run its loop with simulate",
        )
    elif isinstance(part, Arm):
        _check_arm(part, name)
    else:
        for field, (inner, _) in parameters(type(part)).items():
            _check(getattr(part, field), inner, field if name == "loop" else f"{name}.{field}")


def _check_arm(arm: Arm, name: str) -> None:
    """Refuse an Arm that is not what its source gives when it is loaded again."""
    if arm.source is None:
        raise ParameterError(
            f"{name} of the experiment", f"{arm!r}, made by hand", "an Arm that load_arm gave"
        )
    loader, _ = arm_loader(arm.source)
    again = loader(**arm.source)
    was, is_now = ([*(getattr(a, key) for key in COMPARED), *_constants(a)] for a in (again, arm))
    if not all(map(np.array_equal, was, is_now)):
        raise ParameterError(
            f"{name} of the experiment",
            f"{arm!r}, which is no more what {arm.source['robot']} gives",
            "an Arm as load_arm gave it",
            "load it again if the file has changed; change it with load_arm's arguments",
        )


def _constants(arm: Arm) -> tuple[Any, ...]:
    tree = arm.tree()
    return tree.parents, tree.rotations, tree.translations, tree.axes, tree.gravity
