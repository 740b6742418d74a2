"""A small loop that is quick to tune."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ComputedTorque,
    Sinusoid,
    Uncertainty,
    Vibration,
    WhiteNoise,
    load_arm,
)
from ftcfa.checks import Check, positive
from ftcfa.control.protocol import MemorylessLaw
from ftcfa.parts import Parameters, number_fields

ARM = load_arm("double_pendulum")
SHAKEN = Vibration(BaseAcceleration(), WhiteNoise(0.1))
BUDGET = {"generations": 3, "candidates": 6, "paths": 4}


def loop(law=None, **changes):
    """The double pendulum, whose base shakes."""
    parts = {
        "controller": law or ComputedTorque(ARM, 3.0, 5.0),
        "reference": Sinusoid([0.4, 0.3], 2.0),
        "vibration": SHAKEN,
        "q0": [0.1, -0.1],
        "uncertainty": Uncertainty(mass=0.1),
    }
    return ClosedLoop(ARM, **{**parts, **changes})


def paper(**changes):
    """The same under the paper's law with its bias compensated."""
    return loop(FTCF(ARM, compensation="bias"), **changes)


@dataclass(frozen=True, eq=False)
class Spring(MemorylessLaw):
    """A law of one's own: u = h - stiffness (q - q_d) - damping (v - q_d')."""

    stiffness: Annotated[float, Check(positive, "N m/rad", (1.0, 1000.0))] = 10.0
    damping: Annotated[float, Check(positive, "N m s/rad", (0.1, 100.0))] = 1.0
    unused: Annotated[float, Check(positive, "", (1.0, 2.0))] = 1.0
    fixed: Annotated[float, Check(positive)] = 1.0

    varies: ClassVar[Parameters] = number_fields("stiffness", "damping", "unused", "fixed")

    def signals(self, measured: Any, desired: Any) -> Any:
        """The signals of one sample."""
        q, v = measured.q, measured.v
        u = self.nominal.potential_force(q) - self.stiffness * (q - desired.q)
        return {"u": self.fixed * (u - self.damping * (v - desired.v)), "one": np.ones(1)}
