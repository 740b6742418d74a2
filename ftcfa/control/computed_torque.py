"""Computed torque: PD control through the inverse of the nominal dynamics."""

from dataclasses import dataclass
from typing import ClassVar

from ftcfa.control.gains import A1, A2, PositionRate, VelocityRate
from ftcfa.control.protocol import Desired, Measured, MemorylessLaw, Quantities, Quantity, Signals
from ftcfa.model.dynamics import inertial_force
from ftcfa.parts import Parameters, checked_fields


@dataclass(frozen=True, eq=False)
class ComputedTorque(MemorylessLaw):
    """PD control through the nominal dynamics (Luh, Walker and Paul 1980, IEEE TAC 25).

        u = M(q) (q_d'' - (a1 + a2) (v - q_d') - a1 a2 (q - q_d)) + C v + h + f

    so that the nominal error obeys e'' + (a1 + a2) e' + a1 a2 e = 0, with the poles -a1 and -a2.
    Friction is taken at the desired velocity.

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
        a = desired.a - (a1 + a2) * dz1 - a1 * a2 * z1
        force = self.known_force("bias", q, v, desired.v)
        return {"u": inertial_force(self.nominal, q, a) + force, "z1": z1}
