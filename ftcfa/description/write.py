"""A closed loop as plain data: what results remember, files hold and other machines receive."""

import dataclasses
import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ftcfa.description.hints import alternatives, arguments, choices, element
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.description import read_urdf
from ftcfa.model.urdf.load import has_path, is_as_loaded

LARGE = 1_000_000
"""Entries above which results remember an array by its digest; 20 MB as text."""
NOT_REBUILDABLE = "not_rebuildable"
"""Key under which results say why no loop can be made of what they remember."""
Robot = Callable[[Path], Mapping[str, str]]
"""How the path of a URDF is written: as arguments that load its arm."""


def as_text(path: Path) -> Mapping[str, str]:
    """The text of a URDF, so that its file is not needed."""
    return {"robot": path.name, "urdf": read_urdf(path).text}


def document(whole: Any, robot: Robot = as_text) -> dict[str, Any]:
    """A document from which `ftcfa.description.read.rebuild` makes the same loop, bit for bit.

    What is None is left out, and so is a nominal arm that is the true one.

    Args:
        whole: A `ClosedLoop`, or a dataclass with a field ``loop``, whose other fields stand in
            the document beside those of the loop.
        robot: How the path of a URDF is written; `as_text` needs no file of this machine.

    Raises:
        ParameterError: If a part is a user's own, or an Arm was changed after it was loaded.
    """
    writer = _Writer(robot)
    data = writer.whole(whole)
    if writer.reasons:
        raise writer.reasons[0]
    return data


def provenance(loop: ClosedLoop) -> dict[str, Any]:
    """What results remember of their loop: a `document` that needs no file of this machine.

    Where no loop can be made of it (a part is a user's own, an Arm was changed by hand, an array
    has more than `LARGE` entries), the entry `NOT_REBUILDABLE` says why, and the document shows
    what can be shown.
    """
    writer = _Writer(as_text, LARGE)
    data = writer.whole(loop)
    return {NOT_REBUILDABLE: str(writer.reasons[0]), **data} if writer.reasons else data


def differences(first: Any, second: Any, name: str = "") -> str:
    """Names of the entries in which two pieces of plain data differ."""
    if isinstance(first, dict) and isinstance(second, dict):
        keys = [key for key in {**first, **second} if first.get(key) != second.get(key)]
        inner = [differences(first.get(k), second.get(k), f"{name}.{k}".strip(".")) for k in keys]
        return ", ".join(inner)
    return name


class _Writer:
    """Writes parts as data, with the reasons for which a part cannot be made of its data again.

    Args:
        robot: How the path of a URDF is written.
        largest: Arrays of more entries become their shape and SHA-256; None writes all out.
    """

    def __init__(self, robot: Robot, largest: int | None = None) -> None:
        self.robot, self.largest = robot, largest
        self.arm: Any = None
        self.reasons: list[ParameterError] = []

    def whole(self, whole: Any) -> dict[str, Any]:
        """A loop, or what has a field ``loop``, as a document."""
        self.arm = self.write(getattr(whole, "loop", whole).arm, Dynamics, "arm")
        data = self.write(whole, type(whole), "")
        loop = data.pop("loop", {})
        return {"arm": self.arm, **data, **loop}

    def write(self, part: Any, hint: Any, name: str) -> Any:
        """A part, or an entry of one, as data, by its type hint and its name in reasons."""
        if part is None or isinstance(part, bool | int | float | str):
            return part
        if isinstance(part, np.ndarray) and self.largest is not None and part.size > self.largest:
            remedy = "results hold its digest: keep the loop"
            self.refuse(name, f"{part.size} numbers", f"at most {self.largest}", remedy)
            digest = hashlib.sha256(np.ascontiguousarray(part).tobytes()).hexdigest()
            return {"type": "array", "shape": list(part.shape), "sha256": digest}
        if isinstance(part, np.ndarray | np.generic):
            return part.tolist()
        if isinstance(part, list | tuple):
            inner = element(hint)
            return [self.write(item, inner, f"{name}[{i}]") for i, item in enumerate(part)]
        if isinstance(part, Mapping):
            inner = element(hint)
            return {str(k): self.write(item, inner, f"{name}.{k}") for k, item in part.items()}
        return self.part(part, hint, name)

    def part(self, part: Any, hint: Any, name: str) -> dict[str, Any]:
        """A part by its type, where that is not obvious from its hint, and its fields."""
        kind: Any = type(part)
        known = kind in choices(hint)
        if not known:
            remedy = "a part of your own cannot be written: run its loop with simulate"
            self.refuse(name, f"a {kind.__name__}", "a part of ftcfa", remedy)
        if isinstance(part, Arm):
            return {"type": "Arm", **self.source(part, name)}
        data = {} if known and alternatives(hint) == (kind,) else {"type": kind.__name__}
        if dataclasses.is_dataclass(part):
            hints = arguments(kind) if known else {}
            for field in dataclasses.fields(part):
                inner = f"{name}.{field.name}".strip(".")
                value = self.write(getattr(part, field.name), hints.get(field.name), inner)
                if value is not None and value != self.arm:
                    data[field.name] = value
        return data

    def source(self, arm: Arm, name: str) -> dict[str, Any]:
        """The arguments that load an Arm again."""
        if arm.source is None:
            self.refuse(name, f"{arm!r}, made by hand", "an Arm that load_arm gave")
            return {"robot": arm.name}
        if not is_as_loaded(arm):
            self.refuse(
                name,
                f"{arm!r}, which is no longer what {arm.source['robot']} gives",
                "an Arm as load_arm gave it",
                "load it again if the file has changed; change it with load_arm's arguments",
            )
        path = self.robot(Path(arm.source["robot"])) if has_path(arm.source) else {}
        return {**arm.source, **path}

    def refuse(self, name: str, got: str, expected: str, remedy: str = "") -> None:
        """Add a reason."""
        subject = f"{name.removeprefix('loop.')} of the experiment"
        self.reasons.append(ParameterError(subject, got, expected, remedy))
