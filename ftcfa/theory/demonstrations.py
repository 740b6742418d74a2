"""Loops for which Theorem 1's bound of the first-entry time is finite.

Such loops are rare. V0 must exceed Vinf, and Vinf holds the saturation term, as if the motors
saturated all the time: strong motors make that term large, and weak motors do saturate. Then rho'
enters phihat through L abar and demands a large eps, unless gravity moves the arm to its reference,
as it does here. Both loops come from a random search over gains, limits and starts.

The premises hold until the first entry. Later phihat exceeds eps, so that the bound of |z1| is not
proved for them.
"""

import numpy as np

from ftcfa.control.ftcf import FTCF
from ftcfa.control.gains import Gains
from ftcfa.control.laws import printed
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.references import Constant
from ftcfa.model.urdf.load import load_arm
from ftcfa.study.reproduction import GRAVITY, INTENSITY
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.noise_input import BaseAcceleration
from ftcfa.vibration.vibration import Vibration

PI1 = 1e-3
"""Filter error pi1 for the bounds of both loops; their paths stay below 1e-4 [rad/s]."""
LINK_EPS = 0.3
"""Network error eps for the bounds of `hanging_link`; `hanging_pendulum` needs none."""


def hanging_link() -> ClosedLoop:
    """The paper's upper link with its load, hanging, at the paper's kappa, k1 and k2.

    It starts at rest 0.4 rad from its reference, which is straight down; its motor has 3 N m. With
    eps = LINK_EPS and pi1 = PI1 the first-entry time is bounded by 3.27 s; its mean is 0.078 s
    (2000 paths).
    """
    gains = Gains(c1=1.65, c2=1.6, iota=3.5, lambda_=1e-6, tau=1e-3)
    return _hanging(3.0, {"elbow": 0.0}, gains, WhiteNoise(INTENSITY), 0.4)


def hanging_pendulum() -> ClosedLoop:
    """The paper's whole pendulum, hanging, with motors of 0.24 N m and the noise as printed.

    With eps = 0 and pi1 = PI1 the first-entry time is bounded by 3.98 s; its mean is 0.024 s
    (2000 paths).
    """
    gains = Gains(c1=0.22, c2=0.29, iota=0.136, kappa=0.43, lambda_=1e-6, tau=1e-3)
    return _hanging(0.24, {}, gains, WhiteNoise(INTENSITY, "amplitude"), 0.26)


def _hanging(
    effort_limit: float, lock: dict[str, float], gains: Gains, noise: WhiteNoise, q0: float
) -> ClosedLoop:
    """A loop that starts at rest, every joint q0 [rad] from straight down."""
    arm = load_arm("double_pendulum", gravity=GRAVITY, effort_limit=effort_limit, lock=lock)
    vibration = Vibration(BaseAcceleration("xz"), noise)
    down, start = np.zeros(arm.n), np.full(arm.n, q0)
    return ClosedLoop(arm, printed(FTCF(arm, gains)), Constant(down), vibration, q0=start)
