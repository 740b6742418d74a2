"""Asymptotic adaptive command-filtered backstepping, as in [8] and [11] of the paper."""

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check
from ftcfa.control.filters import CommandFilter, command_filter, leaky_step
from ftcfa.control.gains import Gains, check_gains
from ftcfa.control.network import RBFNetwork, adapted, network_acceleration
from ftcfa.control.protocol import (
    Compensation,
    Desired,
    Law,
    Measured,
    Quantities,
    Quantity,
    Signals,
)
from ftcfa.model.dynamics import inertial_force


class FilteredState(NamedTuple):
    """State of the controller."""

    filter: Any
    """State of the command filter."""
    s1: Traceable
    """Error compensation of the position, shape (n,) [rad]."""
    theta: Traceable
    """Estimate of the squared norm of the network's weights, shape (1,)."""


@dataclass(frozen=True, eq=False)
class CommandFilteredBackstepping(Law):
    """Adaptive command-filtered backstepping with a second-order filter and known inertia matrix.

        z1 = q - q_d,  z2 = v - abar,  v1 = z1 - s1
        alpha = -a1 z1 + q_d'
        s1'   = -a1 s1 + (abar - alpha),  s1(0) = 0       (so v1' = -a1 v1 + z2)
        a     = abar' - a2 z2 - theta z2 (B^T B)/(4 tau)
        u     = M(q) a + compensation
        theta' = -iota theta + lambda/(4 tau) (z2^T z2)^2 (B^T B),  theta(0) = 0

    a1 = c1 + 3/4 (1 + k1) and a2 = c2 + 3/4 k2 + 5/4 are the rates of the asymptotic FTCF, so
    the quartic Lyapunov function of the paper, V = (v1^T v1)^2/4 + (z2^T z2)^2/4 + ..., applies
    with kappa = 1. The coupling term -v1 of Farrell, Polycarpou, Sharma and Dong (Command filtered
    backstepping, IEEE Trans. Autom. Control 54, 2009) is left out: their quadratic V needs it to
    cancel v1^T z2, whereas here |v1|^2 v1^T z2 <= 3/4 |v1|^4 + 1/4 |z2|^4 (Young), which the 3/4
    in a1 and 1/4 of the 5/4 in a2 pay for. Unlike FTCF, the law feeds the filter's derivative
    forward, its filter is linear and it has no anti-saturation state. We did not have the sources:
    error compensation and filter are those that the literature gives for [8], and the network is
    the one of the paper, which says that [11] "requires a completely known inertia matrix".

    Attributes:
        nominal: The arm as the controller knows it.
        gains: Gains in the paper's symbols; only a1, a2, iota, lambda and tau are used.
        filter: Command filter, or its name in `ftcfa.control.filters.FILTERS`.
        compensation: Known force that is added to u, as in `FTCF`.
        network: The basis functions.
    """

    quantities: ClassVar[Quantities] = {
        "alpha": Quantity("rad/s", "virtual control"),
        "abar": Quantity("rad/s", "filtered virtual control"),
        "z1": Quantity("rad", "tracking error"),
        "z2": Quantity("rad/s", "velocity error"),
        "v1": Quantity("rad", "compensated tracking error"),
        "s1": Quantity("rad", "error compensation of the position"),
        "theta": Quantity("1", "estimated squared norm of the network's weights"),
    }

    gains: Annotated[Gains, Check(check_gains)] = field(default_factory=Gains)
    filter: CommandFilter | str = "second-order"
    compensation: Compensation = "bias"
    network: RBFNetwork = field(default_factory=RBFNetwork)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "filter", command_filter(self.filter))

    def _virtual_control(self, z1: Traceable, dq_d: Traceable) -> Traceable:
        return -self.gains.position_rate * z1 + dq_d

    def init(self, measured: Measured, desired: Desired) -> FilteredState:
        """psi1(0) = alpha(0); all else zero."""
        q = measured.q
        alpha = self._virtual_control(q - desired.q, desired.v)
        return FilteredState(command_filter(self.filter).init(alpha), np.zeros_like(q), np.zeros(1))

    def step(
        self, state: FilteredState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, FilteredState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        g, theta = self.gains, state.theta
        z1 = q - desired.q
        alpha = self._virtual_control(z1, desired.v)
        abar, dabar, filter_state = command_filter(self.filter).step(state.filter, alpha, period)
        z2 = v - abar
        BB = self.network.basis_square(q, v)

        a = dabar - g.velocity_rate * z2 - network_acceleration(g, z2, theta, BB)
        force = self.known_force(self.compensation, q, v, abar)
        u = inertial_force(self.nominal, q, a) + force

        new = FilteredState(
            filter=filter_state,
            s1=leaky_step(state.s1, g.position_rate, abar - alpha, period),
            theta=adapted(g, self.network.largest_theta, theta, z2, BB, period),
        )
        errors = {"z1": z1, "z2": z2, "v1": z1 - state.s1}
        states = {"s1": state.s1, "theta": theta[0]}
        return {"u": u, "alpha": alpha, "abar": abar, **errors, **states}, new
