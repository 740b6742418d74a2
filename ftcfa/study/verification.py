"""`verify`: whether at least a share of all runs keeps a specification, with a known risk of error.

Paths are run and looked at in their order until a sequential test knows the answer
(`ftcfa.statistics.sequential_test`), so the answer does not depend on how many are run at once.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import (
    Check,
    check_fields,
    counting,
    natural,
    positive,
    positive_numbers,
    probability,
    vector,
)
from ftcfa.engine.run import run_paths, samples_of
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.statistics.estimate import Estimate
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.sequential_test import LARGEST_BETA, SequentialTest, Verdict
from ftcfa.study.path_metrics import PathMetrics

CHUNK = 256
"""Paths between two looks."""
WORST = 5
"""How many of the worst paths are named."""
REASONS = {
    "late_peak_error": "error",
    "peak_torque": "torque",
    "peak_torque_rate": "torque rate",
}
"""Metrics that are limited, in words."""


def check_confidence(subject: str, value: float) -> None:
    """Raise ParameterError unless a confidence is one that the sequential test can reach."""
    probability(subject, value)
    if 1 - value > LARGEST_BETA:
        raise ParameterError(subject, f"{value:g}", "2/3 or more")


@dataclass(frozen=True, eq=False)
class Specification:
    """What a run has to keep, and how many runs.

    Attributes:
        error: Largest overall tracking error |q - q_d| after ``within`` [rad or m].
        within: Time to get there [s].
        effort: Largest |u|, a number or one a joint [N m or N]; None for no limit of its own.
        torque_rate: Largest change of u from sample to sample over the period, a number or one a
            joint [N m/s or N/s]; None for no limit.
        share: Share of all runs that shall keep it.
        confidence: 1 - beta: yes and no are each wrong with probability beta at most.
        budget: Largest number of paths to run.
    """

    error: Annotated[float, Check(positive, "rad or m")]
    within: Annotated[float, Check(positive, "s")]
    effort: Annotated[npt.ArrayLike | None, Check(positive_numbers, "N m or N")] = None
    torque_rate: Annotated[npt.ArrayLike | None, Check(positive_numbers, "N m/s or N/s")] = None
    share: Annotated[float, Check(probability)] = 0.95
    confidence: Annotated[float, Check(check_confidence)] = 0.95
    budget: Annotated[int, Check(counting)] = 10_000

    def __post_init__(self) -> None:
        check_fields(self)

    def check(self, loop: ClosedLoop, duration: float) -> None:
        """Raise ParameterError or ShapeError unless it can be asked of runs of a loop."""
        if not self.within < duration:
            raise ParameterError(
                "Specification within",
                f"{self.within:g} s",
                f"less than the duration of {duration:g} s",
                field="within",
            )
        self.limits(loop.arm.n)

    def limits(self, n: int) -> dict[str, Array]:
        """Largest allowed values of metrics for n joints, shape (1,) or (n,)."""
        limits = {"late_peak_error": np.array([self.error])}
        for metric, name in (("peak_torque", "effort"), ("peak_torque_rate", "torque_rate")):
            limit = getattr(self, name)
            if limit is not None:
                limits[metric] = vector(f"Specification {name}", limit, n, field=name)
        return limits


@dataclass(frozen=True)
class WorstPath:
    """A path that broke the specification."""

    path: int
    """Its number, to `replay` it."""
    reason: str
    """What it did."""
    excess: float
    """How far it went, relative to the limit; inf if it diverged."""


@dataclass(frozen=True, eq=False)
class Verification:
    """The answer, and what it rests on.

    Attributes:
        answer: ``"yes"``, ``"no"`` or ``"undecided"``.
        verdict: Of the sequential test: paths that kept the specification, paths looked at, and
            bounds of the share that hold with the confidence asked for whenever one stops.
        fixed: The share among all paths that were run, with Clopper and Pearson's interval. It
            holds for a number of paths fixed beforehand: where the budget was used up.
        worst: The worst of the paths that were run, the worst first.
        seed: Of the paths.
        specification: What was asked.
    """

    answer: Literal["yes", "no", "undecided"]
    verdict: Verdict
    fixed: Estimate
    worst: tuple[WorstPath, ...]
    seed: int
    specification: Specification

    def __str__(self) -> str:
        asked, found = self.specification, self.verdict
        lines = [
            f"{self.answer}: {found.successes} of {found.trials} paths settle below "
            f"{asked.error:g} within {asked.within:g} s and keep the limits; the share is between "
            f"{found.low:.4g} and {found.high:.4g} (each bound with confidence "
            f"{asked.confidence:g}), asked for is {asked.share:g}"
        ]
        lines += [f"path {one.path} of seed {self.seed}: {one.reason}" for one in self.worst]
        return "\n".join(lines)


def verify(
    loop: ClosedLoop,
    specification: Specification,
    duration: float,
    *,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Verification:
    """Ask whether at least a share of all runs keeps a specification.

    Args:
        loop: The closed loop.
        specification: What is asked.
        duration: Length of a run, longer than ``within`` [s].
        seed: Of the random streams.
        threads: Threads; all that this process may use by default.
        progress: Called with the paths done and the budget.

    Raises:
        ParameterError, ShapeError: If an argument is out of range, or a limit has another number
            of joints.
    """
    natural("seed", seed)
    samples = samples_of(loop, duration)
    specification.check(loop, duration)
    limits = specification.limits(loop.arm.n)
    watched = replace(loop, observer=PathMetrics(specification.error, specification.within))
    beta = 1 - specification.confidence
    test = SequentialTest(specification.share, beta, specification.budget)
    excess, died, verdict = np.zeros((len(limits), 0)), np.zeros(0), test.judge([])
    for paths in _chunks(specification.budget):
        run = run_paths(watched, samples, samples, seed, paths, ["u"], {}, threads)
        part = _excess(watched, run.paths.observed, limits)
        excess = np.concatenate([excess, part], axis=1)
        died = np.concatenate([died, run.paths.died])
        verdict = test.judge(np.all(excess <= 1.0, axis=0))
        if progress is not None:
            progress(excess.shape[1], specification.budget)
        if verdict.finished:
            break
    kept = np.all(excess <= 1.0, axis=0)
    return Verification(
        verdict.answer,
        verdict,
        proportion(int(kept.sum()), kept.size, specification.confidence),
        _worst(excess, died, list(limits)),
        seed,
        specification,
    )


def _chunks(budget: int) -> Iterator[npt.NDArray[np.uint64]]:
    for start in range(0, budget, CHUNK):
        yield np.arange(start, min(start + CHUNK, budget), dtype=np.uint64)


def _excess(loop: ClosedLoop, observed: Any, limits: Mapping[str, Array]) -> Array:
    """Metrics over their limits, the worst joint's, shape (limits, paths); inf where diverged."""
    metrics = cast(PathMetrics, loop.observer).results(observed, loop.period)
    rows = [
        np.max(metrics[name].reshape(-1, len(limit)) / limit, axis=1)
        for name, limit in limits.items()
    ]
    return np.nan_to_num(np.array(rows), nan=np.inf, posinf=np.inf)


def _worst(excess: Array, died: Array, names: Sequence[str]) -> tuple[WorstPath, ...]:
    """The paths that went farthest beyond some limit."""
    largest = np.max(excess, axis=0)
    order = np.argsort(-largest, kind="stable")[:WORST]
    return tuple(
        WorstPath(int(path), _reason(excess[:, path], died[path], names), float(largest[path]))
        for path in order
        if largest[path] > 1.0
    )


def _reason(excess: Array, died: float, names: Sequence[str]) -> str:
    if np.isfinite(died):
        return f"diverges at {died:.4g} s"
    broken = [
        f"{REASONS[name]} {value:.3g} times its limit"
        for name, value in zip(names, excess, strict=True)
        if value > 1.0
    ]
    return ", ".join(broken)
