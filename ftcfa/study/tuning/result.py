"""The answer of `tune`: gains, what they cost, and how sure that is."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.bootstrap import paired_bootstrap
from ftcfa.study.comparison import compare
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.objective import Objective, Score
from ftcfa.study.tuning.space import Space

FRESH = 1 << 63
"""Bit of the seed that the paths of a validation have and those of a search do not."""
VALIDATION = 1000
"""Number of paths of a validation."""


@dataclass(frozen=True, eq=False)
class Tuning:
    """Gains that a search found.

    Attributes:
        given: The loop as it was given.
        space: What was searched.
        point: Point of the search, shape (d,); None if the loop as given was not bettered.
        objective: What was to be small.
        plan: How paths were run.
        excess: By how much the gains exceed the limits, relative to each; 0 if they keep all.
        broken: The limits that they exceed, each in words with its numbers.
        cost: Cost in the final, on paths that all finalists and the loop as given ran.
        cost_given: Cost of the loop as given on the same paths.
        less: 95 % interval of ``cost_given - cost``, a paired bootstrap over these paths. The
            best of several is chosen on them, which flatters it a little: see `validate`.
        final_paths: Number of these paths.
        excess_given: By how much the loop as given exceeds the limits there.
        cost_in_search: Cost of the winner of the last generation on that generation's paths: what
            the search believed.
        history: All candidates over ``generation`` and ``candidate``: their parameters, ``cost``,
            ``excess`` and the ``stage`` of the race after which they left; ``cost_given``.
    """

    given: ClosedLoop
    space: Space
    point: Array | None
    objective: Objective
    plan: Plan
    excess: float
    broken: tuple[str, ...]
    cost: float
    cost_given: float
    less: tuple[float, float]
    final_paths: int
    excess_given: float
    cost_in_search: float
    history: xr.Dataset

    @cached_property
    def loop(self) -> ClosedLoop:
        """The loop with the gains that were found."""
        return self.given if self.point is None else self.space.loop_at(self.given, self.point)

    @property
    def gains(self) -> dict[str, float | list[float]]:
        """The gains by dotted name; a list where each joint has its own."""
        if self.point is None:
            return {name: value.tolist() for name, value in self.space.start.items()}
        values = self.space.values(self.point[None])
        return {name: rows[0].tolist() for name, rows in values.items()}

    @property
    def tried(self) -> int:
        """Number of candidates that were tried."""
        return self.history.sizes["generation"] * self.history.sizes["candidate"]

    def validate(self, paths: int = VALIDATION, **options: Any) -> xr.Dataset:
        """Compare the loop as given with the tuned one, on paths that no search has used.

        Args:
            paths: Number of paths of each.
            options: Further arguments of `ftcfa.compare`.

        Returns:
            The Dataset of `ftcfa.compare`, with the attributes ``cost``, ``cost_given``, ``excess``
            and ``less``, the 95 % interval of ``cost_given - cost`` (paired bootstrap).
        """
        plan = self.plan
        loops = {"as given": self.given, "tuned": self.loop}  # one row if they are the same
        found = compare(
            loops, paths, plan.duration, seed=plan.seed ^ FRESH, tolerance=plan.tolerance,
            after=plan.after, lost=plan.lost, **options,
        )  # fmt: skip
        score = self.score_of(found)
        low, high = paired_bootstrap(self.objective.cost, self._metrics(found), -1)
        return found.assign_attrs(
            cost=float(score.cost[-1]),
            cost_given=float(score.cost[0]),
            excess=float(score.excess[-1]),
            less=[float(low[0]), float(high[0])],
        )

    def score_of(self, found: xr.Dataset) -> Score:
        """Scores of the loops of a comparison, of which the first is the loop as given."""
        values = self._metrics(found)
        return self.objective.score(values, {name: rows[0] for name, rows in values.items()})

    def _metrics(self, found: xr.Dataset) -> dict[str, Array]:
        """Metrics of the objective, shape (loops, paths) each, of a comparison."""
        return {name: found["values"].sel(metric=name).values for name in self.objective.metrics}

    @property
    def answer(self) -> Literal["yes", "no"]:
        """Whether the gains keep all limits."""
        return "yes" if self.excess == 0 else "no"

    @property
    def sentence(self) -> str:
        """The answer in a sentence."""
        searched = f"{self.tried:,} candidates of {len(self.space.names)} numbers"
        if self.excess > 0:
            return f"no: none of {searched} keeps the limits. The best: {'; '.join(self.broken)}"
        if self.point is None:
            return f"yes: the loop as given; none of {searched} is better (cost {self.cost:.4g})"
        beyond = ", which exceeds the limits" if self.excess_given > 0 else ""
        return (
            f"yes: cost {self.cost:.4g}, {self.cost_given:.4g} as given{beyond} (less by "
            f"{self.less[0]:.3g} to {self.less[1]:.3g} on {self.final_paths:,} paths); {searched}; "
            f"the search believed {self.cost_in_search:.4g}"
        )

    def __str__(self) -> str:
        lines = [self.sentence]
        for name, value in self.gains.items():
            unit = self.space.ranges[name].unit
            lines.append(
                f"  {name} = {np.array2string(np.array(value), precision=4)} {unit}".rstrip()
            )
        return "\n".join(lines)
