"""A closed loop as plain data, for the provenance of results."""

import dataclasses
from typing import Any

import numpy as np

from ftcfa.model.arm import Arm


def describe(part: Any) -> Any:
    """Any part of an experiment as numbers, strings, lists and dictionaries.

    An Arm becomes what loaded it; any other dataclass its type and fields.
    """
    if isinstance(part, Arm):
        return {"type": "Arm", **(part.source or {"robot": part.name})}
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        fields = {f.name: describe(getattr(part, f.name)) for f in dataclasses.fields(part)}
        return {"type": type(part).__name__, **fields}
    if isinstance(part, np.ndarray | np.generic):
        return part.tolist()
    if isinstance(part, list | tuple):
        return [describe(item) for item in part]
    if part is None or isinstance(part, bool | int | float | str):
        return part
    return {"type": type(part).__name__}
