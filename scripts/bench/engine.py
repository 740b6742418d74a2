"""The compiled engine as a contender."""

import numpy as np
from timing import Contender

from ftcfa import ClosedLoop, simulate_paths
from ftcfa.arrays import Array

PATHS = 1024
ROBOTS = 64
"""Number of different robots among the paths of a varied run."""


def compiled(
    loop: ClosedLoop, threads: int, paths: int = PATHS, values: dict[str, Array] | None = None
) -> Contender:
    """The compiled engine; it records the first sample.

    Args:
        loop: The loop.
        threads: Number of threads.
        paths: Number of paths.
        values: Parameters that differ from path to path, as `varied` draws them.
    """

    def run(ticks: int) -> None:
        duration = (ticks - 1) * loop.period
        simulate_paths(loop, paths, duration, vary=values, record_every=ticks, threads=threads)

    name = "ftcfa" if values is None else "ftcfa, varied"
    return Contender(name, threads, run, paths, has_fixed=True)


def varied(loop: ClosedLoop) -> dict[str, Array]:
    """Another robot and other gains for every path."""
    rng = np.random.default_rng(1)
    nominal, gains = loop.controller.nominal, loop.controller.gains
    robots = np.array([nominal.perturbed(rng).inertias for _ in range(ROBOTS)])
    drawn = {
        f"controller.gains.{name}": value * rng.uniform(0.9, 1.1, PATHS)
        for name, value in vars(gains).items()
    }
    return {"arm.inertias": robots[np.arange(PATHS) % len(robots)], **drawn}
