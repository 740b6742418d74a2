"""The loops to which Theorem 1 applies: the paper's whole controller, white noise or none."""

import numpy as np

from ftcfa.control.ftcf import FTCF
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.base_motion import BaseMotion


def ftcf_of(loop: ClosedLoop) -> FTCF:
    """The controller of a loop; ParameterError unless it is the paper's, whatever its parts."""
    law = loop.controller
    if not isinstance(law, FTCF):
        expected = "an FTCF, the only law that Theorem 1 covers"
        raise ParameterError("controller", f"a {type(law).__name__}", expected)
    return law


def paper_law(loop: ClosedLoop) -> FTCF:
    """The controller of a loop, checked to be the paper's with all its parts.

    Raises:
        ParameterError: If it is another law, a part of it is switched off, or a gain differs from
            joint to joint.
    """
    law = ftcf_of(loop)
    for part in ("error_compensation", "adaptation"):
        if not getattr(law, part):
            raise ParameterError(f"controller {part}", "off", "on, as in Theorem 1")
    if law.anti_saturation != "paper":
        got, remedy = repr(law.anti_saturation), "Theorem 1 is about (11) as printed"
        raise ParameterError("controller anti_saturation", got, "'paper'", remedy)
    for name in law.gains.per_joint:
        if np.ndim(getattr(law.gains, name)):
            expected = "one number for all joints, as in Theorem 1"
            raise ParameterError(f"controller gains {name}", "a number for each joint", expected)
    return law


def check_white(loop: ClosedLoop) -> None:
    """Raise ParameterError unless the vibration is white noise (Assumption 1) or None."""
    vibration = loop.vibration
    if vibration is None:
        return
    if not isinstance(vibration.excitation, WhiteNoise) or isinstance(vibration.input, BaseMotion):
        raise ParameterError(
            "vibration",
            f"{type(vibration.excitation).__name__} through {type(vibration.input).__name__}",
            "WhiteNoise through an input that depends on q alone, as in Theorem 1",
        )
