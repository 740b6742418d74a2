"""Velocities from measured positions: what a robot does that measures q alone."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, having, positive, positive_or_infinite
from ftcfa.control.filters import implicit_super_twisting
from ftcfa.control.low_pass import low_pass
from ftcfa.model.dynamics import Dynamics, impulse_response
from ftcfa.parts import Parameters, Part, number_fields

AN_ARM = "an Arm, such as load_arm gives"


class VelocityEstimator(Protocol):
    """Estimates v from sampled positions, in plain NumPy without branches on values."""

    def init(self, q: Traceable) -> Any:
        """State before the first sample: arrays in tuples. q is the first reading, shape (n,)."""
        ...

    def step(
        self, state: Any, q: Traceable, torque: Traceable, period: float
    ) -> tuple[Traceable, Any]:
        """Estimate of v at a sample, shape (n,) [rad/s or m/s], and the new state.

        Args:
            state: The state that `init` or the last step returned.
            q: Measured position, shape (n,) [rad or m].
            torque: Torque that the driver asked of the motors since the last sample, shape (n,)
                [N m or N]: before rounding, delay and lag of the motors.
            period: Time since the last sample [s].
        """
        ...


class Estimate(NamedTuple):
    """State of an estimator."""

    q: Traceable
    """Estimated or last measured position, shape (n,) [rad or m]."""
    v: Traceable
    """Estimated velocity, shape (n,) [rad/s or m/s]."""


class AtRest:
    """Base of the estimators that take an arm for at rest before the first sample."""

    def init(self, q: Traceable) -> Estimate:
        """The first reading, and no velocity."""
        return Estimate(q, np.zeros_like(q))


@dataclass(frozen=True, eq=False)
class BackwardDifference(AtRest, Part):
    """Backward difference of the readings with a first-order low-pass.

        v' = 2 pi bandwidth ((q_k - q_{k-1})/h - v)

    Attributes:
        bandwidth: Corner frequency of the low-pass [Hz]; infinite for none.
    """

    bandwidth: Annotated[float, Check(positive_or_infinite, "Hz")] = np.inf

    varies: ClassVar[Parameters] = number_fields("bandwidth")

    def step(
        self, state: Estimate, q: Traceable, torque: Traceable, period: float
    ) -> tuple[Traceable, Estimate]:
        """See `VelocityEstimator.step`."""
        v = low_pass(state.v, (q - state.q) / period, self.bandwidth, period)
        return v, Estimate(q, v)


@dataclass(frozen=True, eq=False)
class Levant(AtRest, Part):
    """Levant's differentiator, a finite-time observer that needs no model (1998, Automatica 34).

        x1' = x2 - r1 sig(x1 - q, 1/2),   x2' = -r2 sign(x1 - q),   v = x2
        r1 = 1.5 sqrt(L),  r2 = 1.1 L

    x2 converges to q' in finite time where |q''| stays below L and q is exact. Sampled by
    `ftcfa.control.filters.implicit_super_twisting`, so that it does not chatter.

    Attributes:
        L: Bound of the acceleration |q''| [rad/s^2 or m/s^2]. A larger L follows faster and passes
            more of the noise.
    """

    L: Annotated[float, Check(positive, "rad/s^2")] = 100.0

    varies: ClassVar[Parameters] = number_fields("L")

    def step(
        self, state: Estimate, q: Traceable, torque: Traceable, period: float
    ) -> tuple[Traceable, Estimate]:
        """See `VelocityEstimator.step`."""
        return _corrected(state.q, state.v, q, self.L, period)


def predicted(
    arm: Dynamics, state: Estimate, torque: Traceable, period: float
) -> tuple[Traceable, Traceable]:
    """Q and v one period later by the nominal arm, shape (n,) each.

    v+ = v + (M + h D)^-1 h (u - C v - h - f),   q+ = q + h (v + v+)/2
    """
    force = torque - arm.bias_force(state.q, state.v)
    change = impulse_response(arm, state.q, state.v, period * force, period)
    return state.q + period * (state.v + change / 2.0), state.v + change


def _corrected(
    q_hat: Traceable, v_hat: Traceable, q: Traceable, L: float, period: float
) -> tuple[Traceable, Estimate]:
    """One super-twisting step of an estimate towards a reading."""
    root = np.sqrt(L)
    error, v = implicit_super_twisting(q_hat - q, v_hat, 1.5 * root, 1.1 * L, period)
    return v, Estimate(q + error, v)


@dataclass(frozen=True, eq=False)
class ModelObserver(AtRest, Part):
    """Super-twisting observer with the nominal arm (Davila, Fridman, Levant 2005, IEEE TAC 50).

        x1' = x2 - r1 sig(x1 - q, 1/2),   x2' = M^-1 (u - C x2 - h - f) - r2 sign(x1 - q)

    with r1 and r2 as in `Levant`. L has to bound what the model does not know: the base's
    acceleration and the error of the nominal arm, not q'' itself.

    Attributes:
        nominal: The arm as the controller knows it.
        L: Bound of the unknown acceleration [rad/s^2 or m/s^2].
    """

    nominal: Annotated[Dynamics, Check(having("mass_matrix", AN_ARM))]
    L: Annotated[float, Check(positive, "rad/s^2")] = 30.0

    varies: ClassVar[Parameters] = number_fields("L")

    def step(
        self, state: Estimate, q: Traceable, torque: Traceable, period: float
    ) -> tuple[Traceable, Estimate]:
        """See `VelocityEstimator.step`."""
        q_free, v_free = predicted(self.nominal, state, torque, period)
        free = q_free - period * v_free  # the correction moves it with v_free once more
        return _corrected(free, v_free, q, self.L, period)


@dataclass(frozen=True, eq=False)
class Kalman(AtRest, Part):
    """Steady Kalman filter around the nominal arm's prediction, joint by joint.

        x+ = predicted x + (a, b/h) (q - predicted q)

    with the gains of the filter of q'' = white noise of the density ``acceleration`` that is held
    for a period, read with the standard deviation ``noise`` (Kalata 1984, IEEE Trans. AES 20):

        s = acceleration h^2/(sqrt(h) noise),   r = (4 + s - sqrt(8 s + s^2))/4
        a = 1 - r^2,   b = 2 (2 - a) - 4 sqrt(1 - a)

    Attributes:
        nominal: The arm as the controller knows it.
        acceleration: Root of the two-sided density of the unknown acceleration [rad/s^2/sqrt(Hz)].
        noise: Standard deviation of a reading [rad or m]; resolution/sqrt(12) for an encoder.
    """

    nominal: Annotated[Dynamics, Check(having("mass_matrix", AN_ARM))]
    acceleration: Annotated[float, Check(positive, "rad/s^2/sqrt(Hz)")] = 1.0
    noise: Annotated[float, Check(positive, "rad")] = 1e-5

    varies: ClassVar[Parameters] = number_fields("acceleration", "noise")

    def step(
        self, state: Estimate, q: Traceable, torque: Traceable, period: float
    ) -> tuple[Traceable, Estimate]:
        """See `VelocityEstimator.step`."""
        q_free, v_free = predicted(self.nominal, state, torque, period)
        index = self.acceleration * period**1.5 / self.noise
        r = (4.0 + index - np.sqrt(8.0 * index + index**2)) / 4.0
        a = 1.0 - r**2
        b = 2.0 * (2.0 - a) - 4.0 * np.sqrt(1.0 - a)
        error = q - q_free
        v = v_free + b / period * error
        return v, Estimate(q_free + a * error, v)
