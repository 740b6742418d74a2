"""`front`: what one cost buys of another, such as error against torque rate."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.checks import counting
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.objective import Limit, Objective, Score, Term
from ftcfa.study.tuning.proposals import TwoCosts
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.trial import Trial
from ftcfa.study.tuning.tune import FINAL_PATHS, FIRST_OF_FINAL


def front(
    loop: ClosedLoop,
    duration: float,
    terms: Sequence[Term],
    limits: Sequence[Limit] = (),
    space: Mapping[str, tuple[float, float]] | None = None,
    *,
    generations: int = 30,
    candidates: int = 40,
    paths: int = 32,
    seed: int = 0,
    tolerance: float = 0.05,
    threads: int | None = None,
) -> xr.Dataset:
    """The gains of a loop's law that no others beat in both of two costs (NSGA-II).

    Args:
        loop: The loop; its law's gains are among the first candidates.
        duration: Simulated time of a path [s].
        terms: The two costs.
        limits: Limits that hold, as for `Objective`.
        space: As for `ftcfa.tune`.
        generations: Number of generations.
        candidates: Candidates of a generation.
        paths: Paths of each candidate; all of a generation run the same, those of the next others.
        seed: Seed of the proposals and of the paths.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        threads: Number of threads; by default all that this process may use.

    Returns:
        A Dataset over ``point``, in the order of the first cost: ``first`` and ``second``, the
        costs on paths of their own, and the parameters. Empty if no candidate keeps the limits.
    """
    if len(terms) != 2:
        raise ParameterError("front terms", f"{len(terms)} terms", "two")
    for name, number in (("generations", generations), ("candidates", candidates)):
        counting(f"front {name}", number)
    both = Objective(tuple(terms), tuple(limits))
    trial = Trial(
        loop, Plan(float(duration), seed, 0, tolerance), both, Space(loop, space), threads
    )
    proposals = TwoCosts(trial.space.unit_start, candidates, seed)
    found = np.zeros((0, len(trial.space.unit_start)))
    for number in range(generations):
        points = proposals.ask()
        scores = _scores(trial, points, range(number * paths, (number + 1) * paths))
        proposals.tell(*scores)
        found = np.vstack([found, points[_unbeaten(*scores)]])[-candidates * FINAL_PATHS :]
    found = np.unique(found.round(9), axis=0)
    scores = _scores(trial, found, range(FIRST_OF_FINAL, FIRST_OF_FINAL + FINAL_PATHS * paths))
    return _dataset(trial, found, scores)


def _scores(trial: Trial, points: Array, paths: range) -> tuple[Score, Score]:
    """Scores of candidates by each of the two terms."""
    together = trial.metrics(np.vstack([trial.space.unit_start, points]), paths)
    given = {name: rows[0] for name, rows in together.items()}
    values = {name: rows[1:] for name, rows in together.items()}
    excess, _ = trial.objective.score(values, given)
    first, second = (Score(excess, term.of(values)) for term in trial.objective.terms)
    return first, second


def _unbeaten(first: Score, second: Score) -> Array:
    """Which candidates keep the limits and are not worse than another in both costs."""
    a, b = first.cost, second.cost
    kept = (first.excess == 0) & np.isfinite(a) & np.isfinite(b)
    beats = (a[:, None] <= a) & (b[:, None] <= b) & ((a[:, None] < a) | (b[:, None] < b))
    return np.asarray(kept & ~np.any(beats & kept[:, None], axis=0))


def _dataset(trial: Trial, points: Array, scores: tuple[Score, Score]) -> xr.Dataset:
    """The unbeaten points in the order of the first cost."""
    first, second = scores
    chosen = np.flatnonzero(_unbeaten(first, second))
    chosen = chosen[np.argsort(first.cost[chosen])]
    values = trial.space.values(points[chosen])
    rows = {
        name: (("point", "joint")[: rows.ndim], rows, {"units": trial.space.ranges[name].unit})
        for name, rows in values.items()
    }
    costs = {"first": ("point", first.cost[chosen]), "second": ("point", second.cost[chosen])}
    return xr.Dataset({**costs, **rows})
