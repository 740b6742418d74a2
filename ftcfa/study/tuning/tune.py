"""`tune`: gains for an arm, its base and its hardware, by simulation.

CMA-ES proposes a generation of candidates. They race on paths that are new in each generation and
the same for all candidates of it, beside the loop as given. In the end the winners of the last
generations, the best candidate of all, the suggested gains and the loop as given run on further
paths, until paired intervals tell the best from the others or the paths are used up.
`Tuning.validate` compares it with the loop as given on paths that were never used.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.checks import counting
from ftcfa.description.write import provenance
from ftcfa.engine.dataset import versions
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.feasibility import warn_of_doubts
from ftcfa.study.plan import Plan
from ftcfa.study.progress import Interrupted
from ftcfa.study.tuning.log import Log
from ftcfa.study.tuning.objective import Objective, default_objective
from ftcfa.study.tuning.proposals import OneCost
from ftcfa.study.tuning.result import Tuning
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.start import suggested
from ftcfa.study.tuning.trial import Race, Trial

FINALISTS = 5
"""Number of last generations whose winners come into the final."""
FINAL_PATHS = 2
"""Number of paths of the first stage of the final, in those of a generation."""
FIRST_OF_FINAL = 2**32
"""Number of the first path of the final."""
Shown = Callable[[int, float], None]
"""Called with the number of generations that are done, and the best cost of the last."""


def tune(
    loop: ClosedLoop,
    duration: float,
    objective: Objective | None = None,
    space: Mapping[str, tuple[float, float]] | None = None,
    *,
    generations: int = 30,
    candidates: int = 24,
    paths: int = 64,
    seed: int = 0,
    condition: Callable[[ClosedLoop], float] | None = None,
    tolerance: float = 0.05,
    after: float | None = None,
    lost: npt.ArrayLike | None = None,
    threads: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Shown | None = None,
) -> Tuning:
    """Search the gains of a loop's law, from those that `ftcfa.suggest_gains` suggests.

    The robots, delays and amplitudes among which gains have to do well are those that the loop's
    ``uncertainty`` and ``spread`` draw.

    Args:
        loop: The loop, with which the result is compared.
        duration: Simulated time of a path [s].
        objective: What is to be small and what must not be exceeded; by default
            `ftcfa.study.tuning.objective.default_objective`.
        space: Parameters and their ranges ``(smallest, largest)``, by dotted name such as
            ``controller.gains.c1``; by default all that the law declares. A parameter that has a
            number for each joint is tuned joint by joint.
        generations: Number of generations.
        candidates: Candidates of a generation.
        paths: Paths of each candidate that stays to the end of a generation.
        seed: Seed of the proposals and of the paths.
        condition: What else must hold: a function of the loop with a candidate's gains, above zero
            by how much they break it, such as `ftcfa.gain_shortfall`.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        after: Time from which errors count as late [s]; half of the duration by default.
        lost: Error beyond which a joint has lost track; see `ftcfa.ensemble`.
        threads: Number of threads; by default all that this process may use.
        store: A file from which the same search goes on, whenever it was stopped.
        progress: Called after each generation; see `Shown`.

    Returns:
        The gains with their history. The same arguments give the same gains, whether or not the
        search was stopped in between.

    Raises:
        ParameterError, UnknownNameError: If an argument is wrong.
        FtcfaError: If the extra ``tune`` is not installed, or the store cannot be used.
        Interrupted: At Ctrl-C. Its ``partial`` is the best so far, or None before the first
            generation is done.
    """
    for name, number in (
        ("generations", generations), ("candidates", candidates), ("paths", paths)
    ):  # fmt: skip
        counting(f"tune {name}", number)
    if candidates < 4:
        raise ParameterError("tune candidates", str(candidates), "4 or more")
    if not isinstance(loop, ClosedLoop):
        raise ParameterError("tune", f"a {type(loop).__name__}", "a ClosedLoop")
    warn_of_doubts(loop, duration)
    bounds = None if lost is None else tuple(np.broadcast_to(lost, loop.arm.n).tolist())
    trial = Trial(
        loop,
        Plan(float(duration), seed, 0, tolerance, after=after, lost=bounds),
        objective or default_objective(loop),
        Space(loop, space),
        threads,
        condition,
    )
    budget = {"candidates": candidates, "paths": paths}
    search = _Search(trial, Log(store, _identity(trial, budget)), budget)
    try:
        for number in range(generations):
            race = search.generation(number)
            if progress is not None:
                progress(number + 1, float(race.score.cost[race.order[0]]))
        return search.result()
    except KeyboardInterrupt:
        raise Interrupted("tune", search.result() if search.points else None) from None


class _Search:
    """A search under way: its proposals, and all that was tried."""

    def __init__(self, trial: Trial, log: Log, budget: Mapping[str, int]) -> None:
        self.trial, self.log = trial, log
        self.candidates, self.paths = budget["candidates"], budget["paths"]
        self.start = trial.space.point_of(suggested(trial.loop))
        self.proposals = OneCost(self.start, self.candidates, trial.plan.seed)
        self.points: list[Array] = []
        self.races: list[Race] = []

    def generation(self, number: int) -> Race:
        """Propose and race a generation, or take from the log how its race ended."""
        points = self.proposals.ask()
        if number < len(self.log.generations):
            race = Race.of(self.log.generations[number])
        else:
            first = number * self.paths
            race = self.trial.raced(points, range(first, first + self.paths))
            self.log.add(race.rows)
        self.proposals.tell(race.order.tolist())
        self.points.append(points)
        self.races.append(race)
        return race

    def result(self) -> Tuning:
        """The best of the finalists on further paths, or the loop as given if none is better."""
        winners = [
            points[race.order[0]] for points, race in zip(self.points, self.races, strict=True)
        ]
        keys = [(race.score.excess.min(), race.score.cost[race.order[0]]) for race in self.races]
        best = min(range(len(keys)), key=keys.__getitem__)
        finalists = np.unique(np.vstack([self.start, *winners[-FINALISTS:], winners[best]]), axis=0)
        final = self.trial.final(finalists, FIRST_OF_FINAL, FINAL_PATHS * self.paths)
        race = self.races[-1]
        return Tuning(
            given=self.trial.loop,
            space=self.trial.space,
            point=final.point,
            objective=self.trial.objective,
            plan=self.trial.plan,
            excess=final.excess,
            broken=final.broken,
            cost=final.cost,
            cost_given=final.cost_given,
            less=final.less,
            final_paths=final.paths,
            excess_given=final.excess_given,
            cost_in_search=float(race.score.cost[race.order[0]]),
            history=self._history(),
        )

    def _history(self) -> xr.Dataset:
        """All candidates, over generation and candidate."""
        dims = ("generation", "candidate")
        values = [self.trial.space.values(points) for points in self.points]
        rows: dict[str, Any] = {}
        for name in values[0]:
            found = np.stack([one[name] for one in values])
            unit = {"units": self.trial.space.ranges[name].unit}
            rows[name] = ((*dims, "joint")[: found.ndim], found, unit)
        for name, unit in (("cost", {}), ("excess", {"units": "1"})):
            rows[name] = (dims, np.stack([getattr(race.score, name) for race in self.races]), unit)
        rows["stage"] = (dims, np.stack([race.stage for race in self.races]))
        rows["cost_given"] = ("generation", [float(race.given.cost[0]) for race in self.races])
        return xr.Dataset(rows)


def _identity(trial: Trial, budget: Mapping[str, int]) -> dict[str, Any]:
    """What the numbers of a search depend on."""
    return {
        "loop": provenance(trial.loop),
        "plan": asdict(trial.plan),
        "objective": asdict(trial.objective),
        "space": {name: list(ends) for name, ends in trial.space.ranges.items()},
        "condition": getattr(trial.condition, "__qualname__", None),
        **budget,
        **versions(),
    }
