"""Simulated paths beside Theorem 1: whether they keep to its premises, and how far from its bounds.

The theorem is of continuous time; what is measured is the sampled loop.
"""

from dataclasses import dataclass, replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.ftcf import FTCF, Gains
from ftcfa.engine.simulate import simulate_paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.references import Constant
from ftcfa.model.urdf.load import load_arm
from ftcfa.statistics.moments import Moments
from ftcfa.study.reproduction import GRAVITY, INTENSITY
from ftcfa.theory.generator import WATCHED, Along, generator, watched
from ftcfa.theory.theorem1 import Bounds
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.noise_input import BaseAcceleration
from ftcfa.vibration.vibration import Vibration

PATHS = 32
DURATION = 5.0
"""Of a small ensemble beside the bounds [s]."""

LINK_EPS = 0.3
"""What the bounds of `hanging_link` are given."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Theorem 1's quantities along simulated paths of a loop.

    Attributes:
        bounds: What was promised.
        time: Of the samples, shape (times,) [s].
        along: V, L V, phihat and B^T B, each of shape (paths, times); NaN after a divergence.
        z1: |z1|, shape (paths, times) [rad].
        filter_error: |abar - alpha|, shape (paths, times) [rad/s].
    """

    bounds: Bounds
    time: Array
    along: Along
    z1: Array
    filter_error: Array

    @property
    def needed_Gamma(self) -> Moments:
        """LV + Delta V^p over paths, entries a time: (30) in the mean asks for at most Gamma."""
        return Moments.of(self.along.LV + self.bounds.Delta * self.along.V**self.bounds.p)

    @property
    def entry(self) -> Array:
        """Time at which each path first has V <= Vinf, shape (paths,); NaN if it never does [s]."""
        inside = self.bounds.Vinf >= self.along.V
        return np.where(inside.any(axis=1), self.time[inside.argmax(axis=1)], np.nan)

    @property
    def missing_eps(self) -> Array:
        """What (24) lacks: phihat - sqrt(theta B^T B) - eps, shape (paths, times)."""
        covered = np.sqrt(self.bounds.theta * self.along.basis) + self.bounds.eps
        return self.along.demand - covered

    @property
    def premises_hold(self) -> Array:
        """Whether each path keeps to theta, eps and pi1 until its first entry, shape (paths,).

        The bound of the first-entry time asks for no more.
        """
        before = self.time < np.nan_to_num(self.entry, nan=np.inf)[:, None]
        kept = (self.missing_eps <= 0) & (self.filter_error <= self.bounds.pi1)
        return np.all(kept | ~before, axis=1)

    @property
    def late(self) -> Array:
        """|z1| over the last half, shape (paths, times/2)."""
        return self.z1[:, self.time >= self.time[-1] / 2]


def follow(
    loop: ClosedLoop,
    promised: Bounds,
    paths: int = PATHS,
    duration: float = DURATION,
    *,
    seed: int = 0,
    record_every: int = 1,
) -> Followed:
    """Run a loop and evaluate V and its generator along the paths, all with the loop's own arm.

    Args:
        loop: The loop.
        promised: Of `ftcfa.bounds` for it.
        paths: How many.
        duration: Simulated time [s].
        seed: Of the noise.
        record_every: Keep every so many samples; first entries are found to this resolution.
    """
    signals = (*WATCHED, "alpha", "abar")
    certain = replace(watched(loop), uncertainty=None, observer=None)
    run = simulate_paths(
        certain, paths, duration, seed=seed, signals=signals, record_every=record_every
    )
    return Followed(
        bounds=promised,
        time=run["time"].values,
        along=generator(loop).along(loop, run, promised.theta, promised.weight),
        z1=run["ote"].values,
        filter_error=np.linalg.norm(run["abar"].values - run["alpha"].values, axis=-1),
    )


def hanging_link() -> ClosedLoop:
    """A loop of which Theorem 1's first-entry time says something, the paper's kappa, k1 and k2.

    The paper's upper link with its load, at rest 0.4 rad off its reference, straight down, motors
    of 3 N m; eps = LINK_EPS, and pi1 = 1e-3 beside it, without which the premises fail. Found by a
    random search over gains, limits and starts. Two things make such loops rare. V0 must exceed
    Vinf, and there the saturation term stands for motors that saturate all the time: strong motors
    raise it, weak ones do saturate. And then rho' enters phihat through L abar and asks for a large
    eps, unless, as here, gravity takes the arm to where it shall go. The premises hold until the
    first entry; later phihat exceeds eps, so that the bound of |z1| is not proved. Bound and mean
    of the time: 3.27 s and 0.078 s, 2000 paths.
    """
    gains = Gains(c1=1.65, c2=1.6, iota=3.5, lambda_=1e-6, tau=1e-3)
    return _hanging(3.0, {"elbow": 0.0}, gains, WhiteNoise(INTENSITY), 0.4)


def hanging_pendulum() -> ClosedLoop:
    """The same for the paper's whole pendulum with motors of 0.24 N m, noise as printed, eps = 0.

    Give pi1 = 1e-3 here too. Bound and mean of the time: 3.98 s and 0.024 s, 2000 paths.
    """
    gains = Gains(c1=0.22, c2=0.29, iota=0.136, kappa=0.43, lambda_=1e-6, tau=1e-3)
    return _hanging(0.24, {}, gains, WhiteNoise(INTENSITY, "amplitude"), 0.26)


def _hanging(
    effort_limit: float, lock: dict[str, float], gains: Gains, noise: WhiteNoise, q0: float
) -> ClosedLoop:
    arm = load_arm("double_pendulum", gravity=GRAVITY, effort_limit=effort_limit, lock=lock)
    shaken = Vibration(BaseAcceleration("xz"), noise)
    down, start = np.zeros(arm.n), np.full(arm.n, q0)
    return ClosedLoop(arm, FTCF(arm, gains), Constant(down), shaken, q0=start)
