"""Backstepping for manipulators under random vibration, as in [9] and [10] of the paper."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from ftcfa.checks import Check
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


@dataclass(frozen=True, eq=False)
class StochasticBackstepping(MemorylessLaw):
    """Asymptotic backstepping with the analytic derivative of the virtual control.

        z1 = q - q_d,   alpha = -a1 z1 + q_d',   z2 = v - alpha
        alpha' = -a1 (v - q_d') + q_d''
        u = M(q) (alpha' - a2 z2) + compensation

    With V = (z1^T z1)^2/4 + (z2^T z2)^2/4, Young's inequality gives

        L V <= -(a1 - 3/4) |z1|^4 - (a2 - 1/4 - 3/4) |z2|^4 + 3/4 |M^-1 Lambda Sigma|_F^4

    alpha depends on q alone, which has no noise of its own, so Ito's formula adds nothing to
    alpha'. a1 = c1 + 3/4 (1 + k1) and a2 = c2 + 3/4 k2 + 5/4 are the rates of the asymptotic
    FTCF. In (z1, z1') the law is computed torque with the poles -a1 and -a2. We did
    not have [9] and [10]: the law follows the paper's description of them.

    Attributes:
        nominal: The arm as the controller knows it.
        gains: Gains in the paper's symbols; only c1, c2, k1 and k2 are used.
        compensation: Known force that is added to u, as in `FTCF`.
    """

    quantities: ClassVar[Quantities] = {
        "alpha": Quantity("rad/s", "virtual control"),
        "z1": Quantity("rad", "tracking error"),
        "z2": Quantity("rad/s", "velocity error"),
    }

    gains: Annotated[Gains, Check(check_gains)] = field(default_factory=Gains)
    compensation: Compensation = "bias"

    def signals(self, measured: Measured, desired: Desired) -> Signals:
        """The signals of one sample: see `ftcfa.control.protocol.Controller`."""
        q, v = measured.q, measured.v
        a1, a2 = self.gains.position_rate, self.gains.velocity_rate
        z1 = q - desired.q
        alpha = -a1 * z1 + desired.v
        dalpha = -a1 * (v - desired.v) + desired.a
        z2 = v - alpha
        force = self.known_force(self.compensation, q, v, alpha)
        u = inertial_force(self.nominal, q, dalpha - a2 * z2) + force
        return {"u": u, "alpha": alpha, "z1": z1, "z2": z2}
