"""A sequential test of a share: it may be looked at after every path and stops when it knows.

Against "the share is at most p0" stands the evidence

    E = integral over p > p0 of p^S (1-p)^F dw(p) / (p0^S (1-p0)^F),

the likelihood ratio of S successes and F failures, mixed over the shares above p0 with Jeffreys'
weight w. If the share is p0 or less, E is a nonnegative supermartingale that starts at one, so it
ever reaches 1/beta with probability beta at most (Ville's inequality), however often one looks and
whenever one stops (Wald, Sequential tests of statistical hypotheses, Ann. Math. Stat. 16, 1945,
weight functions; Robbins, Statistical methods related to the law of the iterated logarithm, Ann.
Math. Stat. 41, 1970). The other side is the same with failures for successes. No schedule of looks
and no budget enters, so an undecided test can be continued.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import special
from scipy.optimize import brentq

from ftcfa.arrays import Array
from ftcfa.checks import counting, probability
from ftcfa.errors import ParameterError, ShapeError

LARGEST_BETA = 1 / 3
"""Up to 1/e the shares that the evidence refutes are an interval, so that the bounds are exact."""
LEAST, MOST = np.finfo(float).tiny, np.nextafter(1.0, 0.0)
"""The open interval (0, 1) in floating point."""
ROUNDING = 1e-6
"""Of a logarithm of evidence."""
BLOCK = 1000
"""Looks whose evidence is computed at once."""

Counts = npt.NDArray[np.integer]


@dataclass(frozen=True)
class Verdict:
    """The answer of a sequential test.

    Attributes:
        answer: ``"yes"``, ``"no"`` or, so far, ``"undecided"``.
        successes: Paths that did, up to the decision.
        trials: Paths looked at up to the decision.
        low: Lower bound of the share; true at all looks together with confidence 1 - beta.
        high: Upper bound of the share, likewise.
        finished: Whether no further path of the budget can change the answer.
    """

    answer: Literal["yes", "no", "undecided"]
    successes: int
    trials: int
    low: float
    high: float
    finished: bool


@dataclass(frozen=True)
class SequentialTest:
    """Whether at least a share of all paths does something.

    It says yes wrongly, though the share is ``share`` or less, with probability beta at most; and
    no wrongly, though it is ``share`` or more, with probability beta at most. If no path ever
    fails it says yes after 74 paths for a share of 0.95 and beta = 0.05, where the fixed test
    needs 59; a share of 0.99 takes 136 paths in the mean, one of 0.975 takes 450.

    Attributes:
        share: p0, the share asked for.
        beta: Probability of error.
        budget: Largest number of paths.

    Raises:
        ParameterError: If the share is not between 0 and 1, beta not between 0 and 1/3, or the
            budget not a positive integer.
    """

    share: float
    beta: float
    budget: int

    def __post_init__(self) -> None:
        probability("SequentialTest share", self.share)
        probability("SequentialTest beta", self.beta)
        if self.beta > LARGEST_BETA:
            raise ParameterError("SequentialTest beta", repr(self.beta), "at most 1/3")
        counting("SequentialTest budget", self.budget)

    def judge(self, outcomes: npt.ArrayLike) -> Verdict:
        """The verdict at the first path that decides, or after all.

        What comes after the decision does not count, so the verdict does not depend on how many
        paths were run at once.

        Args:
            outcomes: Whether each path did it, in the order of the paths, shape (paths,).

        Raises:
            ShapeError: If there is more than one axis.
        """
        done = np.asarray(outcomes, dtype=bool)
        if done.ndim != 1:
            raise ShapeError("SequentialTest outcomes", f"shape {done.shape}", "shape (paths,)")
        done = done[: self.budget]
        S = np.concatenate([[0], np.cumsum(done)])
        F = np.arange(len(S)) - S
        k = self._first_decision(S, F)
        answer: Literal["yes", "no", "undecided"] = (
            "yes"
            if self._says_yes(S[k], F[k])
            else "no"
            if self._says_no(S[k], F[k])
            else "undecided"
        )
        low, high = share_bounds(int(S[k]), k, self.beta)
        finished = answer != "undecided" or not self._open(int(S[k]), k)
        return Verdict(answer, int(S[k]), k, low, high, finished)

    def _first_decision(self, S: Counts, F: Counts) -> int:
        """Number of paths at the first decision, or of all.

        A mean of likelihood ratios is not above the largest: most looks are settled by that.
        """
        observed = S / np.maximum(S + F, 1)
        largest = special.xlogy(S, observed / self.share)
        largest += special.xlogy(F, (1 - observed) / (1 - self.share))
        looks = np.flatnonzero(largest >= -np.log(self.beta) - ROUNDING)
        for block in np.array_split(looks, np.arange(BLOCK, len(looks), BLOCK)):
            decided = self._says_yes(S[block], F[block]) | self._says_no(S[block], F[block])
            if decided.any():
                return int(block[np.argmax(decided)])
        return len(S) - 1

    def _says_yes(self, S: npt.ArrayLike, F: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        return log_evidence(S, F, self.share) >= -np.log(self.beta)

    def _says_no(self, S: npt.ArrayLike, F: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        return log_evidence(F, S, 1 - self.share) >= -np.log(self.beta)

    def _open(self, S: int, trials: int) -> bool:
        """Whether the rest of the budget can decide: at best all succeed, or all fail."""
        rest, F = self.budget - trials, trials - S
        return bool(self._says_yes(S + rest, F) or self._says_no(S, F + rest))


def log_evidence(S: npt.ArrayLike, F: npt.ArrayLike, p0: npt.ArrayLike) -> Array:
    """Logarithm of the evidence of S successes and F failures against a share of p0 or less.

    In closed form, with w the part of Beta(1/2, 1/2) above p0:

        E = B(S+1/2, F+1/2) I(S+1/2, F+1/2) / (B(1/2, 1/2) I(1/2, 1/2) p0^S (1-p0)^F),

    I(a, b) the probability of Beta(a, b) above p0.
    """
    a, b = np.asarray(S) + 0.5, np.asarray(F) + 0.5
    with np.errstate(divide="ignore"):  # no evidence at all
        above = np.log(special.betaincc(a, b, p0)) - np.log(special.betaincc(0.5, 0.5, p0))
    likelihood = special.xlogy(S, p0) + special.xlog1py(F, -np.asarray(p0))
    return special.betaln(a, b) - special.betaln(0.5, 0.5) + above - likelihood


def share_bounds(successes: int, trials: int, beta: float) -> tuple[float, float]:
    """Bounds of a share that hold at all looks, each with confidence 1 - beta.

    The lower bound is the largest share that the evidence refutes, or 0.
    """
    failures = trials - successes
    return _lower(successes, failures, beta), 1 - _lower(failures, successes, beta)


def _lower(S: int, F: int, beta: float) -> float:
    def excess(p: float) -> float:
        return float(log_evidence(S, F, p)) + np.log(beta)

    if S == 0:
        return 0.0
    return float(brentq(excess, LEAST, min(S / (S + F), MOST), xtol=1e-12))
