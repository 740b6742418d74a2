"""Feed-forward of the base's measured motion, for any law."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, having, numbers, positive_or_infinite
from ftcfa.control.low_pass import low_pass
from ftcfa.control.protocol import (
    A_LAW,
    BaseReading,
    Controller,
    Desired,
    Law,
    Measured,
    Quantity,
    Signals,
    quantities,
)
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.parts import Parameters, Part, number_fields


@dataclass(frozen=True, eq=False)
class Predictor(Part):
    """A steady Kalman predictor of the base's acceleration.

        x+ = A x + K (a - C x),   prediction = P x

    `ftcfa.base_predictor` makes one of the filter of a spectrum.

    Attributes:
        A: Shape (N, N).
        K: Shape (N, 3).
        C: Prediction of the next reading, shape (3, N).
        P: Prediction of the acceleration now, shape (3, N).
    """

    A: npt.ArrayLike
    K: npt.ArrayLike
    C: npt.ArrayLike
    P: npt.ArrayLike

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in "AKCP":
            matrix = numbers(f"Predictor {name}", getattr(self, name), field=name)
            object.__setattr__(self, name, matrix)
        n = len(np.atleast_1d(self.A))
        shapes = [np.shape(getattr(self, name)) for name in "AKCP"]
        if shapes != [(n, n), (n, 3), (3, n), (3, n)]:
            got = f"shapes {', '.join(map(str, shapes))}"
            raise ShapeError("Predictor A, K, C, P", got, "(N, N), (N, 3), (3, N), (3, N)")

    def init(self) -> Array:
        """No motion, shape (N,)."""
        return np.zeros(len(np.asarray(self.A)))

    def step(self, x: Traceable, a: Traceable) -> tuple[Traceable, Traceable]:
        """The acceleration now and the new state, from a reading, shape (3,) [m/s^2]."""
        A, K, C, P = (np.asarray(matrix) for matrix in (self.A, self.K, self.C, self.P))
        x = A @ x + K @ (a - C @ x)
        return P @ x, x


HALF = 0.5


class Turning(NamedTuple):
    """How the base turns."""

    rate: Traceable
    """omega behind the low-pass, shape (3,) [rad/s]."""
    acceleration: Traceable
    """omega' behind it, shape (3,) [rad/s^2]."""
    reading: Traceable
    """Last reading of omega, shape (3,) [rad/s]."""
    slope: Traceable
    """omega' between the last two readings that differ, shape (3,) [rad/s^2]."""
    age: Traceable
    """Samples since the reading changed, shape (1,); -1 before it changes for the first time."""

    @classmethod
    def begun(cls, omega: Traceable) -> "Turning":
        """With the first reading, of which nothing is known yet, shape (3,) [rad/s]."""
        still = np.zeros(3)
        return cls(omega, still, omega, still, np.full(1, -1.0))

    def step(self, omega: Traceable, band: Any, period: float) -> "Turning":
        """One sample later; omega' is the change of a reading over the time since the last one.

        A reading may be held for some samples. The first change says nothing of omega': before it
        the reading may be that of a base at rest.
        """
        changed = np.max(np.abs(omega - self.reading)) > 0.0
        known = np.max(self.age) > -HALF
        slope = (omega - self.reading) / (period * np.maximum(self.age + 1.0, 1.0))
        slope = np.where(np.logical_and(changed, known), slope, self.slope)
        age = np.where(changed, 0.0, np.where(known, self.age + 1.0, self.age))
        rate = np.where(known, low_pass(self.rate, omega, band, period), omega)
        acceleration = low_pass(self.acceleration, slope, band, period)
        return Turning(rate, acceleration, omega, slope, age)


class FeedForwardState(NamedTuple):
    """State of a law with feed-forward."""

    law: Any
    """State of the law."""
    acceleration: Traceable
    """Acceleration of the base behind the low-pass, shape (3,) [m/s^2]."""
    turning: Any = ()
    """How the base turns; empty without a gyroscope."""
    prediction: Any = ()
    """State of the predictor; empty without one."""


@dataclass(frozen=True, eq=False)
class FeedForward(Law):
    """A law that also cancels the load of the base's measured motion.

        u = law's u + M_qb[linear](q) F(f + g) + M_qb[angular](q) F(omega)' + c(q; F(omega), v)

    with the specific force f = R^T (a_b - g) that the accelerometer shows, the gravity g of the
    nominal arm, c of `Arm.base_rotation_force`, and the low-pass F of ``band``. Three axes leave
    the terms of omega out; a tilt that they see counts as acceleration, as it should: f holds both.
    The law itself knows nothing of it; its own anti-windup sees its own torque.

    A band below that of the base's motion delays the feed-forward, and a torque that the motors
    cannot follow is no help: `ftcfa.feed_forward_band` chooses one.

    Attributes:
        nominal: The arm as the controller knows it.
        law: The law.
        band: Corner frequency of the first-order low-pass F [Hz].
        predictor: Predicts the acceleration over the delay of its reading; None holds the reading.
    """

    law: Annotated[Controller, Check(having("step", A_LAW))]
    band: Annotated[float, Check(positive_or_infinite, "Hz", (0.1, 300.0))] = np.inf
    predictor: Annotated[Predictor | None, Check(having("step", "a Predictor, or None"))] = None

    varies: ClassVar[Parameters] = number_fields("band")

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Unit and meaning of the signals of the law, and of the feed-forward."""
        own = Quantity("N m", "feed-forward of the base's motion")
        return {**quantities(self.law), "u_feed_forward": own}

    def init(self, measured: Measured, desired: Desired) -> FeedForwardState:
        """The state of the law, and no motion of the base.

        Raises:
            ParameterError: If the base is not measured.
        """
        base = _reading(measured)
        omega = base.angular_velocity
        turning = () if omega is None else Turning.begun(omega)
        prediction = () if self.predictor is None else self.predictor.init()
        return FeedForwardState(self.law.init(measured, desired), np.zeros(3), turning, prediction)

    def step(
        self, state: FeedForwardState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, FeedForwardState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        signals, law = self.law.step(state.law, measured, desired, period)
        base, q, nominal = _reading(measured), measured.q, self.nominal
        acceleration: Traceable = base.specific_force + _gravity(nominal)
        prediction = state.prediction
        if self.predictor is not None:
            acceleration, prediction = self.predictor.step(prediction, acceleration)
        a = low_pass(state.acceleration, acceleration, self.band, period)
        coupling, turning = nominal.base_coupling(q), state.turning
        load = coupling[:, :3] @ a
        if base.angular_velocity is not None:
            turning = turning.step(base.angular_velocity, self.band, period)
            arm: Any = nominal
            load = load + coupling[:, 3:] @ turning.acceleration
            load = load + arm.base_rotation_force(q, measured.v, turning.rate)
        signals = {**signals, "u": signals["u"] + load, "u_feed_forward": load}
        return signals, FeedForwardState(law, a, turning, prediction)


def _reading(measured: Measured) -> BaseReading:
    """The reading of the base; ParameterError if there is none."""
    if measured.base is None:
        expected = "an accelerometer on the base"
        remedy = "give the loop hardware=Hardware(accelerometer=Accelerometer(...))"
        raise ParameterError("FeedForward", "no reading of the base", expected, remedy)
    return measured.base


def _gravity(arm: Any) -> Traceable:
    """The nominal arm's gravity, shape (3,) [m/s^2]."""
    return arm.gravity
