"""`sensitivity`: what each gain alone does to a cost, all others held."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ftcfa.checks import counting
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.objective import Objective, default_objective
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.trial import Trial

FACTORS = tuple(np.geomspace(0.25, 4.0, 13).tolist())
"""Factors of each number, 1 among them."""


def sensitivity(
    loop: ClosedLoop,
    duration: float,
    objective: Objective | None = None,
    space: Mapping[str, tuple[float, float]] | None = None,
    *,
    paths: int = 64,
    seed: int = 0,
    tolerance: float = 0.05,
    threads: int | None = None,
) -> xr.Dataset:
    """Cost and excess where one number of a law is some times as large as in a loop.

    All run on the same paths. Values beyond the range of the number stay at its end.

    Args:
        loop: The loop.
        duration: Simulated time of a path [s].
        objective: As for `ftcfa.tune`.
        space: As for `ftcfa.tune`.
        paths: Number of paths.
        seed: Seed of the paths.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        threads: Number of threads; by default all that this process may use.

    Returns:
        A Dataset over ``parameter`` and ``factor``: ``cost`` and ``excess``.
    """
    counting("sensitivity paths", paths)
    goal, plan = objective or default_objective(loop), Plan(float(duration), seed, 0, tolerance)
    trial = Trial(loop, plan, goal, Space(loop, space), threads)
    start, names = trial.space.unit_start, trial.space.names
    shape = len(names), len(FACTORS)
    points = np.broadcast_to(start, (*shape, len(start))).copy()
    for i, width in enumerate(trial.space.widths):
        points[i, :, i] = np.clip(start[i] + np.log(FACTORS) / width, 0.0, 1.0)
    score = trial.scored(points.reshape(-1, len(start)), range(paths))
    dims = ("parameter", "factor")
    return xr.Dataset(
        {
            "cost": (dims, score.cost.reshape(shape)),
            "excess": (dims, score.excess.reshape(shape), {"units": "1"}),
        },
        coords={"parameter": names, "factor": list(FACTORS)},
    )
