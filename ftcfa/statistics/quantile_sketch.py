"""Quantiles over any number of paths in fixed memory: a histogram with bins of relative width.

Bins have equal relative width, as in DDSketch (Masson, Rim, Lee: DDSketch: a fast and
fully-mergeable quantile sketch with relative-error guarantees, VLDB 2019): an octave is cut into
128 equal parts, so that a value differs from the number that stands for its bin by less than one
part in 256. A bin is the leading 16 bits of the single-precision number (sign, exponent, seven
bits of mantissa). No logarithm is rounded, so every machine takes the same bin, and counts do not
depend on how paths are cut into chunks.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ShapeError
from ftcfa.statistics.estimate import CONFIDENCE, Estimate
from ftcfa.statistics.quantiles import Ranks, quantile_ranks

OCTAVE = 30
"""Binary exponent of the largest magnitude with a bin: from 2^-30 (9e-10) to 2^30 (1e9)."""
PARTS = 128
"""Number of bins in an octave: seven bits of mantissa."""
RELATIVE_ACCURACY = 1 / 256
"""Accuracy of a quantile, relative to its value; below 2^-30 it is absolute."""
SIZED = 2 * OCTAVE * PARTS
"""Number of bins of each sign."""
BINS = 2 * SIZED + 4
"""Number of bins: below -2^30, negative, about zero, positive, above 2^30, missing."""
ZERO, ABOVE, MISSING = SIZED + 1, BINS - 2, BINS - 1

SINGLE_BIAS, SINGLE_INFINITY, CODES = 127, 0x7F80, 1 << 16
"""Exponent bias, code of infinity and number of codes of the leading 16 bits of a float32."""


def _bin_of_code() -> npt.NDArray[np.intp]:
    code = np.arange(CODES)
    size = code & (CODES // 2 - 1)
    step = np.clip(size - (SINGLE_BIAS - OCTAVE) * PARTS + 1, 0, SIZED + 1)
    bins = ZERO + np.where(code >= CODES // 2, -step, step)
    return np.where(size >= SINGLE_INFINITY, MISSING, bins)


def _edges() -> tuple[Array, Array]:
    """Lower and upper edge of each bin, and of one more after the last."""
    octave, part = np.divmod(np.arange(SIZED + 1), PARTS)
    sizes = np.ldexp(1 + part / PARTS, octave - OCTAVE)
    inner = np.concatenate([-sizes[::-1], sizes])
    return (
        np.concatenate([[-np.inf], inner, [np.inf, np.inf]]),
        np.concatenate([inner, [np.inf, np.inf, np.inf]]),
    )


def _middles() -> Array:
    """Number that stands for each bin: at the same relative distance from both edges."""
    low, high = LOW[1:ABOVE], HIGH[1:ABOVE]
    inner = 2 * low * high / np.where(low + high == 0, 1.0, low + high)
    inner[ZERO - 1] = 0.0
    return np.concatenate([[-np.inf], inner, [np.inf, np.inf, np.nan]])


BIN_OF_CODE = _bin_of_code()
LOW, HIGH = _edges()
MIDDLE = _middles()


@dataclass(frozen=True, eq=False)
class QuantileSketch:
    """Quantiles of a quantity over paths, entry by entry.

    A path without a finite value (it diverged) counts as larger than every other: the upper
    quantiles become infinite when enough paths diverge.

    Attributes:
        counts: Number of paths in each bin, shape (..., BINS), int32; 60 KiB an entry.
    """

    counts: npt.NDArray[np.int32]

    @classmethod
    def empty(cls, shape: tuple[int, ...]) -> "QuantileSketch":
        """A sketch of no paths whose entries have a shape, such as (time, quantity)."""
        return cls(np.zeros((*shape, BINS), dtype=np.int32))

    @classmethod
    def of(cls, values: npt.ArrayLike) -> "QuantileSketch":
        """A sketch of values of shape (paths, ...)."""
        sketch = cls.empty(np.shape(values)[1:])
        sketch.add(values)
        return sketch

    @property
    def paths(self) -> npt.NDArray[np.int64]:
        """Number of paths, the missing included, shape (...)."""
        return np.sum(self.counts, axis=-1, dtype=np.int64)

    def add(self, values: npt.ArrayLike) -> None:
        """Count more paths, in place.

        Args:
            values: Values, shape (paths, ...); one that is not finite in single precision is
                missing.

        Raises:
            ShapeError: If the entries are not those of the sketch.
        """
        shape = self.counts.shape[:-1]
        if np.ndim(values) == 0 or np.shape(values)[1:] != shape:
            expected = f"(paths, {', '.join(map(str, shape))})"
            raise ShapeError("QuantileSketch values", f"shape {np.shape(values)}", expected)
        with np.errstate(over="ignore"):
            single = np.asarray(values).astype(np.float32)
        bins = np.take(BIN_OF_CODE, single.view(np.uint32) >> 16)
        bins += (np.arange(self.counts.size // BINS) * BINS).reshape(shape)
        np.add.at(self.counts.reshape(-1), bins.reshape(-1), np.int32(1))

    def quantile(self, p: npt.ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
        """Quantiles with distribution-free intervals at each entry.

        An interval ends at the outer edges of its bins, so that it covers at least as often as one
        of exact ranks. It holds for one entry, not for all at once.

        Args:
            p: Probabilities, shape (k,) or a scalar.
            confidence: Confidence of each interval.

        Returns:
            Quantile (accurate to `RELATIVE_ACCURACY`; NaN without paths), lower and upper end,
            shape (k, ...) or (...).

        Raises:
            ParameterError: If a probability is not between 0 and 1.
        """
        levels = np.asarray(p, dtype=float)
        entries = self.counts.shape[:-1]
        columns = levels.reshape(levels.shape + (1,) * len(entries))
        middle, low, high = quantile_ranks(columns, self.paths, confidence)
        bins = self._bins(np.stack([middle, low, high]).reshape(3, levels.size, -1))
        numbers = zip((MIDDLE, LOW, HIGH), bins, strict=True)
        return Estimate(*(table[b].reshape(levels.shape + entries) for table, b in numbers))

    def _bins(self, ranks: Ranks) -> Ranks:
        """Bin that holds each rank, BINS beyond the last, shape (..., entries) as the ranks."""
        bins = np.empty_like(ranks)
        for entry, counts in enumerate(self.counts.reshape(-1, BINS)):
            filled = np.cumsum(counts, dtype=np.int64)
            bins[..., entry] = np.searchsorted(filled, ranks[..., entry])
        return bins
