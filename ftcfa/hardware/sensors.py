"""The sensors of the joints: resolution, noise, offset, latency and lost samples."""

from dataclasses import dataclass
from inspect import signature
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Array, Joints, Traceable, is_off
from ftcfa.checks import Check, finite_numbers, having, not_negative, not_negative_numbers
from ftcfa.errors import ParameterError
from ftcfa.hardware.delay import Line, delayed, filled, pushed, quantised
from ftcfa.hardware.velocity import VelocityEstimator
from ftcfa.parts import Parameter, Parameters, Part, checked_fields, number_field

AN_ESTIMATOR = "an estimator of velocities, such as BackwardDifference(50.0), or None"


def an_estimator(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value estimates velocities: a law has a step too."""
    having("step", AN_ESTIMATOR)(subject, value)
    if len(signature(value.init).parameters) != 1:
        raise ParameterError(subject, f"a {type(value).__name__}", AN_ESTIMATOR)


def share(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value is a probability, zero included."""
    not_negative(subject, value)
    if value >= 1:
        raise ParameterError(subject, repr(value), "a number from 0, below 1")


def time_within(name: str, largest: str) -> Parameter:
    """A time in whole integration steps that may vary up to the part's largest."""

    def check(part: Any, values: Array) -> None:
        most = getattr(part, largest)
        if len(values) and not (values.min() >= 0 and values.max() <= most):
            got, remedy = f"{values.min():g} to {values.max():g} s", f"state {largest}"
            raise ParameterError(f"varied {name}", got, f"0 to {most:g} s", remedy)

    return number_field(name, check, whole_steps=True)


def with_largest(part: Any, name: str, largest: str) -> None:
    """Set the largest value of a time that may vary to the time itself, if none is stated.

    Raises:
        ParameterError: If the time is longer than the largest one.
    """
    time, most = getattr(part, name), getattr(part, largest)
    if most is None:
        object.__setattr__(part, largest, time)
    elif most < time:
        subject = f"{type(part).__name__} {largest}"
        raise ParameterError(subject, f"{most:g} s", f"{name} or more, {time:g} s", field=largest)


class SensorMemory(NamedTuple):
    """What the sensors remember from sample to sample."""

    q: Traceable
    """Last reading of the positions, shape (n,) [rad or m]."""
    v: Traceable
    """Last velocities that were handed on, shape (n,) [rad/s or m/s]."""
    estimate: Any = ()
    """State of the estimator of velocities."""


@dataclass(frozen=True, eq=False)
class Sensors(Part):
    """Encoders, and how velocities come about.

    At a sample, in this order: the position of ``latency`` ago, plus ``offset``, plus ``noise``,
    rounded to ``resolution``. A sample may be lost; the reading before it then stands, and an
    estimator of velocities takes it for a new one. Deviates are white from sample to sample. Before
    the first sample stands the first position without noise. Not modelled: quantised velocities,
    drift, gears between encoder and joint.

    Attributes:
        resolution: Smallest step of the encoders [rad or m]; 2 pi/2^bits.
        noise: Standard deviation of a position [rad or m].
        offset: Constant error of a position [rad or m].
        velocity: None: velocities are measured, as late as positions. Else the estimator that makes
            them of the readings, such as `ftcfa.hardware.velocity.BackwardDifference`.
        velocity_noise: Standard deviation of a measured velocity [rad/s or m/s].
        latency: Age of what is read, in whole integration steps [s].
        largest_latency: Longest latency that a path may have [s]; the latency by default.
        dropped: Probability that a sample is lost.
    """

    resolution: Annotated[Joints, Check(not_negative_numbers, "rad or m")] = 0.0
    noise: Annotated[Joints, Check(not_negative_numbers, "rad or m")] = 0.0
    offset: Annotated[Joints, Check(finite_numbers, "rad or m")] = 0.0
    velocity: Annotated[VelocityEstimator | None, Check(an_estimator)] = None
    velocity_noise: Annotated[Joints, Check(not_negative_numbers, "rad/s or m/s")] = 0.0
    latency: Annotated[float, Check(not_negative, "s")] = 0.0
    largest_latency: Annotated[float | None, Check(not_negative, "s")] = None
    dropped: Annotated[float, Check(share)] = 0.0

    per_joint: ClassVar = ("resolution", "noise", "offset", "velocity_noise")
    varies: ClassVar[Parameters] = {
        **checked_fields(*per_joint),
        "latency": time_within("latency", "largest_latency"),
        "dropped": number_field("dropped"),
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        with_largest(self, "latency", "largest_latency")
        if self.velocity is not None and not is_off(self.velocity_noise):
            got = f"{self.velocity_noise} beside velocities that are estimated"
            raise ParameterError("Sensors velocity_noise", got, "0", field="velocity_noise")

    @property
    def _errors(self) -> tuple[Any, Any]:
        """Offset and noise of positions: numbers, arrays or symbols."""
        return self.offset, self.noise

    def normals(self, n: int) -> int:
        """Number of deviates of a sample: of positions, velocities, and two for a lost sample."""
        return 2 * n + 2

    def init(self, q: Array, v: Array, step: float) -> tuple[SensorMemory, tuple[Line, Line]]:
        """Memory before the first sample, and lines of past positions and velocities."""
        lines = tuple(filled(x, float(self.largest_latency or 0.0), step) for x in (q, v))
        first = quantised(q + self._errors[0], self.resolution)
        if self.velocity is None:
            return SensorMemory(first, v), (lines[0], lines[1])
        return SensorMemory(first, np.zeros_like(q), self.velocity.init(first)), (lines[0], ())

    def pushed(self, lines: tuple[Line, Line], q: Traceable, v: Traceable) -> tuple[Line, Line]:
        """The lines one integration step later."""
        return pushed(lines[0], q), pushed(lines[1], v)

    def read(
        self,
        memory: SensorMemory,
        lines: tuple[Line, Line],
        q: Traceable,
        v: Traceable,
        torque: Traceable,
        normals: Traceable,
        period: float,
        step: float,
    ) -> SensorMemory:
        """The memory after a sample, which holds its readings.

        Args:
            memory: Memory before the sample.
            lines: Lines of past positions and velocities.
            q: True position, shape (n,) [rad or m].
            v: True velocity, shape (n,) [rad/s or m/s].
            torque: Torque that the driver gave to the motors since the last sample, shape (n,).
            normals: Deviates of the sample, shape (`normals`,).
            period: Sampling period [s].
            step: Integration step [s].
        """
        n = q.shape[0]
        lost = _lost(self.dropped, normals[2 * n :])
        late = delayed(lines[0], q, self.latency, step)
        offset, noise = self._errors
        late = late if is_off(offset) else late + offset
        late = late if is_off(noise) else late + noise * normals[:n]
        reading = np.where(lost, memory.q, quantised(late, self.resolution))
        if self.velocity is not None:
            speed, estimate = self.velocity.step(memory.estimate, reading, torque, period)
            return SensorMemory(reading, speed, estimate)
        speed = delayed(lines[1], v, self.latency, step)
        error: Any = self.velocity_noise
        if not is_off(error):
            speed = speed + error * normals[n : 2 * n]
        return SensorMemory(reading, np.where(lost, memory.v, speed))


def _lost(probability: Any, normals: Traceable) -> Any:
    """Whether a sample is lost: exp(-(a^2 + b^2)/2) of two deviates is uniform on 0 to 1."""
    if is_off(probability):
        return np.array(False)
    return np.exp(-0.5 * (normals @ normals)) < probability
