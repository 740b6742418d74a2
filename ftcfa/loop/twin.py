"""The twin of a loop for tracing: every Arm in its parts replaced by one that takes symbols."""

from typing import Any

from ftcfa.model.arm import Arm
from ftcfa.model.twins import traced
from ftcfa.parts import fields_of, with_fields


def twin(part: Any) -> Any:
    """A copy of a loop or a part in which every Arm is its `TracedArm`.

    Arms are looked for in the fields of dataclasses and NamedTuples, and in tuples and lists.

    Raises:
        TracingError: If a traced Arm disagrees with Pinocchio.
    """
    if isinstance(part, Arm):
        return traced(part)
    if type(part) in (list, tuple):
        changed = [twin(value) for value in part]
        same = all(new is old for new, old in zip(changed, part, strict=True))
        return part if same else type(part)(changed)
    twins = {name: (value, twin(value)) for name, value in fields_of(part).items()}
    changes = {name: new for name, (old, new) in twins.items() if new is not old}
    return with_fields(part, changes) if changes else part
