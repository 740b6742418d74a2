"""What a tuner makes small, and what it must not exceed.

    cost = sum over the terms of weight times statistic(metric)

A statistic is taken over the paths, each of which may have its own robot, delay and amplitude. A
candidate that exceeds a limit is worse than any that exceeds none, and of two that do, the one
that exceeds less is better.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import Check, known_name, not_negative, positive
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.parts import Part
from ftcfa.study.metrics.compared import COMPARED

TAIL = 0.05
"""Share of the worst paths of ``"q95"`` and ``"cvar95"``."""
Statistic = Literal["mean", "median", "q95", "cvar95", "largest"]
STATISTICS: Mapping[str, Callable[[Array], Array]] = {
    "mean": lambda x: np.mean(x, axis=-1),
    "median": lambda x: np.median(x, axis=-1),
    "q95": lambda x: np.quantile(x, 1.0 - TAIL, axis=-1, method="higher"),
    "cvar95": lambda x: np.mean(np.sort(x, axis=-1)[..., -_worst(x.shape[-1]) :], axis=-1),
    "largest": lambda x: np.max(x, axis=-1),
}
"""(..., paths) -> (...); ``"cvar95"`` is the mean of the worst 5 %."""
FAILED = "failed"
"""The metric that is 1 for a path that is not kept."""


def _worst(paths: int) -> int:
    """Number of the worst paths."""
    return max(1, round(TAIL * paths))


def check_metric(subject: str, name: str) -> None:
    """Raise UnknownNameError unless there is a metric of that name."""
    known_name(subject, name, tuple(COMPARED))


@dataclass(frozen=True)
class Term(Part):
    """One term of a cost.

    Attributes:
        metric: A metric of `ftcfa.compare`, such as ``"late_rms_error"``.
        weight: Cost of one unit of the metric.
        statistic: What is taken over the paths.
    """

    metric: Annotated[str, Check(check_metric)]
    weight: Annotated[float, Check(positive)] = 1.0
    statistic: Statistic = "q95"

    def of(self, values: Mapping[str, Array]) -> Array:
        """The weighted statistic of metrics of shape (..., paths)."""
        return self.weight * statistic(self, values)


@dataclass(frozen=True)
class Limit(Part):
    """A limit on a metric.

    Attributes:
        metric: A metric of `ftcfa.compare`, such as ``"rms_torque_rate"``.
        at_most: Largest value, in the metric's unit; None for the value of the loop as given, and
            for a share of at least SHARE.
        statistic: What is taken over the paths.
    """

    metric: Annotated[str, Check(check_metric)]
    at_most: Annotated[float | None, Check(not_negative)] = None
    statistic: Statistic = "mean"

    def most(self, given: Mapping[str, Array]) -> float:
        """The limit, with the metrics of the loop as given, shape (paths,) each."""
        if self.at_most is not None:
            return self.at_most
        least = SHARE if COMPARED[self.metric].percent else 0.0
        return max(least, float(statistic(self, given)))


class Score(NamedTuple):
    """How good some candidates are, each of shape (candidates,)."""

    excess: Array
    """Sum of what exceeds the limits, relative to each; 0 if nothing does."""
    cost: Array
    """Sum of the terms; infinite if a path diverged that counts."""

    @property
    def order(self) -> npt.NDArray[np.int_]:
        """The candidates from the best to the worst."""
        return np.lexsort((self.cost, self.excess))


@dataclass(frozen=True)
class Objective(Part):
    """What a tuner makes small, and what it must not exceed.

    Attributes:
        terms: Terms of the cost.
        limits: Limits that hold.
        kept: Smallest share of paths that keep their track and their limits.
    """

    terms: tuple[Term, ...]
    limits: tuple[Limit, ...] = ()
    kept: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.terms:
            raise ParameterError("Objective terms", "none", "one Term or more", field="terms")
        if not 0 <= self.kept <= 1:
            raise ParameterError("Objective kept", repr(self.kept), "a share", field="kept")

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of all metrics that it needs."""
        terms = [it.metric for it in self.terms]
        return tuple(dict.fromkeys([*terms, *(it.metric for it in self.limits), FAILED]))

    def broken(self, values: Mapping[str, Array], given: Mapping[str, Array]) -> tuple[str, ...]:
        """The limits that one candidate exceeds, in words; metrics of shape (paths,) each."""
        found, lost = [], float(np.mean(values[FAILED]))
        if lost > 1.0 - self.kept:
            found.append(f"{lost:.1%} of the paths are lost, at most {1.0 - self.kept:.1%}")
        for limit in self.limits:
            most, value = limit.most(given), float(statistic(limit, values))
            if value > most:
                unit, name = COMPARED[limit.metric].unit, f"{limit.metric} ({limit.statistic})"
                found.append(f"{name} {value:.4g} {unit}, at most {most:.4g}")
        return tuple(found)

    def score(self, values: Mapping[str, Array], given: Mapping[str, Array]) -> Score:
        """The score of candidates.

        Args:
            values: Metrics of each candidate, shape (candidates, paths); NaN where a path diverged.
            given: Metrics of the loop as given on the same paths, shape (paths,).
        """
        lost = np.mean(values[FAILED], axis=-1)
        excess = np.maximum(0.0, lost - (1.0 - self.kept)) * LOST
        for limit in self.limits:
            most = limit.most(given)
            found = statistic(limit, values)
            over = np.maximum(0.0, found - most) / max(most, SMALLEST)
            excess = excess + np.where(np.isfinite(most), np.minimum(over, LOST), 0.0)
        return Score(excess, self.cost(values))

    def cost(self, values: Mapping[str, Array]) -> Array:
        """The sum of the terms of metrics of shape (..., paths)."""
        return np.asarray(sum(term.of(values) for term in self.terms))


SHARE = 0.01
"""A share of samples or paths that is as good as none."""
LOST = 1e3
"""Excess where all paths are lost, and the largest of one limit."""
SMALLEST = 1e-9
"""Smallest limit to which an excess is relative."""


def statistic(it: Term | Limit, values: Mapping[str, Array]) -> Array:
    """The statistic of a term or a limit; a path that diverged counts as infinite."""
    with np.errstate(invalid="ignore"):
        return STATISTICS[it.statistic](np.nan_to_num(values[it.metric], nan=np.inf, posinf=np.inf))


def default_objective(loop: ClosedLoop) -> Objective:
    """The error of the worst 5 % of the paths; a second of settling counts as a milliradian.

    99 % of the paths are kept. On average the torque rate, the share of saturated samples and that
    of paths beyond a limit of position or velocity are not above those of the loop as given. Where
    a driver limits torque rates, it does so at 1 % of the samples at most.
    """
    terms = (Term("late_rms_error"), Term("settling_time", 1e-3, "mean"))
    limits = [Limit("rms_torque_rate"), Limit("saturated"), Limit("beyond_limits")]
    if loop.hardware is not None:
        limits.append(Limit("rate_limited", SHARE))
    return Objective(terms, tuple(limits), kept=1.0 - SHARE)
