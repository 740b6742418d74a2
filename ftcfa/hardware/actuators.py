"""The motors and their drivers: rate limit, quantisation, delay, lag and ripple of the torque."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Array, Joints, Traceable, is_off
from ftcfa.checks import Check, not_negative, not_negative_numbers, positive_or_infinite_numbers
from ftcfa.control.low_pass import low_pass
from ftcfa.hardware.delay import Line, delayed, filled, pushed, quantised
from ftcfa.hardware.sensors import time_within, with_largest
from ftcfa.parts import Parameters, Part, checked_fields


class Drive(NamedTuple):
    """What the driver gives to the motors for one period."""

    torque: Traceable
    """Torque that the motors are asked for, shape (n,) [N m or N]."""
    ripple: Traceable
    """Error of the torque that they give, shape (n,) [N m or N]."""


class Motors(NamedTuple):
    """State of the motors, which integration steps advance."""

    line: Line
    """What the motors were asked for in the last steps."""
    torque: Traceable
    """Torque behind the lag, shape (n,) [N m or N]."""


@dataclass(frozen=True, eq=False)
class Actuators(Part):
    """Motors and their drivers.

    The driver, at a sample: the command, within the effort limits, changes by ``rate_limit`` times
    the period at most and is rounded to ``resolution``. The motors, at every integration step: a
    ``delay``, a first-order lag of ``bandwidth``, the ripple, and the effort limits again. Before
    the first sample the motors hold the arm against gravity. Not modelled: friction and elasticity
    of the drives, back-EMF and temperature.

    Attributes:
        rate_limit: Largest rate at which the driver changes the torque [N m/s or N/s].
        resolution: Smallest step of the torque [N m or N].
        delay: Time from the driver to the torque, in whole integration steps [s].
        largest_delay: Longest delay that a path may have [s]; the delay by default.
        bandwidth: Corner frequency of the lag [Hz].
        ripple: Standard deviation of the torque's error, white from sample to sample [N m or N].
        effort_limit: Limit of the motors where it is below the arm's [N m or N].
    """

    rate_limit: Annotated[Joints, Check(positive_or_infinite_numbers, "N m/s")] = np.inf
    resolution: Annotated[Joints, Check(not_negative_numbers, "N m")] = 0.0
    delay: Annotated[float, Check(not_negative, "s")] = 0.0
    largest_delay: Annotated[float | None, Check(not_negative, "s")] = None
    bandwidth: Annotated[Joints, Check(positive_or_infinite_numbers, "Hz")] = np.inf
    ripple: Annotated[Joints, Check(not_negative_numbers, "N m")] = 0.0
    effort_limit: Annotated[Joints, Check(positive_or_infinite_numbers, "N m")] = np.inf

    per_joint: ClassVar = ("rate_limit", "resolution", "bandwidth", "ripple", "effort_limit")
    varies: ClassVar[Parameters] = {
        **checked_fields(*per_joint),
        "delay": time_within("delay", "largest_delay"),
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        with_largest(self, "delay", "largest_delay")

    def limit(self, arm_limit: Traceable) -> Traceable:
        """The limits that hold, those of the arm or of the motors, shape (n,) [N m or N]."""
        if is_off(self.effort_limit, np.inf):
            return arm_limit
        return np.minimum(arm_limit, self.effort_limit)

    def normals(self, n: int) -> int:
        """Number of deviates of a sample."""
        return n

    def init(self, torque: Array, step: float) -> Motors:
        """Motors that have given a torque for long."""
        return Motors(filled(torque, float(self.largest_delay or 0.0), step), torque)

    def drive(
        self, last: Traceable, wanted: Traceable, normals: Traceable, period: float
    ) -> tuple[Drive, Traceable]:
        """What the driver gives to the motors, and its torque before it is rounded.

        Args:
            last: The driver's torque of the last sample before it was rounded, shape (n,).
            wanted: Command within the limits, shape (n,).
            normals: Deviates of the sample, shape (n,).
            period: Sampling period [s].
        """
        torque = wanted
        if not is_off(self.rate_limit, np.inf):
            rate: Any = self.rate_limit
            change = period * rate
            torque = np.clip(wanted, last - change, last + change)
        size: Any = self.ripple
        ripple = np.zeros_like(wanted) if is_off(size) else size * normals
        return Drive(quantised(torque, self.resolution), ripple), torque

    def act(
        self, motors: Motors, drive: Drive, limit: Traceable, step: float
    ) -> tuple[Traceable, Motors]:
        """The torque that acts in an integration step, shape (n,), and the motors at its end."""
        asked = delayed(motors.line, drive.torque, self.delay, step)
        torque = low_pass(motors.torque, asked, self.bandwidth, step)
        acting = torque if is_off(self.ripple) else torque + drive.ripple
        line = pushed(motors.line, drive.torque)
        return np.clip(acting, -limit, limit), Motors(line, torque)
