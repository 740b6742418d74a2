"""PD control with gravity compensation, the usual controller of a robot without a model."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ftcfa.control.gains import A1, A2, PositionRate, VelocityRate
from ftcfa.control.protocol import Desired, Measured, MemorylessLaw, Quantities, Quantity, Signals
from ftcfa.parts import Parameters, checked_fields


@dataclass(frozen=True, eq=False)
class PDGravity(MemorylessLaw):
    """PD control of every joint and compensation of gravity (Takegaki and Arimoto 1981).

        u = h(q) - D (a1 a2 (q - q_d) + (a1 + a2) (v - q_d')),   D = diag M(home)

    With all other joints held at home, each joint has the poles -a1 and -a2. Source: ASME J.
    Dyn. Syst. Meas. Control 103.

    Attributes:
        nominal: The arm as the controller knows it.
        position_rate: a1 [1/s].
        velocity_rate: a2 [1/s].
    """

    quantities: ClassVar[Quantities] = {"z1": Quantity("rad", "tracking error")}

    position_rate: PositionRate = A1
    velocity_rate: VelocityRate = A2

    per_joint: ClassVar = ("position_rate", "velocity_rate")
    varies: ClassVar[Parameters] = checked_fields(*per_joint)

    def signals(self, measured: Measured, desired: Desired) -> Signals:
        """The signals of one sample: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        a1, a2 = self.position_rate, self.velocity_rate
        z1, dz1 = q - desired.q, v - desired.v
        D = self.nominal.mass_matrix(self.nominal.home) * np.eye(self.nominal.n)
        u = self.nominal.potential_force(q) - D @ (a1 * a2 * z1 + (a1 + a2) * dz1)
        return {"u": u, "z1": z1}
