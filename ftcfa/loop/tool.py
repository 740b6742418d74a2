"""How far the tool is from where it should be: signals of every loop whose arm has frames."""

from typing import Any

from ftcfa.arrays import Traceable
from ftcfa.model.abstract_arm import AbstractArm
from ftcfa.model.pose import angle, distance


def tool_signals(arm: Any, q: Traceable, q_d: Traceable) -> dict[str, Traceable]:
    """Signals tool_error [m] and tool_angle_error [rad], shape (1,) each.

    A robot that is no `Arm` has none.

    Args:
        arm: The arm or its twin.
        q: Position, shape (n,) [rad or m].
        q_d: Desired position, shape (n,) [rad or m].
    """
    if not isinstance(arm, AbstractArm):
        return {}
    tool, desired = arm.pose(q), arm.pose(q_d)
    return {"tool_error": distance(tool, desired), "tool_angle_error": angle(tool, desired)}
