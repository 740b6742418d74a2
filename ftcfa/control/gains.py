"""Gains of the paper's controller; its rivals take their defaults from them."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from ftcfa.checks import Check, is_number, positive
from ftcfa.errors import ParameterError
from ftcfa.parts import Parameters, Part, number_fields


def check_power(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value is admissible as the fractional power kappa."""
    if not (is_number(value) and 0 < value <= 1):
        raise ParameterError(subject, repr(value), "0 < kappa <= 1")


@dataclass(frozen=True)
class Gains(Part):
    """Gains of the controller in the paper's symbols; the defaults are those of Section V.

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

    c1: Annotated[float, Check(positive, "rad^(1-kappa)/s")] = 7.5
    c2: Annotated[float, Check(positive, "(rad/s)^(1-kappa)/s")] = 25.0
    k1: Annotated[float, Check(positive, "1/s")] = 2.0
    k2: Annotated[float, Check(positive, "1/s")] = 1.0 / 3.0
    kappa: Annotated[float, Check(check_power)] = 0.6
    iota: Annotated[float, Check(positive, "1/s")] = 100.0
    lambda_: Annotated[float, Check(positive)] = 1.0
    tau: Annotated[float, Check(positive)] = 1.0

    varies: ClassVar[Parameters] = number_fields(
        "c1", "c2", "k1", "k2", "kappa", "iota", "lambda_", "tau"
    )

    @property
    def linear_position_rate(self) -> float:
        """Rate of the linear term of (7), 3/4 (1 + k1) [1/s]."""
        return 0.75 * (1.0 + self.k1)

    @property
    def linear_velocity_rate(self) -> float:
        """Rate of the linear term of (8), 3/4 k2 + 5/4 [1/s]."""
        return 0.75 * self.k2 + 1.25

    @property
    def position_rate(self) -> float:
        """Rate of (7) for kappa = 1, c1 + 3/4 (1 + k1) [1/s]; the a1 of `ftcfa.control.laws`."""
        return self.c1 + self.linear_position_rate

    @property
    def velocity_rate(self) -> float:
        """Rate of (8) for kappa = 1, c2 + 3/4 k2 + 5/4 [1/s]; the a2 of `ftcfa.control.laws`."""
        return self.c2 + 0.75 * self.k2 + 1.25  # summed in this order: the last bit counts


def check_gains(subject: str, gains: Any) -> None:
    """Raise ParameterError unless the gains of a law are `Gains`."""
    if not isinstance(gains, Gains):
        raise ParameterError(subject, repr(gains), "Gains(...)")
