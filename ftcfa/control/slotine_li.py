"""Adaptive control of the inertial parameters (Slotine and Li 1987)."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, having, positive
from ftcfa.control.filters import leaky_step
from ftcfa.control.gains import A1, A2
from ftcfa.control.protocol import Desired, Law, Measured, Quantities, Quantity, Signals
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import inertial_force
from ftcfa.parts import Parameters, number_fields

ADAPTATION_SCALE = 9.81
"""Acceleration g that turns the rate of adaptation into the gain gamma [m/s^2]."""


class SlotineLiState(NamedTuple):
    """State of the controller."""

    deviation: Traceable
    """Estimated less nominal inertial parameters of the N bodies, shape (10 N,)
    [kg, kg m, kg m^2]."""


@dataclass(frozen=True, eq=False)
class SlotineLi(Law):
    """Adaptive control that keeps the arm passive (Slotine and Li 1987, Int. J. Robot. Res. 6).

        v_r = q_d' - a1 (q - q_d),   s = v - v_r
        u = M v_r' + C(q, v) v_r + h + f(v_r) + Y(q, v, v_r, v_r') d - a2 M s
        d' = -sigma d - gamma W Y^T s

    M, C and h are those of the nominal arm, and Y p = M v_r' + C v_r + h holds for any inertial
    parameters p. d is the estimate of p less the nominal p, and d* is the true p less the nominal
    p. With V = s^T M_true s/2 + (d - d*)^T W^-1 (d - d*)/(2 gamma) and no leakage,
    V' = -a2 s^T M s. The leakage sigma (Ioannou and Kokotovic 1984, Automatica 20) keeps d bounded
    under noise and saturation and moves it back to zero. The estimate need not belong to a
    physically possible body.

    While a torque is beyond its limit, d does not learn: the error then says nothing about p. On
    the paper's pendulum, whose nominal arm is exact and whose torque is saturated at the start, a
    law that learned there had an rms error of 2.58 mrad, where computed torque has 1.06 mrad (noise
    0.1 "amplitude"); with this rule it has 1.00 mrad.

    W scales the parameters of each body by its own mass and size (`Arm.inertial_weights`), so that
    gamma means the same on any arm: the law learns an unmodelled weight at about the rate
    gamma g^2/a2, g = ADAPTATION_SCALE. By default that rate is a1/10 and the leakage is a1/100.

    Attributes:
        nominal: The arm as the controller knows it, with a regressor, as an Arm has.
        position_rate: a1 [1/s].
        velocity_rate: a2 [1/s].
        adaptation_rate: gamma g^2/a2 [1/s].
        leakage: sigma [1/s].
    """

    quantities: ClassVar[Quantities] = {
        "z1": Quantity("rad", "tracking error"),
        "s": Quantity("rad/s", "sliding variable v - v_r"),
        "deviation": Quantity(
            "kg, kg m, kg m^2", "estimated less nominal inertial parameters, ten of each body"
        ),
    }

    nominal: Annotated[Arm, Check(having("regressor", "an Arm, such as load_arm gives"))]
    position_rate: Annotated[float, Check(positive, "1/s", (0.3, 300.0))] = A1
    velocity_rate: Annotated[float, Check(positive, "1/s", (1.0, 1000.0))] = A2
    adaptation_rate: Annotated[float, Check(positive, "1/s", (1e-3, 100.0))] = A1 / 10.0
    leakage: Annotated[float, Check(positive, "1/s", (1e-4, 100.0))] = A1 / 100.0

    varies: ClassVar[Parameters] = number_fields(
        "position_rate", "velocity_rate", "adaptation_rate", "leakage"
    )

    def init(self, measured: Measured, desired: Desired) -> SlotineLiState:
        """The nominal parameters: d(0) = 0."""
        return SlotineLiState(np.zeros_like(self.nominal.inertial_weights))

    def step(
        self, state: SlotineLiState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, SlotineLiState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        arm, d = self.nominal, state.deviation
        z1 = q - desired.q
        v_r = desired.v - self.position_rate * z1
        a_r = desired.a - self.position_rate * (v - desired.v)
        s = v - v_r
        Y = arm.regressor(q, v, v_r, a_r)  # (n, 10 N)
        nominal = (
            inertial_force(arm, q, a_r - self.velocity_rate * s)
            + arm.coriolis_matrix(q, v) @ v_r
            + arm.potential_force(q)
            + arm.damping_matrix(v_r) @ v_r
        )
        gamma = self.adaptation_rate * self.velocity_rate / ADAPTATION_SCALE**2
        u = nominal + Y @ d
        saturated = np.max(np.abs(u) - arm.effort_limit) > 0.0
        learning = np.where(saturated, 0.0, -gamma * arm.inertial_weights * (Y.T @ s))
        new = SlotineLiState(leaky_step(d, self.leakage, learning, period))
        return {"u": u, "z1": z1, "s": s, "deviation": d}, new
