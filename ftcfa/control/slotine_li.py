"""Adaptive control of the inertial parameters (Slotine and Li 1987)."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol, cast

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields, positive
from ftcfa.control.filters import leaky_step
from ftcfa.control.ftcf import Gains
from ftcfa.control.protocol import Desired, Signals
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Parameters, number_fields

ADAPTATION_SCALE = 9.81
"""Acceleration g that turns the rate of adaptation into the gain gamma [m/s^2]."""


class LinearInParameters(Dynamics, Protocol):
    """An arm that knows how its torque depends on its inertial parameters, as `Arm` does."""

    @property
    def inertial_weights(self) -> Array:
        """See `Arm.inertial_weights`."""
        ...

    def coriolis_matrix(self, q: Array, v: Array) -> Array:
        """See `Arm.coriolis_matrix`."""
        ...

    def regressor(self, q: Array, v: Array, wanted: Array, acceleration: Array) -> Array:
        """See `Arm.regressor`."""
        ...


def check_linear(subject: str, nominal: Any) -> None:
    """Raise ParameterError unless the nominal arm has a regressor."""
    if not hasattr(nominal, "regressor"):
        got = f"a {type(nominal).__name__}"
        raise ParameterError(subject, got, "an Arm, such as load_arm gives")


class SlotineLiState(NamedTuple):
    """State of the controller."""

    deviation: Array
    """Estimated less nominal inertial parameters of the N bodies, shape (10 N,)."""


@dataclass(frozen=True, eq=False)
class SlotineLi:
    """Adaptive control that keeps the arm passive (Slotine and Li 1987, Int. J. Robot. Res. 6).

        v_r = q_d' - a1 (q - q_d),   s = v - v_r
        u = M v_r' + C(q, v) v_r + h + f(v_r) + Y(q, v, v_r, v_r') d - a2 M s
        d' = -sigma d - gamma W Y^T s

    M, C and h are those of the nominal arm, Y p = M v_r' + C v_r + h holds for any inertial
    parameters p, and d is what the estimate of p differs by from the nominal. With
    V = s^T M_true s/2 + (d - d*)^T W^-1 (d - d*)/(2 gamma) and no leakage,
    V' = -a2 s^T M s. The leakage sigma (Ioannou and Kokotovic 1984, Automatica 20) keeps d bounded
    under noise and saturation, and draws it back to the nominal; nothing keeps the estimate that of
    a possible body.

    W scales every body's parameters by its own mass and size (`Arm.inertial_weights`), so that
    gamma means the same on any arm: an unmodelled weight is learnt at about the rate
    gamma g^2/a2. That rate is a tenth of a1 by default, and the leakage a hundredth.

    Attributes:
        nominal: The arm as the controller believes it to be; it must have a regressor, as an Arm
            does.
        position_rate: a1 [1/s].
        velocity_rate: a2 [1/s].
        adaptation_rate: gamma g^2/a2 [1/s].
        leakage: sigma [1/s].
    """

    nominal: Annotated[Dynamics, Check(check_linear)]
    position_rate: Annotated[float, Check(positive, "1/s")] = Gains().position_rate
    velocity_rate: Annotated[float, Check(positive, "1/s")] = Gains().velocity_rate
    adaptation_rate: Annotated[float, Check(positive, "1/s")] = Gains().position_rate / 10.0
    leakage: Annotated[float, Check(positive, "1/s")] = Gains().position_rate / 100.0

    varies: ClassVar[Parameters] = number_fields(
        "position_rate", "velocity_rate", "adaptation_rate", "leakage"
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def _arm(self) -> LinearInParameters:
        return cast(LinearInParameters, self.nominal)

    def init(self, q: Array, v: Array, desired: Desired) -> SlotineLiState:  # noqa: ARG002
        """The nominal parameters."""
        return SlotineLiState(np.zeros_like(self._arm.inertial_weights))

    def step(
        self, state: SlotineLiState, q: Array, v: Array, desired: Desired, period: float
    ) -> tuple[Signals, SlotineLiState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        arm, d = self._arm, state.deviation
        z1 = q - desired.q
        wanted = desired.v - self.position_rate * z1
        acceleration = desired.a - self.position_rate * (v - desired.v)
        s = v - wanted
        Y = arm.regressor(q, v, wanted, acceleration)  # (n, 10 N)
        M = arm.mass_matrix(q)
        nominal = (
            M @ (acceleration - self.velocity_rate * s)
            + arm.coriolis_matrix(q, v) @ wanted
            + arm.potential_force(q)
            + arm.damping_matrix(wanted) @ wanted
        )
        gamma = self.adaptation_rate * self.velocity_rate / ADAPTATION_SCALE**2
        learning = -gamma * arm.inertial_weights * (Y.T @ s)
        new = SlotineLiState(leaky_step(d, self.leakage, learning, period))
        return {"u": nominal + Y @ d, "z1": z1, "s": s, "deviation": d}, new
