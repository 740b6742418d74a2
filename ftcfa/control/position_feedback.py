"""Stochastic tracking from positions alone: the optimal feedback of an estimated error."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, positive
from ftcfa.control.gains import A1, A2, PositionRate, VelocityRate
from ftcfa.control.protocol import Desired, Law, Measured, Quantities, Quantity, Signals
from ftcfa.model.dynamics import inertial_force
from ftcfa.parts import Parameters, checked_fields, number_fields

UNKNOWN = 1.0
"""Variance of the first position before it is read [rad^2 or m^2]: large beside any encoder's."""


class ErrorEstimate(NamedTuple):
    """State of the law: the tracking error that it expects at the next sample."""

    z1: Traceable
    """Mean of the position error, shape (n,) [rad or m]."""
    dz1: Traceable
    """Mean of the velocity error, shape (n,) [rad/s or m/s]."""
    P11: Traceable
    """Variance of the position error, the same in every joint, shape () [rad^2]."""
    P12: Traceable
    """Covariance of position and velocity error, shape () [rad^2/s]."""
    P22: Traceable
    """Variance of the velocity error, shape () [rad^2/s^2]."""


@dataclass(frozen=True, eq=False)
class PositionFeedback(Law):
    """Linear-quadratic-Gaussian tracking without joint velocities.

    Saab and Ghanem (2018, IEEE TAC 63) track from noisy positions alone, with a gain that is
    computed recursively so that the covariance of the error is least. Their recursion is not
    printed here; this law is derived from the same aim. Through the nominal dynamics the error
    of each joint is z'' = a + w, read as z + r, with white w and r. The feedback

        u = M(q) (q_d'' + a) + C v_hat + h + f,   a = -a1 a2 z_hat - (a1 + a2) z_hat',
        v_hat = q_d' + z_hat'

    of the estimate z_hat then has the least E[(a1 a2 z)^2 + (a1^2 + a2^2) z'^2 + a^2] of all
    feedbacks of the readings (separation theorem; the Riccati equation of the double integrator).
    The estimate and its covariance P are those of the Kalman filter of a w that is held for a
    period h,

        K = P e1 / (P_11 + noise^2)
        P+ = F (P - K e1^T P) F^T + acceleration^2 h (h/2, 1)^T (h/2, 1),   F = (1 h; 0 1)

    which starts at the first reading with v = 0 to within `speed`. Measured velocities are not
    used. The gains of the feedback are those of continuous time. The estimate takes it that the
    torque acts as asked: it does not know of limits, delays and lags of the motors.

    Attributes:
        nominal: The arm as the controller knows it.
        position_rate: a1 [1/s].
        velocity_rate: a2 [1/s].
        acceleration: Root of the two-sided density of w, what the nominal arm does not know
            [rad/s^2/sqrt(Hz)].
        noise: Standard deviation of r [rad or m]; resolution/sqrt(12) for an encoder.
        speed: Standard deviation of v at the first reading [rad/s or m/s].
    """

    quantities: ClassVar[Quantities] = {
        "z1": Quantity("rad", "estimated tracking error"),
        "dz1": Quantity("rad/s", "estimated velocity error"),
    }

    position_rate: PositionRate = A1
    velocity_rate: VelocityRate = A2
    acceleration: Annotated[float, Check(positive, "rad/s^2/sqrt(Hz)", (0.03, 300.0))] = 1.0
    noise: Annotated[float, Check(positive, "rad")] = 1e-5
    speed: Annotated[float, Check(positive, "rad/s")] = 1.0

    per_joint: ClassVar = ("position_rate", "velocity_rate")
    varies: ClassVar[Parameters] = {
        **checked_fields(*per_joint),
        **number_fields("acceleration", "noise", "speed"),
    }

    def init(self, measured: Measured, desired: Desired) -> ErrorEstimate:
        """The arm at rest, somewhere near its first reading."""
        unknown, uncorrelated = np.full((), UNKNOWN), np.zeros(())
        z1, dz1 = measured.q - desired.q, -desired.v
        return ErrorEstimate(z1, dz1, unknown, uncorrelated, unknown * self.speed**2)

    def step(
        self, state: ErrorEstimate, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, ErrorEstimate]:
        """One sample of the law: see `ftcfa.control.protocol.Controller.step`."""
        q, h = measured.q, period
        _, _, P11, P12, P22 = state
        total = P11 + self.noise**2
        innovation = q - desired.q - state.z1
        z1 = state.z1 + P11 / total * innovation
        dz1 = state.dz1 + P12 / total * innovation
        P22 = P22 - P12**2 / total
        P11, P12 = P11 * self.noise**2 / total, P12 * self.noise**2 / total

        a1, a2 = self.position_rate, self.velocity_rate
        a = -(a1 + a2) * dz1 - a1 * a2 * z1
        force = self.known_force("bias", q, desired.v + dz1, desired.v)
        u = inertial_force(self.nominal, q, desired.a + a) + force

        w = self.acceleration**2 * h
        expected = ErrorEstimate(
            z1 + h * dz1 + h**2 / 2.0 * a,
            dz1 + h * a,
            P11 + 2.0 * h * P12 + h**2 * P22 + h**2 / 4.0 * w,
            P12 + h * P22 + h / 2.0 * w,
            P22 + w,
        )
        return {"u": u, "z1": z1, "dz1": dz1}, expected
