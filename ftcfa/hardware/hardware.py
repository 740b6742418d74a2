"""What stands between a law and the plant: sensors, actuators and an accelerometer on the base."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, about, counting, of_type, positive
from ftcfa.control.protocol import Measured, Quantity
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.hardware.accelerometer import Accelerometer
from ftcfa.hardware.actuators import Actuators, Drive, Motors
from ftcfa.hardware.delay import Line, whole_steps
from ftcfa.hardware.sensors import SensorMemory, Sensors
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Part
from ftcfa.streams import ACCELEROMETER_NOISE, ACTUATOR_NOISE, SENSOR_NOISE

ROUNDING = 1e-9
"""Excess of a period that is rounding, relative."""
NO_GRAVITY = np.zeros(3)
HARDWARE_QUANTITIES: Mapping[str, Quantity] = {
    "q_measured": Quantity("rad", "position that the sensors show"),
    "v_measured": Quantity("rad/s", "velocity that the sensors show, or its estimate"),
    "rate_limited": Quantity("1", "1 where the driver limits the rate of the torque, else 0"),
    "u_driven": Quantity("N m", "torque that the driver asks of the motors"),
    "base_measured": Quantity("m/s^2", "specific force of the base that its accelerometer shows"),
    "base_rate_measured": Quantity("rad/s", "angular velocity that the base's gyroscope shows"),
}
"""Unit and meaning of the signals that a loop with hardware has beside those of every loop."""


class HardwareMemory(NamedTuple):
    """What the hardware remembers from sample to sample."""

    sensors: SensorMemory
    """Readings of the joints."""
    torque: Traceable
    """Torque of the driver at the last sample, shape (n,) [N m or N]."""
    base: Any = ()
    """Reading of the base, a `BaseMemory`; empty without an accelerometer."""


class HardwareMotion(NamedTuple):
    """State of the hardware that integration steps advance."""

    lines: tuple[Line, Line]
    """Past positions and velocities."""
    motors: Motors
    """The motors."""
    base: Any = ()
    """Past motion of the base, a `BaseLine`; empty without an accelerometer."""


@dataclass(frozen=True, eq=False)
class Hardware(Part):
    """What a robot measures and what its motors can do.

    Attributes:
        sensors: Sensors of the joints.
        actuators: Motors and their drivers.
        accelerometer: Accelerometer on the base, or None.
        joints: Number of joints for which it is made, or None for any.
        period: Shortest sampling period that the robot's interface allows [s], or None for any.
        note: What a user must know of it; a run warns of it.
        name: How results name it.
    """

    sensors: Annotated[Sensors, Check(of_type(Sensors, "Sensors(...)"))] = field(
        default_factory=Sensors
    )
    actuators: Annotated[Actuators, Check(of_type(Actuators, "Actuators(...)"))] = field(
        default_factory=Actuators
    )
    accelerometer: Annotated[
        Accelerometer | None, Check(of_type(Accelerometer, "an Accelerometer(...), or None"))
    ] = None
    joints: Annotated[int | None, Check(counting)] = None
    period: Annotated[float | None, Check(positive, "s")] = None
    note: str = ""
    name: str = "of one's own"

    def check(self, n: int, period: float, step: float) -> None:
        """Raise an FtcfaError unless the hardware fits n joints, a period and a step [s]."""
        if self.joints not in (None, n):
            got, remedy = f"an arm of {n} joints", "take another profile, or Hardware of your own"
            raise ShapeError("hardware", got, f"{self.joints} joints", remedy, field="joints")
        if self.period is not None and period < self.period * (1 - ROUNDING):
            got, expected = f"a loop with period {period:g} s", f"{self.period:g} s or longer"
            remedy = f"give the loop period={self.period:g}"
            raise ParameterError("hardware", got, expected, remedy, field="period")
        with about("sensors"):
            self.sensors.check_joints(n)
        with about("actuators"):
            self.actuators.check_joints(n)
        if self.accelerometer is not None:
            with about("accelerometer"):
                self.accelerometer.check(period, step)
        for part, name, time in self.delays():
            with about(part):
                whole_steps(f"{part} {name}", time, step)

    def delays(self) -> list[tuple[str, str, float]]:
        """Every time that has to be a whole number of integration steps: part, name, time [s]."""
        sensors, actuators, base = self.sensors, self.actuators, self.accelerometer
        found: list[tuple[str, str, Any]] = [
            ("sensors", "latency", sensors.latency),
            ("sensors", "largest_latency", sensors.largest_latency),
            ("actuators", "delay", actuators.delay),
            ("actuators", "largest_delay", actuators.largest_delay),
        ]
        if base is not None:
            found += [("accelerometer", "delay", base.delay)]
            found += [("accelerometer", "largest_delay", base.largest_delay)]
        return [(part, name, float(time)) for part, name, time in found]

    def check_duration(self, duration: float) -> None:
        """Raise ParameterError if a delay is longer than a run [s]."""
        for part, name, time in self.delays():
            if time > duration > 0:
                got, expected = f"{time:g} s", f"at most the run's {duration:g} s"
                raise ParameterError(f"hardware {part}", f"{name} {got}", expected)

    @property
    def senses_base(self) -> bool:
        """Whether it needs the motion of the base."""
        return self.accelerometer is not None

    def limit(self, arm_limit: Traceable) -> Traceable:
        """The torque limits that hold, shape (n,) [N m or N]."""
        return self.actuators.limit(arm_limit)

    def streams(self, n: int) -> dict[int, int]:
        """Random streams of a sample, and the number of deviates of each."""
        base = self.accelerometer
        return {
            SENSOR_NOISE: self.sensors.normals(n),
            ACTUATOR_NOISE: self.actuators.normals(n),
            ACCELEROMETER_NOISE: 0 if base is None else base.normals(),
        }

    def init(
        self, arm: Dynamics, q: Array, v: Array, step: float
    ) -> tuple[HardwareMemory, HardwareMotion]:
        """State before the first sample: the motors hold the arm, on a level base at rest."""
        limit = self.limit(arm.effort_limit)
        torque = np.clip(arm.potential_force(q), -limit, limit)
        readings, lines = self.sensors.init(q, v, step)
        motors = self.actuators.init(torque, step)
        if self.accelerometer is None:
            return HardwareMemory(readings, torque), HardwareMotion(lines, motors)
        base, line = self.accelerometer.init(getattr(arm, "gravity", NO_GRAVITY), step)
        return HardwareMemory(readings, torque, base), HardwareMotion(lines, motors, line)

    def read(
        self,
        memory: HardwareMemory,
        motion: HardwareMotion,
        q: Traceable,
        v: Traceable,
        normals: Traceable,
        period: float,
        step: float,
    ) -> HardwareMemory:
        """The memory after a sample, which holds its readings; see `Sensors.read`."""
        n = q.shape[0]
        k, end = self.sensors.normals(n), self.sensors.normals(n) + self.actuators.normals(n)
        state = memory.sensors, motion.lines, q, v, memory.torque
        memory = memory._replace(sensors=self.sensors.read(*state, normals[:k], period, step))
        if self.accelerometer is None:
            return memory
        base = self.accelerometer.read(memory.base, motion.base, normals[end:], period, step)
        return memory._replace(base=base)

    def measured(self, memory: HardwareMemory, q: Traceable, v: Traceable) -> Measured:
        """The last readings as a law gets them; the true q and v, shape (n,) each, are hidden."""
        q, v = memory.sensors.q, memory.sensors.v
        if self.accelerometer is None:
            return Measured(q, v)
        return Measured(q, v, self.accelerometer.reading(memory.base))

    def drive(
        self, memory: HardwareMemory, wanted: Traceable, normals: Traceable, period: float
    ) -> tuple[Drive, HardwareMemory]:
        """What the driver makes of a command within the limits, and the memory after it."""
        n = wanted.shape[0]
        k = self.sensors.normals(n)
        own = normals[k : k + self.actuators.normals(n)]
        drive, torque = self.actuators.drive(memory.torque, wanted, own, period)
        return drive, memory._replace(torque=torque)

    def signals(
        self, memory: HardwareMemory, wanted: Traceable, drive: Drive
    ) -> dict[str, Traceable]:
        """The signals of a sample: see HARDWARE_QUANTITIES."""
        limited = np.where(np.abs(memory.torque - wanted) > 0.0, 1.0, 0.0)
        shown = {"q_measured": memory.sensors.q, "v_measured": memory.sensors.v}
        shown |= {"rate_limited": limited}
        base = {}
        if self.accelerometer is not None:
            force, omega = self.accelerometer.reading(memory.base)
            base["base_measured"] = force
            if omega is not None:
                base["base_rate_measured"] = omega
        return {**shown, "u_driven": drive.torque, **base}

    def acting(
        self, motion: HardwareMotion, drive: Drive, limit: Traceable, step: float
    ) -> tuple[Traceable, Motors]:
        """The torque that acts in an integration step, and the motors at its end."""
        return self.actuators.act(motion.motors, drive, limit, step)

    def advanced(
        self,
        motion: HardwareMotion,
        q: Traceable,
        v: Traceable,
        motors: Motors,
        base: Any,
        step: float,
    ) -> HardwareMotion:
        """The state after an integration step.

        Args:
            motion: The state before it.
            q: Position at its start, shape (n,) [rad or m].
            v: Velocity at its start, shape (n,) [rad/s or m/s].
            motors: The motors at its end.
            base: Mean specific force and angular velocity of the base, shape (6,), if it is sensed.
            step: Length of the step [s].
        """
        line = motion.base
        if self.accelerometer is not None:
            line = self.accelerometer.pushed(line, base, step)
        return HardwareMotion(self.sensors.pushed(motion.lines, q, v), motors, line)
