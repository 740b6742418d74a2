"""Candidates tried on the same paths: the same noise, the same robots, other gains.

All candidates of a batch run at once, their gains as inputs of the same compiled code. In a race
the worse half leaves after a quarter and again after half of the paths; `ftcfa.study.tuning.tune`
needs the order of the better half only, which the race keeps.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.engine.run import run_paths, samples_of
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.bootstrap import paired_bootstrap
from ftcfa.study.chunk import metrics_of
from ftcfa.study.metrics.compared import COMPARED
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.objective import Objective, Score
from ftcfa.study.tuning.space import Space

STAGES = (0.25, 0.5, 1.0)
"""Shares of the paths after which the worse half of a race leaves."""
FINAL_STAGES = 5
"""Number of stages of a final; each after the first doubles the paths."""
NEARLY = 0.05
"""Excess over the limits that more paths may take back."""
NOTHING_RECORDED = 10**9
"""Number of samples from one that is recorded to the next."""


@dataclass(frozen=True, eq=False)
class Trial:
    """How candidates are tried.

    Attributes:
        loop: The loop as given.
        plan: Duration, seed, tolerance and the other numbers that metrics depend on.
        objective: What is to be small.
        space: What a candidate is.
        threads: Number of threads; by default all that this process may use.
        condition: What else must hold of a candidate's loop: above zero by how much it does not.
    """

    loop: ClosedLoop
    plan: Plan
    objective: Objective
    space: Space
    threads: int | None = None
    condition: Callable[[ClosedLoop], float] | None = None

    def metrics(self, points: Array, paths: range) -> dict[str, Array]:
        """Metrics of candidates, shape (candidates, d), on paths: each (candidates, paths)."""
        observed, count = self.plan.observed(self.loop), len(paths)
        samples = samples_of(observed, self.plan.duration)
        numbers = np.tile(np.array(paths, dtype=np.uint64), len(points))
        vary = {
            name: np.repeat(rows, count, axis=0) for name, rows in self.space.values(points).items()
        }
        run = run_paths(
            observed, samples, NOTHING_RECORDED, self.plan.seed, numbers, [], vary, self.threads
        )
        found = metrics_of(observed, run).assign_attrs(duration=self.plan.duration)
        limit = self.loop.arm.effort_limit
        return {
            name: COMPARED[name].values(found, limit).reshape(len(points), count)
            for name in self.objective.metrics
        }

    def scored(self, points: Array, paths: range) -> Score:
        """Scores of candidates, all on the same paths beside the loop as given."""
        score, _ = self._scores(self.metrics(np.vstack([self.space.unit_start, points]), paths))
        return score._replace(excess=score.excess + self._broken(points))

    def final(self, points: Array, first: int, paths: int) -> "Final":
        """The best of candidates and the loop as given, all on the same paths.

        Those that paired intervals tell apart from the best leave, and the others run as many paths
        again, until only the best is left or all FINAL_STAGES are run. If the best is then not told
        apart from the loop as given, and that breaks no more of the limits, the loop as given is
        the answer.

        Args:
            points: The candidates, shape (candidates, d).
            first: Number of the first path.
            paths: Number of paths of the first stage.
        """
        everyone = np.vstack([self.space.unit_start, points])
        condition = np.append(0.0, self._broken(points))
        known: dict[str, Array] = {}
        alive, end = np.arange(len(everyone)), first
        for stage in range(FINAL_STAGES):
            new = self.metrics(everyone[alive], range(end, first + (paths << stage)))
            known = _joined(known, new) if known else new
            end = first + (paths << stage)
            score = self._score(known)
            score = score._replace(excess=score.excess + condition[alive])
            best = int(score.order[0])
            low, high = paired_bootstrap(self.objective.cost, known, best)
            stay = (score.excess <= score.excess[best] + NEARLY) & ~(low > 0)
            if stage == FINAL_STAGES - 1 or np.sum(stay) == 1:
                break
            stay[0] = True  # limits may be those of the loop as given
            known = {name: rows[stay] for name, rows in known.items()}
            alive = alive[stay]
        if score.excess[0] <= score.excess[best] and not low[0] > 0:
            best, low, high = 0, low - low[0], high - high[0]  # none is surely better
        rows = ({name: values[i] for name, values in known.items()} for i in (best, 0))
        broken = self.objective.broken(*rows) or (("the condition",) * bool(score.excess[best]))
        return Final(
            point=None if best == 0 else everyone[alive[best]],
            excess=float(score.excess[best]),
            broken=broken,
            cost=float(score.cost[best]),
            cost_given=float(score.cost[0]),
            less=(float(low[0]), float(high[0])),
            excess_given=float(score.excess[0]),
            paths=end - first,
        )

    def _broken(self, points: Array) -> Array:
        """By how much candidates break the condition, shape (candidates,)."""
        if self.condition is None:
            return np.zeros(len(points))
        loops = (self.space.loop_at(self.loop, point) for point in points)
        return np.array([max(0.0, float(self.condition(loop))) for loop in loops])

    def raced(self, points: Array, paths: range) -> "Race":
        """Race candidates: see the module. The first stage runs a quarter of the paths."""
        start, broken = self.space.unit_start[None], self._broken(points)
        alive, known = np.arange(len(points)), None
        stage = np.zeros(len(points), dtype=int)
        excess, cost = np.full((2, len(points)), np.inf)
        first, ends = 0, np.unique(np.ceil(np.array(STAGES) * len(paths)).astype(int)).tolist()
        for number, last in enumerate(ends):
            new = self.metrics(np.vstack([start, points[alive]]), paths[first:last])
            known = new if known is None else _joined(known, new)
            score, given = self._scores(known)
            score = score._replace(excess=score.excess + broken[alive])
            stage[alive], excess[alive], cost[alive] = number, score.excess, score.cost
            stay = np.sort(score.order[: -(-len(alive) // 2)])
            if last < len(paths):
                known = {name: rows[np.append(0, stay + 1)] for name, rows in known.items()}
                alive, first = alive[stay], last
        return Race(Score(excess, cost), stage, given)

    def _score(self, together: Mapping[str, Array]) -> Score:
        """Scores of the loop as given, which is the first row, and of the candidates."""
        given = {name: rows[0] for name, rows in together.items()}
        return self.objective.score(together, given)

    def _scores(self, together: Mapping[str, Array]) -> tuple[Score, Score]:
        """Scores of the candidates and of the loop as given, which is the first row."""
        all_scores = self._score(together)
        return Score(*(x[1:] for x in all_scores)), Score(*(x[:1] for x in all_scores))


class Final(NamedTuple):
    """The best of a final."""

    point: Array | None
    """Its point, shape (d,); None if it is the loop as given."""
    excess: float
    """By how much it exceeds the limits."""
    broken: tuple[str, ...]
    """The limits that it exceeds, in words."""
    cost: float
    """Its cost."""
    cost_given: float
    """The cost of the loop as given."""
    less: tuple[float, float]
    """95 % interval of how much more the loop as given costs, paired."""
    excess_given: float
    """By how much the loop as given exceeds the limits."""
    paths: int
    """Number of paths that were run."""


@dataclass(frozen=True, eq=False)
class Race:
    """The end of a race.

    Attributes:
        score: Score of each candidate over the paths that it ran.
        stage: Number of the stage after which each candidate left, shape (candidates,).
        given: Score of the loop as given over all paths.
    """

    score: Score
    stage: npt.NDArray[np.int_]
    given: Score

    @property
    def rows(self) -> dict[str, Array]:
        """All numbers by name."""
        given = np.array([self.given.excess[0], self.given.cost[0]])
        rows = {"excess": self.score.excess, "cost": self.score.cost}
        return {**rows, "stage": self.stage, "given": given}

    @classmethod
    def of(cls, rows: Mapping[str, Array]) -> "Race":
        """The race with the numbers of `rows`."""
        score = Score(rows["excess"], rows["cost"])
        given = Score(rows["given"][:1], rows["given"][1:])
        return cls(score, rows["stage"].astype(int), given)

    @property
    def order(self) -> npt.NDArray[np.int_]:
        """The candidates from the best to the worst: those that came further first."""
        return np.lexsort((self.score.cost, self.score.excess, -self.stage))


def _joined(known: Mapping[str, Array], new: Mapping[str, Array]) -> dict[str, Array]:
    return {name: np.concatenate([rows, new[name]], axis=1) for name, rows in known.items()}
