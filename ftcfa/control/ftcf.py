"""The paper's controller: finite-time command-filtered adaptive backstepping, (5) to (12)."""

from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, flag
from ftcfa.control.anti_saturation import GAPS, AntiSaturation, anti_saturation
from ftcfa.control.filters import CommandFilter, command_filter, leaky_step
from ftcfa.control.fractional import sig
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
from ftcfa.model.dynamics import impulse_response, inertial_force


class FTCFState(NamedTuple):
    """State of the controller."""

    filter: Any
    """State of the command filter, (6)."""
    s1: Traceable
    """Error compensation of the position, shape (n,) [rad], (10)."""
    s2: Traceable
    """Error compensation of the velocity, shape (n,) [rad/s], (10); it stays zero."""
    rho: Traceable
    """Anti-saturation state, shape (n,) [rad/s], (11)."""
    theta: Traceable
    """Estimate of the squared norm of the network's weights, shape (1,), (9)."""


def virtual_control(gains: Gains, v1: Traceable, dq_d: Traceable, rho: Traceable) -> Traceable:
    """Virtual control of the first backstepping step.

        alpha = -c1 sig(v1, kappa) - 3/4 (1 + k1) v1 + q_d' - rho          (7)

    Shapes and units are those of `FTCF`; dq_d is q_d', shape (n,) [rad/s].
    """
    return -gains.c1 * sig(v1, gains.kappa) - gains.linear_position_rate * v1 + dq_d - rho


def commanded_acceleration(
    gains: Gains, v2: Traceable, theta: Traceable, BB: Traceable, rho: Traceable
) -> Traceable:
    """Acceleration that the controller commands of the nominal arm, Mbar^-1 u.

        a = -c2 sig(v2, kappa) - (3/4 k2 + 5/4) v2 - theta v2 (B^T B)/(4 tau) - rho      (8)

    Shapes and units are those of `FTCF`; BB is B^T B.
    """
    return (
        -gains.c2 * sig(v2, gains.kappa)
        - gains.linear_velocity_rate * v2
        - network_acceleration(gains, v2, theta, BB)
        - rho
    )


@dataclass(frozen=True, eq=False)
class FTCF(Law):
    """Finite-time command-filtered adaptive neural backstepping (Song, Zhao, Cui).

    At every sample, with sig(x, a) = sign(x) |x|^a component by component:

        z1 = q - q_d,  z2 = v - abar                                            (5)
        v1 = z1 - s1,  v2 = z2 - s2 - rho                                       (12)
        alpha = -c1 sig(v1, kappa) - 3/4 (1 + k1) v1 + q_d' - rho               (7)
        psi1' = zeta,  zeta = -r1 sig(psi1 - alpha, 1/2) + psi2,
        psi2' = -r2 sign(psi1 - alpha),  abar = psi1                            (6)
        a  = -c2 sig(v2, kappa) - (3/4 k2 + 5/4) v2 - theta v2 (B^T B)/(4 tau) - rho
        u  = Mbar(q) a + compensation                                           (8)

    The states advance by one Euler step a period. Their linear decay is implicit, so that any
    leakage is stable at any period:

        theta' = -iota theta + lambda/(4 tau) (v2^T v2)^2 (B^T B)               (9)
        s1' = -k1 s1 - c1 sig(s1, kappa) + (abar - alpha) + s2
        s2' = -k2 s2 - c2 sig(s2, kappa)                                        (10)
        rho' = -rho + Mbar(q)^-1 gap(u)                                         (11)

    The paper prints gap(u) = eta(u) - u, which lets rho wind up while a torque is saturated; see
    `ftcfa.control.anti_saturation` for the gap that replaces it. All states start from
    psi1(0) = alpha(0) and zeros. Shapes and units for revolute joints: q, q_d, z1, v1, s1
    (n,) [rad]; v, alpha, abar, psi1, z2, v2, s2, rho (n,) [rad/s]; a, zeta, psi2 (n,) [rad/s^2];
    u and its limit u* (n,) [N m]; B (K,), `RBFNetwork.basis` at (q, v); theta (1,).

    Attributes:
        nominal: The arm as the controller knows it; Mbar is its inertia, u* its effort limit.
        gains: Gains in the paper's symbols.
        filter: Command filter, or its name in `ftcfa.control.filters.FILTERS`.
        compensation: Known force that is added to u: ``"none"`` (the paper), the nominal
            ``"gravity"`` h(q), or the nominal ``"bias"`` C v + h + f, friction at the velocity to
            which the law drives v, v - v2.
        network: The basis functions.
        error_compensation: Whether s1 and s2 move, (10); if not, they stay zero.
        anti_saturation: The gap that drives rho, (11), by its name in
            `ftcfa.control.anti_saturation`: ``"bounded"``, ``"paper"``, or ``"none"``: rho stays
            zero. True and False are the old words for ``"paper"`` and ``"none"``, and warn.
        adaptation: Whether theta moves, (9); if not, it stays zero and the network has no effect.
    """

    quantities: ClassVar[Quantities] = {
        "alpha": Quantity("rad/s", "virtual control (7)"),
        "abar": Quantity("rad/s", "filtered virtual control (6)"),
        "z1": Quantity("rad", "tracking error (5)"),
        "z2": Quantity("rad/s", "velocity error (5)"),
        "v1": Quantity("rad", "compensated tracking error (12)"),
        "v2": Quantity("rad/s", "compensated velocity error (12)"),
        "s1": Quantity("rad", "error compensation of the position (10)"),
        "s2": Quantity("rad/s", "error compensation of the velocity (10)"),
        "rho": Quantity("rad/s", "anti-saturation state (11)"),
        "theta": Quantity("1", "estimated squared norm of the network's weights (9)"),
    }

    gains: Annotated[Gains, Check(check_gains)] = field(default_factory=Gains)
    filter: CommandFilter | str = "implicit"
    compensation: Compensation = "none"
    network: RBFNetwork = field(default_factory=RBFNetwork)
    error_compensation: Annotated[bool, Check(flag)] = True
    anti_saturation: AntiSaturation | bool = "bounded"
    adaptation: Annotated[bool, Check(flag)] = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "anti_saturation", anti_saturation(self.anti_saturation))
        super().__post_init__()
        object.__setattr__(self, "filter", command_filter(self.filter))

    def init(self, measured: Measured, desired: Desired) -> FTCFState:
        """psi1(0) = alpha(0); all else zero."""
        q = measured.q
        zero = np.zeros_like(q)
        alpha = virtual_control(self.gains, q - desired.q, desired.v, zero)
        return FTCFState(command_filter(self.filter).init(alpha), zero, zero, zero, np.zeros(1))

    def step(
        self, state: FTCFState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, FTCFState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        g, rho, theta = self.gains, state.rho, state.theta
        z1 = q - desired.q
        v1 = z1 - state.s1
        alpha = virtual_control(g, v1, desired.v, rho)
        abar, _, filter_state = command_filter(self.filter).step(state.filter, alpha, period)
        z2 = v - abar
        v2 = z2 - state.s2 - rho
        BB = self.network.basis_square(q, v)

        a = commanded_acceleration(g, v2, theta, BB, rho)
        force = self.known_force(self.compensation, q, v, v - v2)
        u = inertial_force(self.nominal, q, a) + force

        drive1 = -g.c1 * sig(state.s1, g.kappa) + (abar - alpha) + state.s2
        drive2 = -g.c2 * sig(state.s2, g.kappa)
        new = state._replace(filter=filter_state)
        if self.error_compensation:
            s1 = leaky_step(state.s1, g.k1, drive1, period)
            new = new._replace(s1=s1, s2=leaky_step(state.s2, g.k2, drive2, period))
        gap_of = GAPS[str(self.anti_saturation)]
        if gap_of is not None:
            gap = gap_of(u, self.nominal.effort_limit)
            excess = impulse_response(self.nominal, q, v, gap, 0.0)
            new = new._replace(rho=leaky_step(rho, 1.0, excess, period))
        if self.adaptation:
            theta_new = adapted(g, self.network.largest_theta, theta, v2, BB, period)
            new = new._replace(theta=theta_new)
        errors = {"z1": z1, "z2": z2, "v1": v1, "v2": v2}
        states = {"s1": state.s1, "s2": state.s2, "rho": rho, "theta": theta[0]}
        return {"u": u, "alpha": alpha, "abar": abar, **errors, **states}, new
