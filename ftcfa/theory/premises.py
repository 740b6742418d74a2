"""Theorem 1 beside simulated paths: whether its premises hold there, and how far its bounds are.

The theorem is about continuous time; the paths are those of the sampled loop.
"""

from dataclasses import dataclass, replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.engine.simulate import simulate_paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.moments import Moments
from ftcfa.theory.generator import STATE_SIGNALS, LyapunovValues, generator, with_filter_state
from ftcfa.theory.theorem1 import Bounds

PATHS = 32
"""Number of paths of a small ensemble."""
DURATION = 5.0
"""Simulated time of a small ensemble [s]."""


@dataclass(frozen=True, eq=False)
class TheoremPaths:
    """Theorem 1's quantities along simulated paths of a loop.

    Attributes:
        bounds: The bounds of the loop.
        time: Times of the samples, shape (times,) [s].
        values: V, L V, phihat and B^T B, each of shape (paths, times); NaN once a path diverged.
        z1: Tracking error |z1| = |q - q_d|, shape (paths, times) [rad].
        filter_error: |abar - alpha|, shape (paths, times) [rad/s].
        network_input: Largest |X_i| of the network's input X = (q, v), which Lemma 1 wants in a
            compact set, shape (paths, times) [rad and rad/s].
    """

    bounds: Bounds
    time: Array
    values: LyapunovValues
    z1: Array
    filter_error: Array
    network_input: Array

    @property
    def needed_Gamma(self) -> Moments:
        """Moments over the paths of LV + Delta V^p at each time; by (30) the means are <= Gamma."""
        return Moments.of(self.values.LV + self.bounds.Delta * self.values.V**self.bounds.p)

    @property
    def entry(self) -> Array:
        """Time at which each path first has V <= Vinf, shape (paths,) [s]; NaN if it never does."""
        inside = self.bounds.Vinf >= self.values.V
        return np.where(inside.any(axis=1), self.time[inside.argmax(axis=1)], np.nan)

    @property
    def missing_eps(self) -> Array:
        """Excess of phihat over the premise (24), shape (paths, times); positive if it is broken.

        phihat - sqrt(theta B^T B) - eps
        """
        covered = np.sqrt(self.bounds.theta * self.values.basis) + self.bounds.eps
        return self.values.demand - covered

    @property
    def premises_hold(self) -> Array:
        """Whether theta, eps and pi1 hold on each path until its first entry, shape (paths,).

        The bound of the first-entry time needs no more.
        """
        before = self.time < np.nan_to_num(self.entry, nan=np.inf)[:, None]
        hold = (self.missing_eps <= 0) & (self.filter_error <= self.bounds.pi1)
        return np.all(hold | ~before, axis=1)

    @property
    def late_error(self) -> Array:
        """|z1| in the second half of the time, shape (paths, times/2) [rad]."""
        return self.z1[:, self.time >= self.time[-1] / 2]


def theorem_paths(
    loop: ClosedLoop,
    bounds: Bounds,
    paths: int = PATHS,
    duration: float = DURATION,
    *,
    seed: int = 0,
    record_every: int = 1,
) -> TheoremPaths:
    """Simulate a loop, every path with the loop's own arm, and evaluate V and L V along the paths.

    Args:
        loop: The loop.
        bounds: Result of `ftcfa.bounds` for it.
        paths: Number of paths.
        duration: Simulated time [s].
        seed: Seed of the noise.
        record_every: Every so many samples are kept; first entries are resolved no finer.
    """
    signals = (*STATE_SIGNALS, "alpha", "abar")
    certain = replace(with_filter_state(loop), uncertainty=None, observer=None)
    run = simulate_paths(
        certain, paths, duration, seed=seed, signals=signals, record_every=record_every
    )
    return TheoremPaths(
        bounds=bounds,
        time=run["time"].values,
        values=generator(loop).along(loop, run, bounds.theta, bounds.weight),
        z1=run["ote"].values,
        filter_error=np.linalg.norm(run["abar"].values - run["alpha"].values, axis=-1),
        network_input=np.max(np.abs([run["q"].values, run["v"].values]), axis=(0, -1)),
    )
