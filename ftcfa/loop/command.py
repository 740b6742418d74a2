"""What a controller commands, checked, and the signals that every loop has."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftcfa.control.protocol import Controller, Desired, Measured, Quantity, Signals
from ftcfa.errors import ParameterError, ShapeError

LOOP_QUANTITIES: Mapping[str, Quantity] = {
    "q": Quantity("rad", "position"),
    "q_d": Quantity("rad", "desired position"),
    "v": Quantity("rad/s", "velocity"),
    "u": Quantity("N m", "torque that acts, within the effort limits"),
    "u_command": Quantity("N m", "torque that the controller commands"),
    "u_wanted": Quantity("N m", "the same within the effort limits"),
    "tool_error": Quantity("m", "distance of the tool from where the reference wants it"),
    "tool_angle_error": Quantity("rad", "angle between the tool and its desired orientation"),
}
"""Unit and meaning of the signals that every loop has, those of the tool if its arm has frames; for
prismatic joints m replaces rad."""


def commanded(
    law: Controller, state: Any, measured: Measured, desired: Desired, period: float
) -> tuple[Signals, Any]:
    """Signals and new state of a law.

    Raises:
        ParameterError: If its `step` returns something else.
        ShapeError: If its torque has another shape than q.
    """
    given = law.step(state, measured, desired, period)
    pair = isinstance(given, tuple) and len(given) == 2
    if not (pair and isinstance(given[0], dict) and "u" in given[0]):
        subject = f"step of {type(law).__name__}"
        got = f"a {type(given).__name__} without a dictionary that holds 'u'"
        raise ParameterError(subject, got, '({"u": torque, ...}, state)')
    command = given[0]["u"]
    shape = command.shape if hasattr(command, "shape") else np.shape(command)
    if shape != measured.q.shape:
        raise ShapeError("u of the controller", f"shape {shape}", f"{measured.q.shape}")
    return given
