"""The paper's controller: finite-time command-filtered adaptive backstepping, (5) to (12)."""

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple, cast

import numpy as np

from ftcfa.arrays import Array, solve_spd
from ftcfa.checks import Check, check_fields, flag, is_number, positive
from ftcfa.control.compensation import (
    Compensation,
    check_nominal,
    compensation_force,
)
from ftcfa.control.filters import CommandFilter, command_filter, leaky_step
from ftcfa.control.fractional import sig
from ftcfa.control.network import RBFNetwork
from ftcfa.control.protocol import Desired, Signals
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Parameters, number_fields


def check_power(subject: str, value: Any) -> None:
    """Raise ParameterError unless a fractional power is admissible."""
    if not (is_number(value) and 0 < value <= 1):
        raise ParameterError(subject, repr(value), "0 < kappa <= 1")


@dataclass(frozen=True)
class Gains:
    """Gains of the controller in the paper's symbols; the defaults are those of Section V.

    Attributes:
        c1: Fractional-power gain of the virtual control, (7) [rad^(1-kappa)/s].
        c2: Fractional-power gain of the controller, (8) [(rad/s)^(1-kappa)/s].
        k1: Linear gain of the virtual control and the error compensation, (7), (10) [1/s].
        k2: Linear gain of the controller and the error compensation, (8), (10) [1/s].
        kappa: Fractional power, 0 < kappa <= 1; 1 is the asymptotic law of Remark 5.
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

    def __post_init__(self) -> None:
        check_fields(self)

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
        """Rate at which the asymptotic law steers a position error down, c1 + 3/4 (1 + k1) [1/s].

        By it, and by `velocity_rate`, the defaults of all laws are chosen: see
        `ftcfa.control.laws`.
        """
        return self.c1 + self.linear_position_rate

    @property
    def velocity_rate(self) -> float:
        """Rate at which it steers a velocity error down, c2 + 3/4 k2 + 5/4 [1/s]."""
        return self.c2 + 0.75 * self.k2 + 1.25


def check_gains(subject: str, gains: Any) -> None:
    """Raise ParameterError unless the gains of a law are `Gains`."""
    if not isinstance(gains, Gains):
        raise ParameterError(subject, repr(gains), "Gains(...)")


class FTCFState(NamedTuple):
    """State of the controller."""

    filter: Any
    """Of the command filter, (6)."""
    s1: Array
    """Error compensation of the position, shape (n,) [rad], (10)."""
    s2: Array
    """Error compensation of the velocity, shape (n,) [rad/s], (10); stays zero."""
    rho: Array
    """Anti-saturation state, shape (n,) [rad/s], (11)."""
    theta: Array
    """Estimate of the squared norm of the network's weights, shape (1,), (9)."""


def virtual_control(gains: Gains, v1: Array, dq_d: Array, rho: Array) -> Array:
    """Virtual control of the first backstepping step.

        alpha = -c1 sig(v1, kappa) - 3/4 (1 + k1) v1 + q_d' - rho          (7)

    Args:
        gains: c1, k1 and kappa.
        v1: Compensated tracking error, shape (n,) [rad].
        dq_d: Desired velocity, shape (n,) [rad/s].
        rho: Anti-saturation state, shape (n,) [rad/s].

    Returns:
        alpha, shape (n,) [rad/s].
    """
    return -gains.c1 * sig(v1, gains.kappa) - gains.linear_position_rate * v1 + dq_d - rho


def commanded_acceleration(gains: Gains, v2: Array, theta: Array, BB: Array, rho: Array) -> Array:
    """Acceleration that the controller commands of the nominal arm, Mbar^-1 u.

        a = -c2 sig(v2, kappa) - (3/4 k2 + 5/4) v2 - theta v2 (B^T B)/(4 tau) - rho      (8)

    Args:
        gains: c2, k2, kappa and tau.
        v2: Compensated velocity error, shape (n,) [rad/s].
        theta: Estimate of the squared norm of the network's weights, shape (1,).
        BB: B^T B of the network.
        rho: Anti-saturation state, shape (n,) [rad/s].

    Returns:
        a, shape (n,) [rad/s^2].
    """
    return (
        -gains.c2 * sig(v2, gains.kappa)
        - gains.linear_velocity_rate * v2
        - network_acceleration(gains, v2, theta, BB)
        - rho
    )


def network_acceleration(gains: Gains, v2: Array, theta: Array, BB: Array) -> Array:
    """Part of the network in (8), theta v2 (B^T B)/(4 tau), shape (n,) [rad/s^2]."""
    return theta * v2 * BB / (4.0 * gains.tau)


def adaptation_rate(gains: Gains, v2: Array, BB: Array) -> Array:
    """Rate of theta without its leakage, lambda/(4 tau) (v2^T v2)^2 (B^T B), (9) [1/s]."""
    return gains.lambda_ / (4.0 * gains.tau) * (v2 @ v2) ** 2 * BB


def smooth_saturation(u: Array, limit: Array) -> Array:
    """The smooth saturation eta(u) = u* tanh(u/u*) of the paper, shape (n,) [N m or N].

    Args:
        u: Torque, shape (n,) [N m or N].
        limit: Effort limits u*, shape (n,) [N m or N].
    """
    return limit * np.tanh(u / limit)


@dataclass(frozen=True, eq=False)
class FTCF:
    """Finite-time command-filtered adaptive neural backstepping (Song, Zhao, Cui).

        z1 = q - q_d,  z2 = v - abar,  v1 = z1 - s1,  v2 = z2 - s2 - rho        (5), (12)
        a  = -c2 sig(v2, kappa) - (3/4 k2 + 5/4) v2 - theta v2 (B^T B)/(4 tau) - rho
        u  = Mbar(q) a + compensation                                           (8)

    The states s1, s2, rho and theta advance by one Euler step a period, their linear decay taken
    implicitly, so that no leakage is too fast for the period.

    Attributes:
        nominal: The arm as the controller believes it to be.
        gains: Gains in the paper's symbols.
        filter: Command filter, or its name in `ftcfa.control.filters.FILTERS`.
        compensation: What is added to u: ``"none"`` (the paper), the nominal ``"gravity"`` h(q),
            or the nominal ``"bias"`` C v + h + f, friction taken at the velocity that the law
            steers to, v - v2.
        network: The basis functions.
        error_compensation: Whether s1 and s2 move, (10); without, they stay zero.
        anti_saturation: Whether rho moves, (11); without, it stays zero.
        adaptation: Whether theta moves, (9); without, it stays zero and the network is silent.
    """

    nominal: Annotated[Dynamics, Check(check_nominal)]
    gains: Annotated[Gains, Check(check_gains)] = field(default_factory=Gains)
    filter: CommandFilter | str = "implicit"
    compensation: Compensation = "none"
    network: RBFNetwork = field(default_factory=RBFNetwork)
    error_compensation: Annotated[bool, Check(flag)] = True
    anti_saturation: Annotated[bool, Check(flag)] = True
    adaptation: Annotated[bool, Check(flag)] = True

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "filter", command_filter(self.filter))

    @property
    def _filter(self) -> CommandFilter:
        return cast(CommandFilter, self.filter)

    def init(self, q: Array, v: Array, desired: Desired) -> FTCFState:  # noqa: ARG002
        """psi1(0) = alpha(0); all else zero."""
        zero = np.zeros_like(q)
        alpha = virtual_control(self.gains, q - desired.q, desired.v, zero)
        return FTCFState(self._filter.init(alpha), zero, zero, zero, np.zeros(1))

    def step(
        self, state: FTCFState, q: Array, v: Array, desired: Desired, period: float
    ) -> tuple[Signals, FTCFState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        g, rho, theta = self.gains, state.rho, state.theta
        z1 = q - desired.q
        v1 = z1 - state.s1
        alpha = virtual_control(g, v1, desired.v, rho)
        abar, _, filter_state = self._filter.step(state.filter, alpha, period)
        z2 = v - abar
        v2 = z2 - state.s2 - rho
        B = self.network.basis(q, v)
        BB = B @ B

        M = self.nominal.mass_matrix(q)
        a = commanded_acceleration(g, v2, theta, BB, rho)
        u = M @ a + compensation_force(self.nominal, self.compensation, q, v, v - v2)

        eta = smooth_saturation(u, self.nominal.effort_limit)
        gap = solve_spd(M, eta - u)  # Mbar^-1 (eta(u) - u), (11)
        drive1 = -g.c1 * sig(state.s1, g.kappa) + (abar - alpha) + state.s2
        drive2 = -g.c2 * sig(state.s2, g.kappa)
        new = state._replace(filter=filter_state)
        if self.error_compensation:
            s1 = leaky_step(state.s1, g.k1, drive1, period)
            new = new._replace(s1=s1, s2=leaky_step(state.s2, g.k2, drive2, period))
        if self.anti_saturation:
            new = new._replace(rho=leaky_step(rho, 1.0, gap, period))
        if self.adaptation:
            new = new._replace(theta=leaky_step(theta, g.iota, adaptation_rate(g, v2, BB), period))
        signals = {
            "u": u,
            "alpha": alpha,
            "abar": abar,
            "z1": z1,
            "z2": z2,
            "v1": v1,
            "v2": v2,
            "s1": state.s1,
            "s2": state.s2,
            "rho": rho,
            "theta": theta[0],
        }
        return signals, new
