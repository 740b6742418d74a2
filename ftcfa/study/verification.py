"""`verify`: whether at least a share of all runs keeps a specification, with a known risk of error.

Paths are run and judged in their order until a sequential test decides
(`ftcfa.statistics.sequential_test`), so the answer does not depend on how many are run at once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import (
    Check,
    counting,
    flag,
    natural,
    positive,
    positive_numbers,
    positive_or_infinite,
    probability,
    vector,
)
from ftcfa.engine.run import run_paths, samples_of
from ftcfa.errors import ParameterError
from ftcfa.loop.bounds import bounds_of
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.feasibility import warn_of_doubts
from ftcfa.model.arm import Arm
from ftcfa.parts import Part
from ftcfa.statistics.estimate import Estimate
from ftcfa.statistics.proportions import proportion
from ftcfa.statistics.sequential_test import LARGEST_BETA, SequentialTest, Verdict
from ftcfa.study.path_metrics import PathMetrics
from ftcfa.study.progress import Interrupted, Progress

CHUNK = 256
"""Number of paths that are run between two looks."""
WORST = 5
"""Number of the worst paths that are listed."""
REASONS = {
    "late_peak_error": "error",
    "late_peak_tool_error": "tool error",
    "peak_torque": "torque",
    "peak_torque_rate": "torque rate",
}
"""Name of each limited metric in the reasons of `WorstPath`."""


def check_confidence(subject: str, value: float) -> None:
    """Raise ParameterError unless a confidence is one that the sequential test can reach."""
    probability(subject, value)
    if 1 - value > LARGEST_BETA:
        raise ParameterError(subject, f"{value:g}", "2/3 or more")


@dataclass(frozen=True, eq=False)
class Specification(Part):
    """Limits that a run must keep, and the share of runs that must keep them.

    Attributes:
        error: Largest overall tracking error |q - q_d| after ``within`` [rad or m]; infinite for no
            limit, if there is one of the tool.
        within: Time by which errors must be within their limits [s].
        effort: Largest |u|, one number or one for each joint [N m or N]; None for no limit.
        torque_rate: Largest change of u from sample to sample over the period, one number or one
            for each joint [N m/s or N/s]; None for no limit.
        share: Share of all runs that must keep the limits.
        confidence: 1 - beta: yes and no are each wrong with probability beta at most.
        limits: Whether a run must also stay within the URDF's limits of position and velocity.
        budget: Largest number of paths to run.
        tool_error: Largest distance of the tool from its desired place after ``within`` [m]; None
            for no limit.
    """

    error: Annotated[float, Check(positive_or_infinite, "rad or m")]
    within: Annotated[float, Check(positive, "s")]
    effort: Annotated[npt.ArrayLike | None, Check(positive_numbers, "N m or N")] = None
    torque_rate: Annotated[npt.ArrayLike | None, Check(positive_numbers, "N m/s or N/s")] = None
    share: Annotated[float, Check(probability)] = 0.95
    confidence: Annotated[float, Check(check_confidence)] = 0.95
    limits: Annotated[bool, Check(flag)] = False
    budget: Annotated[int, Check(counting)] = 10_000
    tool_error: Annotated[float | None, Check(positive, "m")] = None

    def check(self, loop: ClosedLoop, duration: float) -> None:
        """Raise ParameterError or ShapeError unless the specification suits runs of a loop."""
        if not self.within < duration:
            got, expected = f"{self.within:g} s", f"less than the duration of {duration:g} s"
            raise ParameterError("Specification within", got, expected, field="within")
        if self.tool_error is not None and not isinstance(loop.arm, Arm):
            subject, got = "Specification tool_error", f"a {type(loop.arm).__name__} without frames"
            raise ParameterError(subject, got, "an arm from load_arm", field="tool_error")
        if self.error == np.inf and self.tool_error is None:
            raise ParameterError(
                "Specification error", "inf", "a limit, or tool_error", field="error"
            )
        self.limits_of(loop.arm.n)

    @property
    def errors(self) -> str:
        """The largest errors in words."""
        tool = "" if self.tool_error is None else f"{1e3 * self.tool_error:g} mm at the tool"
        own = "" if self.error == np.inf else f"{self.error:g}"
        return " and ".join(filter(None, (own, tool)))

    def limits_of(self, n: int) -> dict[str, Array]:
        """Limits of metrics by name, for n joints, each of shape (1,) or (n,)."""
        limits = {"late_peak_error": np.array([self.error])}
        if self.tool_error is not None:
            limits["late_peak_tool_error"] = np.array([self.tool_error])
        for metric, name in (("peak_torque", "effort"), ("peak_torque_rate", "torque_rate")):
            limit = getattr(self, name)
            if limit is not None:
                limits[metric] = vector(f"Specification {name}", limit, n, field=name)
        return limits


@dataclass(frozen=True)
class WorstPath:
    """A path that broke the specification."""

    path: int
    """Number of the path, for `simulate`."""
    reason: str
    """The limits that it broke, or when it diverged."""
    excess: float
    """Largest value of a metric over its limit; inf if the path diverged."""


@dataclass(frozen=True, eq=False)
class Verification:
    """Answer of `verify` with its evidence.

    Attributes:
        answer: ``"yes"``, ``"no"`` or ``"undecided"``.
        verdict: Verdict of the sequential test: number of paths that kept the specification,
            number of paths judged, and bounds of the share, each of which holds with the required
            confidence whenever the test stops.
        fixed: Share among all paths that were run, with Clopper and Pearson's interval. It holds
            for a number of paths fixed beforehand, and so for the budget before anything is run;
            given that the answer is "undecided", it misses the share in about half of the cases.
        broke_limits: Number of the judged paths that kept the specification and yet were beyond a
            limit of the URDF, of position or velocity, at some time; zero where that is forbidden.
        worst: The paths that exceeded their limits most, the worst first.
        seed: Seed of the paths.
        specification: The specification.
    """

    answer: Literal["yes", "no", "undecided"]
    verdict: Verdict
    fixed: Estimate
    broke_limits: int
    worst: tuple[WorstPath, ...]
    seed: int
    specification: Specification

    def __str__(self) -> str:
        required, verdict = self.specification, self.verdict
        lines = [
            f"{self.answer}: {verdict.successes} of {verdict.trials} paths settle below "
            f"{required.errors} within {required.within:g} s and keep the limits; the share is "
            f"between {verdict.low:.4g} and {verdict.high:.4g} (each bound with confidence "
            f"{required.confidence:g}), {required.share:g} is required"
        ]
        if self.broke_limits:
            lines.append(f"{self.broke_limits} of these paths broke a limit of the URDF")
        lines += [f"path {one.path} of seed {self.seed}: {one.reason}" for one in self.worst]
        return "\n".join(lines)


def verify(
    loop: ClosedLoop,
    specification: Specification,
    duration: float,
    *,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Verification:
    """Test whether at least a share of all runs keeps a specification.

    Args:
        loop: The closed loop.
        specification: Limits of a run and the required share.
        duration: Simulated time, longer than ``within`` [s].
        seed: Seed of the random streams.
        threads: Number of threads; by default all that this process may use.
        progress: Called with the number of paths that are done and the budget.

    Raises:
        ParameterError, ShapeError: If an argument is out of range, or a limit has another number
            of joints.
        Interrupted: At Ctrl-C. Its ``partial`` is the Verification of the paths that are done,
            whose bounds hold, or None if no path is.
    """
    natural("seed", seed)
    samples = samples_of(loop, duration)
    specification.check(loop, duration)
    warn_of_doubts(loop, duration)
    limits = specification.limits_of(loop.arm.n)
    metrics = PathMetrics(specification.error, specification.within, bounds_of(loop.arm))
    observed = replace(loop, observer=metrics)
    excess, diverged_at = np.zeros((len(limits), 0)), np.zeros(0)
    broken_at = np.zeros(0)
    verification: Verification | None = None
    try:
        for start in range(0, specification.budget, CHUNK):
            paths = np.arange(start, min(start + CHUNK, specification.budget), dtype=np.uint64)
            run = run_paths(observed, samples, samples, seed, paths, ["u"], {}, threads)
            results = metrics.results(run.paths.observed, loop.period)
            broken_at = np.concatenate([broken_at, results["limit_broken_at"]])
            excess = np.concatenate([excess, _excess(results, limits)], axis=1)
            diverged_at = np.concatenate([diverged_at, run.paths.diverged_at])
            worst = _worst(excess, diverged_at, list(limits))
            verification = _verification(excess, broken_at, worst, seed, specification)
            if progress is not None:
                progress(excess.shape[1], specification.budget)
            if verification.verdict.finished:
                break
    except KeyboardInterrupt:
        raise Interrupted("verify", verification) from None
    return cast(Verification, verification)


def _verification(
    excess: Array,
    broken_at: Array,
    worst: tuple[WorstPath, ...],
    seed: int,
    specification: Specification,
) -> Verification:
    """The verification by the paths that are done."""
    broken = np.isfinite(broken_at)
    kept = np.all(excess <= 1.0, axis=0) & ~(broken & specification.limits)
    beta = 1 - specification.confidence
    verdict = SequentialTest(specification.share, beta, specification.budget).judge(kept)
    fixed = proportion(int(kept.sum()), kept.size, specification.confidence)
    good = int(np.sum((kept & broken)[: verdict.trials]))
    return Verification(verdict.answer, verdict, fixed, good, worst, seed, specification)


def _excess(metrics: Mapping[str, Array], limits: Mapping[str, Array]) -> Array:
    """Metrics over their limits, the worst joint's, shape (limits, paths); inf where diverged."""
    rows = [
        np.max(metrics[name].reshape(-1, len(limit)) / limit, axis=1)
        for name, limit in limits.items()
    ]
    return np.nan_to_num(np.array(rows), nan=np.inf, posinf=np.inf)


def _worst(excess: Array, diverged_at: Array, names: Sequence[str]) -> tuple[WorstPath, ...]:
    """The paths that exceeded a limit most, the worst first."""
    largest = np.max(excess, axis=0)
    order = np.argsort(-largest, kind="stable")[:WORST]
    reasons = {k: _reason(excess[:, k], diverged_at[k], names) for k in order if largest[k] > 1.0}
    return tuple(WorstPath(int(k), why, float(largest[k])) for k, why in reasons.items())


def _reason(excess: Array, diverged_at: float, names: Sequence[str]) -> str:
    if np.isfinite(diverged_at):
        return f"diverges at {diverged_at:.4g} s"
    broken = [
        f"{REASONS[name]} {value:.3g} times its limit"
        for name, value in zip(names, excess, strict=True)
        if value > 1.0
    ]
    return ", ".join(broken)
