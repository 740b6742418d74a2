"""Means over paths with their confidence intervals, merged exactly over chunks of paths."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftcfa.arrays import Array
from ftcfa.checks import probability
from ftcfa.errors import ShapeError
from ftcfa.portable import cube_root, rounded
from ftcfa.statistics.estimate import CONFIDENCE, Estimate

Counts = npt.NDArray[np.integer]

FEW = 10
"""Number of paths that, where they carry a mean, are too few for its interval of 95 %."""
SYMMETRIC = 1e-8
"""Skewness over root n below which a sample counts as symmetric: the correction is then smaller
than rounding."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Count, mean and central power sums of a quantity over paths, entry by entry.

        M_k = sum_i (x_i - average)^k

    A path that diverged has no finite value: it is counted as missing. Where a path is missing,
    every statistic is NaN; `without_missing` gives the statistics of the other paths.

    Attributes:
        count: Number of paths with a finite value, shape (...).
        missing: Number of paths without a finite value, shape (...).
        average: Mean of the finite values, 0 where there are none, shape (...).
        M2: Second central power sum, shape (...).
        M3: Third central power sum, shape (...).
    """

    count: Counts
    missing: Counts
    average: Array
    M2: Array
    M3: Array

    @classmethod
    def of(cls, values: npt.ArrayLike) -> "Moments":
        """Moments of a chunk of paths.

        For the mean square of x, give x^2: its interval needs the skewness of x^2.

        Args:
            values: Values, shape (paths, ...); one that is not finite is missing.

        Raises:
            ShapeError: If there is no axis of paths.
        """
        x = np.asarray(values, dtype=float)
        if x.ndim == 0:
            raise ShapeError("Moments values", "a single number", "shape (paths, ...)")
        finite = np.isfinite(x)
        whole = bool(finite.all())  # sums without a mask take two thirds of the time
        count = np.full(x.shape[1:], len(x)) if whole else np.sum(finite, axis=0)
        average = np.sum(x, axis=0, where=whole or finite) / np.maximum(count, 1)
        d = x - average if whole else np.where(finite, x - average, 0.0)
        d2 = d * d
        return cls(count, len(x) - count, average, np.sum(d2, axis=0), np.sum(d2 * d, axis=0))

    def merge(self, other: "Moments") -> "Moments":
        """Moments of both sets of paths together.

        With d = average_b - average_a, n = n_a + n_b:

            average = average_a + d n_b/n
            M2 = M2_a + M2_b + d^2 n_a n_b/n
            M3 = M3_a + M3_b + d^3 n_a n_b (n_a - n_b)/n^2 + 3 d (n_a M2_b - n_b M2_a)/n

        (Pebay, Formulas for robust, one-pass parallel computation of covariances and
        arbitrary-order statistical moments, Sandia report SAND2008-6212, 2008.)

        Raises:
            ShapeError: If the entries are not the same.
        """
        if self.average.shape != other.average.shape:
            raise ShapeError("Moments", f"shape {other.average.shape}", f"{self.average.shape}")
        count = self.count + other.count
        n = np.maximum(count, 1)
        a, b = self.count / n, other.count / n
        d = np.where((a > 0) & (b > 0), other.average - self.average, 0.0)
        average = np.where(a > 0, self.average, other.average) + d * b
        M2 = self.M2 + other.M2 + d**2 * a * b * n
        M3 = (
            self.M3
            + other.M3
            + d * d * d * a * b * (a - b) * n
            + 3 * d * (a * other.M2 - b * self.M2)
        )
        return Moments(count, self.missing + other.missing, average, M2, M3)

    def without_missing(self) -> "Moments":
        """Moments of the paths that have a finite value."""
        return replace(self, missing=np.zeros_like(self.missing))

    @property
    def mean(self) -> Array:
        """Mean, NaN where a path is missing, shape (...)."""
        return np.where((self.missing == 0) & (self.count > 0), self.average, np.nan)

    @property
    def variance(self) -> Array:
        """Unbiased variance, divisor n - 1; NaN for fewer than two paths, shape (...)."""
        known = (self.missing == 0) & (self.count > 1)
        return np.where(known, self.M2 / np.maximum(self.count - 1, 1), np.nan)

    def student(self, confidence: float = CONFIDENCE) -> Estimate:
        """Mean with Student's interval, average -+ t s/sqrt(n).

        Exact for Gaussian values. Of few skewed values it covers too rarely: in 89 % of the cases
        instead of 95 for the mean square of 20 Gaussian values; see `skewness_corrected`.

        Raises:
            ParameterError: If the confidence is not between 0 and 1.
        """
        t, error = self._t(confidence), self._standard_error
        return Estimate(self.mean, self.mean - t * error, self.mean + t * error)

    def skewness_corrected(self, confidence: float = CONFIDENCE) -> Estimate:
        """Mean with an interval for skewed values, such as squares and settling times.

            average - s/sqrt(n) g(+-t),   g(t) = (3/a) [(1 + a (t - a/6))^(1/3) - 1],

        a = skewness/sqrt(n): the monotone cubic transform that removes the skewness of Student's
        ratio (Hall, On the removal of skewness by transformation, J. R. Stat. Soc. B 54, 1992).
        Assumes independent paths and a finite third moment. With a confidence of
        95 %, it covers the mean of squares of Gaussian values in 94 % (20 paths), 95 % (100) and
        95 % (500) of the cases, that of lognormal values in 92, 93 and 95 %; where 1 % of the paths
        fail, in 62, 64 and 97 %: see `carried_by` (``scripts/coverage_table.py``). The lower end of
        a mean square can be below zero when paths are few.

        Raises:
            ParameterError: If the confidence is not between 0 and 1.
        """
        t, error = self._t(confidence), self._standard_error
        a = self._skewness / np.sqrt(np.maximum(self.count, 1))
        return Estimate(
            self.mean, self.mean - error * _unskewed(t, a), self.mean - error * _unskewed(-t, a)
        )

    def carried_by(self, few: int = FEW) -> npt.NDArray[np.bool_]:
        """Where so few paths carry the mean that its interval may miss it, shape (...).

            |skewness|/sqrt(n) > 1/sqrt(few),

        because k paths of n that lie far out, all to one side, give 1/sqrt(k). Far more paths may
        lie out than the sample shows: with 1 % of failing paths and n = 100, a third of the samples
        have none, and no interval of the mean can know of them.
        """
        return np.abs(self._skewness) * np.sqrt(few / np.maximum(self.count, 1)) > 1.0

    @property
    def _standard_error(self) -> Array:
        return np.sqrt(self.variance / np.maximum(self.count, 1))

    @property
    def _skewness(self) -> Array:
        spread = self.M2 / np.maximum(self.count, 1)
        scale = np.where(spread > 0, spread * np.sqrt(spread), 1.0)
        return np.where(spread > 0, self.M3 / np.maximum(self.count, 1) / scale, 0.0)

    def _t(self, confidence: float) -> Array:
        probability("Moments confidence", confidence)
        return rounded(stats.t.ppf(0.5 + confidence / 2, np.maximum(self.count - 1, 1)))


def paired_differences(first: npt.ArrayLike, second: npt.ArrayLike) -> Moments:
    """Moments of first - second, path by path: two loops under the same noise.

    Path i of both has the same random numbers, so that most of the noise cancels;
    ``.student()`` is the paired confidence interval of the mean difference. A pair with a path
    that diverged is missing.

    Args:
        first: Values of the first loop, shape (paths, ...).
        second: Values of the second loop, same shape.

    Raises:
        ShapeError: If the shapes differ.
    """
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if a.shape != b.shape:
        raise ShapeError("paired_differences", f"shapes {a.shape} and {b.shape}", "equal shapes")
    with np.errstate(invalid="ignore"):  # infinity - infinity
        return Moments.of(a - b)


def _unskewed(t: Array, a: Array) -> Array:
    """Hall's g(t), which tends to t as a vanishes."""
    symmetric = np.abs(a) < SYMMETRIC
    safe = np.where(symmetric, 1.0, a)
    return np.where(symmetric, t, (cube_root(1 + safe * (t - safe / 6)) - 1) * 3 / safe)
