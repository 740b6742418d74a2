"""Super-twisting sliding-mode control, discretised so that it does not chatter."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Joints, Traceable
from ftcfa.checks import Check, positive_numbers
from ftcfa.control.filters import implicit_super_twisting
from ftcfa.control.gains import A1, A2, PositionRate
from ftcfa.control.protocol import Desired, Law, Measured, Quantities, Quantity, Signals
from ftcfa.model.dynamics import inertial_force
from ftcfa.parts import Parameters, checked_fields


class SuperTwistingState(NamedTuple):
    """State of the controller."""

    nu: Traceable
    """Integral part of the acceleration, shape (n,) [rad/s^2]."""


@dataclass(frozen=True, eq=False)
class SuperTwisting(Law):
    """Super-twisting control of a sliding variable (Levant 1993, Int. J. Control 58).

        v_r = q_d' - a1 (q - q_d),   s = v - v_r
        u = M(q) (v_r' + w) + C v + h + f(v_r)
        w = -r1 sig(s, 1/2) + nu,   nu' = -r2 sign(s)

    On s = 0 the error decays with the rate a1. For a disturbance whose derivative stays below L,
    r1 = 1.5 sqrt(L) and r2 = 1.1 L (Levant 1998, Automatica 34). White noise has no such L:
    the default r1 gives at s = 1 rad/s the same acceleration as the velocity rate a2 of the other
    laws, and r2 follows from r1.

    The sampled law is implicit, so that it does not chatter and keeps s within h^2 times the slope
    of a disturbance d. x, the part of s that the integral nu has not cancelled yet, solves

        x + h r1 sig(x, 1/2) + h^2 r2 sign(x) = s

    by `ftcfa.control.filters.implicit_super_twisting`, then nu <- nu - h r2 sign(x) and
    w = (x - s)/h + nu. Then x and nu + d follow the implicit Euler steps of the disturbed loop.
    Seeber and Andritsch (2025, Automatica 173, arXiv 2406.16094) prove that h^2 is the best
    possible; we had their abstract alone and derived these steps anew.

    While |u_i| exceeds its limit, nu_i holds: it would wind up on an error that it cannot lessen.

    Attributes:
        nominal: The arm as the controller knows it.
        position_rate: a1 [1/s].
        r1: Gain of the root term [rad^(1/2)/s^(3/2)].
        r2: Gain of the sign term [rad/s^3].
    """

    quantities: ClassVar[Quantities] = {
        "z1": Quantity("rad", "tracking error"),
        "s": Quantity("rad/s", "sliding variable"),
        "nu": Quantity("rad/s^2", "integral part of the acceleration"),
    }

    position_rate: PositionRate = A1
    r1: Annotated[Joints, Check(positive_numbers, "rad^(1/2)/s^(3/2)", (1.0, 1000.0))] = A2
    r2: Annotated[Joints, Check(positive_numbers, "rad/s^3", (0.1, 100000.0))] = (
        1.1 * (A2 / 1.5) ** 2
    )

    per_joint: ClassVar = ("position_rate", "r1", "r2")
    varies: ClassVar[Parameters] = checked_fields(*per_joint)

    def init(self, measured: Measured, desired: Desired) -> SuperTwistingState:
        """nu(0) = 0."""
        q = measured.q
        return SuperTwistingState(np.zeros_like(q))

    def step(
        self, state: SuperTwistingState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, SuperTwistingState]:
        """One sample of the law: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        z1 = q - desired.q
        v_r = desired.v - self.position_rate * z1
        a_r = desired.a - self.position_rate * (v - desired.v)
        s = v - v_r
        x, change = implicit_super_twisting(s, np.zeros_like(s), self.r1, self.r2, period)
        nu = state.nu + change
        a = a_r + (x - s) / period + nu
        force = self.known_force("bias", q, v, v_r)
        u = inertial_force(self.nominal, q, a) + force
        held = np.where(np.abs(u) > self.nominal.effort_limit, state.nu, nu)
        return {"u": u, "z1": z1, "s": s, "nu": state.nu}, SuperTwistingState(held)
