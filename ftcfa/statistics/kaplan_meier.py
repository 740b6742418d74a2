"""Distribution of the settling time from paths of which some have not settled (Kaplan-Meier)."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ftcfa.arrays import Array
from ftcfa.checks import probability
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.estimate import CONFIDENCE, Estimate
from ftcfa.statistics.proportions import proportion

ROUNDING = 1e-9
"""Rounding of products of shares."""


@dataclass(frozen=True, eq=False)
class SettlingDistribution:
    """Distribution of the settling time: the share of paths that have settled, over time.

    Attributes:
        time: Rising times at which a path settled or was last observed, from 0 on, shape (k,) [s].
        share: Probability of having settled by each time, with a confidence band that holds at each
            single time, shape (k,).
        settled: Number of paths that settled.
        censored: Number of paths that had not settled when their run ended.
        diverged: Number of paths that diverged.
    """

    time: Array
    share: Estimate
    settled: int
    censored: int
    diverged: int

    def quantile(self, p: float) -> Estimate:
        """Time by which a share p of all paths has settled [s].

        The interval holds the times at which p lies in the band (Brookmeyer and Crowley, A
        confidence interval for the median survival time, Biometrics 38, 1982). Infinite where the
        runs end first, or too many paths diverge. Where all runs end together, intervals of 95 %
        cover the quantiles of 5, 50 and 95 % in 95 % of the cases or more
        (``scripts/coverage_table.py``).

        Raises:
            ParameterError: If p is not between 0 and 1.
        """
        probability("quantile of the settling time", p)
        value, low, high = self.share
        return Estimate(*(self._first_time(share, p) for share in (value, high, low)))

    def _first_time(self, share: Array, p: float) -> Array:
        reached = np.flatnonzero(share >= p - ROUNDING)
        return self.time[reached[0]] if reached.size else np.array(np.inf)


def settling_distribution(
    settled_at: npt.ArrayLike,
    end: npt.ArrayLike,
    diverged: npt.ArrayLike = False,
    confidence: float = CONFIDENCE,
) -> SettlingDistribution:
    """Kaplan-Meier estimate of the distribution of settling times.

    A path that has not settled at the end of its run might settle later: it is censored there. A
    path that diverged never settles: it counts as not settled to the end, so the share need not
    reach one.

    Where all runs end together, nobody is censored before, the number of paths that have settled
    is binomial at each time, and the band is Clopper and Pearson's, which is exact. Otherwise it is
    Greenwood's on the scale log(-log(1 - share)), which keeps it within 0 and 1 (Kalbfleisch and
    Prentice, The Statistical Analysis of Failure Time Data, 2nd ed. 2002). That band has no value
    before the first path has settled and after the last one; after the last one it is continued.

    Args:
        settled_at: Settling time of each path, NaN where it did not settle, shape (paths,) [s].
        end: End of each run, shape (paths,), or a scalar where all end together [s].
        diverged: Whether each path diverged, shape (paths,) or a scalar.
        confidence: Confidence of the band.

    Raises:
        ParameterError: If the confidence is not between 0 and 1, an end is not finite, or a path
            settled after the end of its run.
        ShapeError: If there are no paths, or the numbers of paths differ.
    """
    probability("confidence of the settling times", confidence)
    times = np.asarray(settled_at, dtype=float)
    if times.ndim != 1 or times.size == 0:
        raise ShapeError("settled_at", f"shape {times.shape}", "shape (paths,), one or more")
    ends = _per_path("end", end, times)
    has_diverged = _per_path("diverged", diverged, times).astype(bool)
    if not np.all(np.isfinite(ends)):
        raise ParameterError("end", repr(end), "finite times [s]")
    settled = np.isfinite(times) & ~has_diverged
    late = np.flatnonzero(settled & (times > ends))
    if late.size:
        got = f"path {late[0]} at {times[late[0]]:g} s, its run ended at {ends[late[0]]:g} s"
        raise ParameterError("settled_at", got, "times within the run")
    last = np.where(settled, times, np.where(has_diverged, np.max(ends), ends))
    cdf = stats.ecdf(stats.CensoredData.right_censored(last, ~settled)).cdf
    time, value = np.append(0.0, cdf.quantiles), np.append(0.0, cdf.probabilities)
    if time[1] == 0.0:
        time, value = time[1:], value[1:]
    if np.ndim(end) == 0:
        counts = np.searchsorted(np.sort(times[settled]), time, side="right")
        share = proportion(counts, times.size, confidence)
    else:
        share = Estimate(value, *_greenwood(cdf, confidence, len(value)))
    return SettlingDistribution(
        time,
        share,
        settled=int(np.sum(settled)),
        censored=int(np.sum(~settled & ~has_diverged)),
        diverged=int(np.sum(has_diverged)),
    )


def _greenwood(cdf: Any, confidence: float, size: int) -> tuple[Array, Array]:
    """Greenwood's band of SciPy's distribution, continued to the times before and after."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # undefined where the share is 0 or 1
        band = cdf.confidence_interval(confidence, method="log-log")
    low = np.maximum.accumulate(np.nan_to_num(band.low.probabilities, nan=0.0))
    high = np.nan_to_num(band.high.probabilities, nan=1.0)
    high = np.minimum.accumulate(high[::-1])[::-1]
    before = size - len(low)
    return np.append(np.zeros(before), low), np.append(high[:before], high)


def _per_path(name: str, values: npt.ArrayLike, times: Array) -> Array:
    array = np.asarray(values)
    if array.shape not in ((), times.shape):
        raise ShapeError(name, f"shape {array.shape}", f"a scalar or shape {times.shape}")
    return np.broadcast_to(array, times.shape)
