"""Finite-time backstepping without a filter, as in [15] and [16], and its singularity."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, not_negative
from ftcfa.control.fractional import sig
from ftcfa.control.gains import Gains, check_gains
from ftcfa.control.protocol import (
    Compensation,
    Desired,
    Measured,
    MemorylessLaw,
    Quantities,
    Quantity,
    Signals,
)
from ftcfa.model.dynamics import inertial_force
from ftcfa.parts import Parameters, number_fields

SMALLEST = 1e-300
"""Least width: a negative power of 0 is infinite."""


@dataclass(frozen=True, eq=False)
class FiniteTimeBackstepping(MemorylessLaw):
    """Finite-time backstepping with the analytic derivative of the virtual control.

        z1 = q - q_d,   alpha = -c1 beta(z1) - 3/4 (1 + k1) z1 + q_d',   z2 = v - alpha
        alpha' = -(c1 beta'(z1) + 3/4 (1 + k1)) (v - q_d') + q_d''
        u = M(q) (alpha' - c2 sig(z2, kappa) - (3/4 k2 + 5/4) z2) + compensation

    The exact law has beta(z) = sig(z, kappa), whose derivative kappa |z|^(kappa - 1) is infinite
    at zero: each time that a component of z1 crosses zero with v != q_d', u is unbounded. At the
    samples z1 is never quite zero, but it comes nearer to zero the smaller the period is.

    A ``width`` mu > 0 gives the usual regularised variant: within |z| < mu the power is replaced by
    the parabola that joins it with a continuous derivative (Wang, Chai and Zhai 2009, IEEE Trans.
    Ind. Electron. 56),

        beta(z) = (2 - kappa) mu^(kappa - 1) z + (kappa - 1) mu^(kappa - 2) z^2 sign(z),

    so that beta' <= (2 - kappa) mu^(kappa - 1); finite-time convergence holds down to mu only.
    We did not have [15] and [16]: this is the paper's FTCF without the filter.

    Attributes:
        nominal: The arm as the controller knows it.
        gains: Gains in the paper's symbols; iota, lambda and tau are not used.
        width: mu [rad or m]; 0 for the exact, singular law.
        compensation: Known force that is added to u, as in `FTCF`.
    """

    quantities: ClassVar[Quantities] = {
        "alpha": Quantity("rad/s", "virtual control"),
        "z1": Quantity("rad", "tracking error"),
        "z2": Quantity("rad/s", "velocity error"),
    }

    gains: Annotated[Gains, Check(check_gains)] = field(default_factory=Gains)
    width: Annotated[float, Check(not_negative, "rad or m", (1e-4, 0.3))] = 0.0
    compensation: Compensation = "bias"

    varies: ClassVar[Parameters] = number_fields("width")

    def signals(self, measured: Measured, desired: Desired) -> Signals:
        """The signals of one sample: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        g, linear = self.gains, self.gains.linear_position_rate
        z1 = q - desired.q
        beta, slope = joined_power(z1, g.kappa, self.width)
        alpha = -g.c1 * beta - linear * z1 + desired.v
        dalpha = -(g.c1 * slope + linear) * (v - desired.v) + desired.a
        z2 = v - alpha
        a = dalpha - g.c2 * sig(z2, g.kappa) - g.linear_velocity_rate * z2
        force = self.known_force(self.compensation, q, v, alpha)
        u = inertial_force(self.nominal, q, a) + force
        return {"u": u, "alpha": alpha, "z1": z1, "z2": z2}


def joined_power(z: Traceable, kappa: float, width: float) -> tuple[Traceable, Traceable]:
    """sig(z, kappa) joined within |z| < width by a parabola, and its derivative.

    With m = max(|z|, mu) and x = min(|z|/mu, 1), for all z at once:

        beta = sign(z) m^kappa x (2 - kappa + (kappa - 1) x)
        beta' = m^(kappa - 1) (2 - kappa + 2 (kappa - 1) x)

    Args:
        z: Shape (n,).
        kappa: Power, 0 < kappa <= 1.
        width: mu >= 0; at 0 the derivative at z = 0 is a very large number instead of infinite.

    Returns:
        beta and beta', shape (n,).
    """
    mu = np.maximum(width, SMALLEST)
    m = np.maximum(np.abs(z), mu)
    x = np.abs(z) / m  # = |z|/mu inside, 1 outside
    power = m ** (kappa - 1.0)
    beta = np.sign(z) * power * m * x * (2.0 - kappa + (kappa - 1.0) * x)
    return beta, power * (2.0 - kappa + 2.0 * (kappa - 1.0) * x)
