"""A sequential test of a share: it may stop after any path, as soon as the evidence suffices.

The evidence against "the share is at most p0" is

    E = integral over p > p0 of p^S (1-p)^F dw(p) / (p0^S (1-p0)^F),

the likelihood ratio of S successes and F failures, averaged over the shares above p0 with
Jeffreys' weight w. If the share is p0 or less, E is a nonnegative supermartingale that starts at
one, so the probability that it ever reaches 1/beta is at most beta (Ville's inequality), however
often one looks and whenever one stops (Wald, Sequential tests of statistical hypotheses, Ann.
Math. Stat. 16, 1945, weight functions; Robbins, Statistical methods related to the law of the
iterated logarithm, Ann. Math. Stat. 41, 1970).

The evidence against "the share is at least p0" is the same with failures and
successes exchanged. It does not depend on a schedule of looks or a budget, so an undecided test
can be continued.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from scipy import special
from scipy.optimize import brentq

from ftcfa.arrays import Array
from ftcfa.checks import Check, counting, probability
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.parts import Part

LARGEST_BETA = 1 / 3
"""Largest beta allowed; up to 1/e the refuted shares form an interval, so the bounds are exact."""
LEAST, MOST = np.finfo(float).tiny, np.nextafter(1.0, 0.0)
"""Smallest and largest number of the open interval (0, 1)."""
ROUNDING = 1e-6
"""Rounding of a logarithm of evidence."""
BLOCK = 1000
"""Number of looks whose evidence is computed at once."""

Counts = npt.NDArray[np.integer]


@dataclass(frozen=True)
class Verdict:
    """The answer of a sequential test.

    Attributes:
        answer: ``"yes"``, ``"no"`` or, so far, ``"undecided"``.
        successes: Number of successes up to the decision.
        trials: Number of paths up to the decision.
        low: Lower bound of the share; it holds at all looks together with confidence 1 - beta.
        high: Upper bound of the share; it holds likewise.
        finished: Whether no further path of the budget can change the answer.
    """

    answer: Literal["yes", "no", "undecided"]
    successes: int
    trials: int
    low: float
    high: float
    finished: bool


def check_beta(subject: str, beta: float) -> None:
    """Raise ParameterError unless a probability of error is one that the test can keep."""
    probability(subject, beta)
    if beta > LARGEST_BETA:
        raise ParameterError(subject, repr(beta), "at most 1/3")


@dataclass(frozen=True)
class SequentialTest(Part):
    """Test of whether at least a share of all paths succeeds.

    If the true share is at most ``share``, it says yes with probability beta at most; if it is at
    least ``share``, it says no with probability beta at most. For a share of 0.95 and beta = 0.05,
    it says yes after 74 paths if none fails (the test of a fixed number of paths needs 59), and
    after 136 paths in the mean if the true share is 0.99, 450 if it is 0.975.

    Attributes:
        share: Required share p0.
        beta: Largest probability of each error.
        budget: Largest number of paths.

    Raises:
        ParameterError: If the share is not between 0 and 1, beta not between 0 and 1/3, or the
            budget not a positive integer.
    """

    share: Annotated[float, Check(probability)]
    beta: Annotated[float, Check(check_beta)]
    budget: Annotated[int, Check(counting)]

    def judge(self, outcomes: npt.ArrayLike) -> Verdict:
        """The verdict at the first path that decides, or after all.

        Paths after the decision do not count, so the verdict does not depend on how many paths
        were run at once.

        Args:
            outcomes: Whether each path succeeded, in the order of the paths, shape (paths,).

        Raises:
            ShapeError: If there is more than one axis.
        """
        succeeded = np.asarray(outcomes, dtype=bool)
        if succeeded.ndim != 1:
            got = f"shape {succeeded.shape}"
            raise ShapeError("SequentialTest outcomes", got, "shape (paths,)")
        succeeded = succeeded[: self.budget]
        S = np.concatenate([[0], np.cumsum(succeeded)])
        F = np.arange(len(S)) - S
        k = self._first_decision(S, F)
        answer: Literal["yes", "no", "undecided"] = "undecided"
        if self._says_yes(S[k], F[k]):
            answer = "yes"
        elif self._says_no(S[k], F[k]):
            answer = "no"
        low, high = share_bounds(int(S[k]), k, self.beta)
        finished = answer != "undecided" or not self._open(int(S[k]), k)
        return Verdict(answer, int(S[k]), k, low, high, finished)

    def _first_decision(self, S: Counts, F: Counts) -> int:
        """Number of paths at the first decision, or of all.

        The mean of likelihood ratios is at most the largest one, which rules most looks out.
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
        """Whether the rest of the budget can decide, if all of it succeeds or all of it fails."""
        rest, F = self.budget - trials, trials - S
        return bool(self._says_yes(S + rest, F) or self._says_no(S, F + rest))


def log_evidence(S: npt.ArrayLike, F: npt.ArrayLike, p0: npt.ArrayLike) -> Array:
    """Logarithm of the evidence of S successes and F failures against a share of p0 or less.

    The closed form, with w the part of Beta(1/2, 1/2) above p0, is

        E = B(S+1/2, F+1/2) I(S+1/2, F+1/2) / (B(1/2, 1/2) I(1/2, 1/2) p0^S (1-p0)^F),

    where I(a, b) is the probability of Beta(a, b) above p0.
    """
    a, b = np.asarray(S) + 0.5, np.asarray(F) + 0.5
    with np.errstate(divide="ignore"):  # evidence of zero
        above = np.log(special.betaincc(a, b, p0)) - np.log(special.betaincc(0.5, 0.5, p0))
    likelihood = special.xlogy(S, p0) + special.xlog1py(F, -np.asarray(p0))
    return special.betaln(a, b) - special.betaln(0.5, 0.5) + above - likelihood


def share_bounds(successes: int, trials: int, beta: float) -> tuple[float, float]:
    """Bounds of a share, each of which holds at all looks together with confidence 1 - beta.

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
