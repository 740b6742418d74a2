"""Gains of the paper's controller; its rivals take their defaults from them."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, TypeAlias

from ftcfa.arrays import Joints
from ftcfa.checks import Check, is_number, positive, positive_numbers
from ftcfa.errors import ParameterError
from ftcfa.parts import Parameters, Part, checked_fields, number_fields


def check_power(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value is admissible as the fractional power kappa."""
    if not (is_number(value) and 0 < value <= 1):
        raise ParameterError(subject, repr(value), "0 < kappa <= 1")


@dataclass(frozen=True)
class Gains(Part):
    """Gains of the controller in the paper's symbols; the defaults are those of Section V.

    c1, c2, k1 and k2 are one number for all joints, as in the paper, or one for each. A tuner
    leaves tau as it is: the torque depends on lambda/tau^2.

    Attributes:
        c1: Fractional-power gain of the virtual control, (7) [rad^(1-kappa)/s].
        c2: Fractional-power gain of the controller, (8) [(rad/s)^(1-kappa)/s].
        k1: Linear gain of the virtual control and the error compensation, (7), (10) [1/s].
        k2: Linear gain of the controller and the error compensation, (8), (10) [1/s].
        kappa: Fractional power of the errors in (7), (8) and (10), 0 < kappa <= 1; below 1 it
            makes the law converge in finite time, and 1 is the asymptotic law of Remark 5.
        iota: Leakage of the adaptation, (9) [1/s].
        lambda_: Rate of the adaptation, (9).
        tau: Weight of the network term, (8), (9).
    """

    c1: Annotated[Joints, Check(positive_numbers, "rad^(1-kappa)/s", (0.1, 300.0))] = 7.5
    c2: Annotated[Joints, Check(positive_numbers, "(rad/s)^(1-kappa)/s", (0.1, 1000.0))] = 25.0
    k1: Annotated[Joints, Check(positive_numbers, "1/s", (0.1, 100.0))] = 2.0
    k2: Annotated[Joints, Check(positive_numbers, "1/s", (0.1, 300.0))] = 1.0 / 3.0
    kappa: Annotated[float, Check(check_power, "", (0.3, 1.0))] = 0.6
    iota: Annotated[float, Check(positive, "1/s", (0.1, 1000.0))] = 100.0
    lambda_: Annotated[float, Check(positive, "", (1e-3, 1000.0))] = 1.0
    tau: Annotated[float, Check(positive)] = 1.0

    per_joint: ClassVar = ("c1", "c2", "k1", "k2")
    varies: ClassVar[Parameters] = {
        **checked_fields(*per_joint),
        **number_fields("kappa", "iota", "lambda_", "tau"),
    }

    @property
    def linear_position_rate(self) -> Joints:
        """Rate of the linear term of (7), 3/4 (1 + k1) [1/s]."""
        return 0.75 * (1.0 + self.k1)

    @property
    def linear_velocity_rate(self) -> Joints:
        """Rate of the linear term of (8), 3/4 k2 + 5/4 [1/s]."""
        return 0.75 * self.k2 + 1.25

    @property
    def position_rate(self) -> Joints:
        """Rate of (7) for kappa = 1, c1 + 3/4 (1 + k1) [1/s]; the a1 of `ftcfa.control.laws`."""
        return self.c1 + self.linear_position_rate

    @property
    def velocity_rate(self) -> Joints:
        """Rate of (8) for kappa = 1, c2 + 3/4 k2 + 5/4 [1/s]; the a2 of `ftcfa.control.laws`."""
        return self.c2 + 0.75 * self.k2 + 1.25  # summed in this order: the last bit counts


def check_gains(subject: str, gains: Any) -> None:
    """Raise ParameterError unless the gains of a law are `Gains`."""
    if not isinstance(gains, Gains):
        raise ParameterError(subject, repr(gains), "Gains(...)")


A1 = float(Gains().position_rate)
"""The a1 that the paper's gains give [1/s]."""
A2 = float(Gains().velocity_rate)
"""The a2 that the paper's gains give [1/s]."""
PositionRate: TypeAlias = Annotated[Joints, Check(positive_numbers, "1/s", (0.3, 300.0))]
"""The a1 of a law [1/s]."""
VelocityRate: TypeAlias = Annotated[Joints, Check(positive_numbers, "1/s", (1.0, 1000.0))]
"""The a2 of a law [1/s]."""
