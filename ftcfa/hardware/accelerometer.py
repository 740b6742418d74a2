"""The accelerometer on the arm's base, with or without a gyroscope."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Array, Joints, Traceable, is_off
from ftcfa.checks import (
    Check,
    finite_numbers,
    is_integer,
    not_negative,
    of_type,
    positive,
    positive_or_infinite,
)
from ftcfa.control.low_pass import low_pass
from ftcfa.control.protocol import BaseReading
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.hardware.delay import Line, delayed, filled, pushed, steps_in
from ftcfa.hardware.sensors import time_within, with_largest
from ftcfa.parts import Parameters, Part, any_finite, number_field, number_fields

HALF = 0.5
LONG = 1e9
"""Samples since a reading, where there is none yet."""


def numbers_of_axes(subject: str, values: Any, unit: str = "") -> None:
    """Raise a FtcfaError unless values are a finite number, or one for each of three axes."""
    finite_numbers(subject, values, unit)
    if np.shape(values) not in ((), (3,)):
        got = f"{np.size(values)} numbers"
        raise ShapeError(subject, got, "one number, or one for each of 3 axes")


@dataclass(frozen=True, eq=False)
class Gyroscope(Part):
    """Three gyroscopes; bandwidth, delay and rate are those of their accelerometer.

    Attributes:
        noise_density: One-sided density of the noise [rad/s/sqrt(Hz)].
        bias: Constant error, one number or one for each axis [rad/s].
        range: Largest angular velocity that is shown [rad/s].
    """

    noise_density: Annotated[float, Check(not_negative, "rad/s/sqrt(Hz)")] = 0.0
    bias: Annotated[Joints, Check(numbers_of_axes, "rad/s")] = 0.0
    range: Annotated[float, Check(positive_or_infinite, "rad/s")] = np.inf

    varies: ClassVar[Parameters] = {
        **number_fields("noise_density"),
        "bias": number_field("bias", any_finite),
    }


class BaseMemory(NamedTuple):
    """What the driver of an accelerometer remembers from sample to sample."""

    reading: Traceable
    """Last reading, shape (3,) or (6,)."""
    age: Traceable
    """Samples of the controller since it was taken, shape (1,)."""


class BaseLine(NamedTuple):
    """State of an accelerometer, which integration steps advance."""

    filtered: Traceable
    """Motion of the base behind the low-pass, shape (3,) or (6,)."""
    line: Line
    """Its values in the last steps."""
    begun: Traceable
    """0 before the first step, then 1, shape (1,)."""


@dataclass(frozen=True, eq=False)
class Accelerometer(Part):
    """Accelerometer at the origin of the arm's base, with its gyroscope.

    It shows the specific force R^T (a_b - g) in axes that turn with the base, and omega: means over
    an integration step, behind a first-order low-pass of ``bandwidth``, plus bias and white noise,
    within the range, sampled at ``rate``, held between samples, ``delay`` late. The noise of a
    sample has the variance density^2 rate/2.

    Attributes:
        axes: 3; or 6 with a gyroscope.
        noise_density: One-sided density of the noise [m/s^2/sqrt(Hz)].
        bias: Constant error, one number or one for each axis [m/s^2].
        range: Largest acceleration that is shown [m/s^2].
        bandwidth: Corner frequency [Hz].
        delay: Age of a reading when it arrives, in whole integration steps [s].
        largest_delay: Longest delay that a path may have [s]; the delay by default.
        rate: Readings a second [Hz]; that of the controller by default.
        gyroscope: Three gyroscopes, which a base that turns needs, or None.

    Raises:
        ParameterError: If six axes have no gyroscope, or three have one.
    """

    axes: int = 3
    noise_density: Annotated[float, Check(not_negative, "m/s^2/sqrt(Hz)")] = 0.0
    bias: Annotated[Joints, Check(numbers_of_axes, "m/s^2")] = 0.0
    range: Annotated[float, Check(positive_or_infinite, "m/s^2")] = np.inf
    bandwidth: Annotated[float, Check(positive_or_infinite, "Hz")] = np.inf
    delay: Annotated[float, Check(not_negative, "s")] = 0.0
    largest_delay: Annotated[float | None, Check(not_negative, "s")] = None
    rate: Annotated[float | None, Check(positive, "Hz")] = None
    gyroscope: Annotated[
        Gyroscope | None, Check(of_type(Gyroscope, "a Gyroscope(...), or None"))
    ] = None

    varies: ClassVar[Parameters] = {
        **number_fields("noise_density", "bandwidth"),
        "bias": number_field("bias", any_finite),
        "delay": time_within("delay", "largest_delay"),
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        with_largest(self, "delay", "largest_delay")
        if not is_integer(self.axes) or self.axes not in (3, 6):
            raise ParameterError("Accelerometer axes", repr(self.axes), "3 or 6", field="axes")
        if (self.axes == 6) != (self.gyroscope is not None):
            gyroscope = "without" if self.gyroscope is None else "with"
            remedy = "give gyroscope=Gyroscope(...)" if self.axes == 6 else "say axes=6"
            got = f"{self.axes} {gyroscope} a gyroscope"
            raise ParameterError("Accelerometer axes", got, "6 with one", remedy, field="axes")

    def check(self, period: float, step: float) -> None:
        """Raise ParameterError unless the rate goes with the controller's period and the step."""
        if self.rate is None:
            return
        interval = 1.0 / self.rate
        if interval < step * (1 - 1e-9):
            got, remedy = f"{self.rate:g} Hz", "take more substeps"
            expected = f"at most one reading an integration step, {1 / step:g} Hz"
            raise ParameterError("Accelerometer rate", got, expected, remedy, field="rate")
        ratio = max(interval, period) / min(interval, period)
        if abs(ratio - round(ratio)) > 1e-6 * ratio:
            below, above = np.floor(ratio), np.ceil(ratio)
            slower = interval >= period
            rates = [1.0 / (k * period) if slower else k / period for k in (below, above)]
            got, remedy = f"{self.rate:g} Hz", f"take {rates[0]:g} or {rates[1]:g} Hz"
            expected = f"a multiple or a whole part of the controller's {1.0 / period:g} Hz"
            raise ParameterError("Accelerometer rate", got, expected, remedy, field="rate")

    def normals(self) -> int:
        """Number of deviates of a sample."""
        return self.axes

    def init(self, gravity: Array, step: float) -> tuple[BaseMemory, BaseLine]:
        """Memory before the first sample: a level base at rest.

        The first step fills the line with the motion that it finds.
        """
        rest = np.concatenate([-gravity, np.zeros(self.axes - 3)])
        line = BaseLine(rest, filled(rest, float(self.largest_delay or 0.0), step), np.zeros(1))
        return BaseMemory(rest, np.full(1, LONG)), line

    def pushed(self, state: BaseLine, motion: Traceable, step: float) -> BaseLine:
        """The line after an integration step with a mean motion of the base, shape (6,)."""
        now, begun = motion[: self.axes], np.max(state.begun) > HALF
        filtered = np.where(begun, low_pass(state.filtered, now, self.bandwidth, step), now)
        older = pushed(state.line, state.filtered)
        line = tuple(np.where(begun, value, now) for value in older)
        return BaseLine(filtered, line, np.ones(1))

    def read(
        self, memory: BaseMemory, state: BaseLine, normals: Traceable, period: float, step: float
    ) -> BaseMemory:
        """The memory after a sample of the controller, which holds the reading.

        Args:
            memory: Memory before the sample.
            state: Motion of the base in the last steps.
            normals: Deviates of the sample, shape (axes,).
            period: Sampling period of the controller [s].
            step: Integration step [s].
        """
        rate = 1.0 / period if self.rate is None else self.rate
        late = delayed(state.line, state.filtered, self.delay, step)
        parts = [self._shown(self, late[:3], normals[:3], rate)]
        if self.gyroscope is not None:
            parts.append(self._shown(self.gyroscope, late[3:], normals[3:], rate))
        fresh = np.concatenate(parts)
        every = max(1, steps_in(1.0 / rate, period))
        if every == 1:
            return BaseMemory(fresh, memory.age)
        due = np.max(memory.age) > every - 1 - HALF
        age = np.where(due, 0.0, memory.age + 1.0)
        return BaseMemory(np.where(due, fresh, memory.reading), age)

    @staticmethod
    def _shown(sensor: Any, motion: Traceable, normals: Traceable, rate: float) -> Traceable:
        """What one of the sensors shows of a motion, shape (3,)."""
        shown, most = motion if is_off(sensor.bias) else motion + sensor.bias, sensor.range
        if not is_off(sensor.noise_density):
            shown = shown + sensor.noise_density * np.sqrt(rate / 2.0) * normals
        return shown if is_off(most, np.inf) else np.clip(shown, -most, most)

    def reading(self, memory: BaseMemory) -> BaseReading:
        """The last reading as a law gets it."""
        omega = memory.reading[3:] if self.axes == 6 else None
        return BaseReading(memory.reading[:3], omega)
