"""Quantiles over any number of paths in fixed memory: a histogram of whole numbers.

Bins have equal relative width, as in DDSketch (Masson, Rim, Lee: DDSketch: a fast and
fully-mergeable quantile sketch with relative-error guarantees, VLDB 2019): an octave is cut into
128 equal parts, so that a value and the number read for it differ by less than one part in 256.
A bin is the leading 16 bits of the single-precision number (sign, exponent, seven bits of
mantissa): no logarithm, so the same bin everywhere, and counts that do not depend on how paths are
cut into chunks.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import ShapeError
from ftcfa.statistics.estimate import CONFIDENCE, Estimate
from ftcfa.statistics.quantiles import Ranks, quantile_ranks

OCTAVE = 30
"""Magnitudes from 2^-30 (9e-10) to 2^30 (1e9) have bins."""
PARTS = 128
"""Bins an octave: those of seven bits of mantissa."""
RELATIVE_ACCURACY = 1 / 256
"""Of a quantile, 0.4 % of its value; absolute below 2^-30."""
SIZED = 2 * OCTAVE * PARTS
"""Bins of each sign."""
BINS = 2 * SIZED + 4
"""Below -2^30, negative, about zero, positive, above 2^30, missing."""
ZERO, ABOVE, MISSING = SIZED + 1, BINS - 2, BINS - 1

SINGLE_BIAS, SINGLE_INFINITY, CODES = 127, 0x7F80, 1 << 16
"""Of the leading 16 bits of a single-precision number: bias of the exponent, code of infinity."""


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
    """The number read for each bin: equally far, relatively, from both edges."""
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

    A path without a finite value (it diverged) is counted as larger than every other, so it is
    never averaged away: the upper quantiles become infinite when enough diverge. `survivors`
    leaves such paths out. Quantities with a sign are better given by their size: a path that
    diverged has none.

    Attributes:
        counts: Paths in each bin, shape (..., BINS), int32; 60 KiB an entry.
    """

    counts: npt.NDArray[np.int32]

    @classmethod
    def empty(cls, shape: tuple[int, ...]) -> "QuantileSketch":
        """A sketch of no paths for entries of a shape."""
        return cls(np.zeros((*shape, BINS), dtype=np.int32))

    @classmethod
    def of(cls, values: npt.ArrayLike) -> "QuantileSketch":
        """A sketch of a chunk of paths, shape (paths, ...)."""
        sketch = cls.empty(np.shape(values)[1:])
        sketch.add(values)
        return sketch

    @property
    def paths(self) -> npt.NDArray[np.int64]:
        """Number of paths, with the missing, shape (...)."""
        return np.sum(self.counts, axis=-1, dtype=np.int64)

    @property
    def missing(self) -> npt.NDArray[np.int32]:
        """Paths without a finite value, shape (...)."""
        return self.counts[..., MISSING]

    def add(self, values: npt.ArrayLike) -> None:
        """Count a chunk of paths, in place.

        Args:
            values: Shape (paths, ...); what is not finite in single precision is missing.

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

    def merge(self, other: "QuantileSketch") -> "QuantileSketch":
        """The sketch of both sets of paths.

        Raises:
            ShapeError: If the entries are not the same.
        """
        if self.counts.shape != other.counts.shape:
            got, expected = other.counts.shape[:-1], self.counts.shape[:-1]
            raise ShapeError("QuantileSketch", f"shape {got}", f"{expected}")
        return QuantileSketch(self.counts + other.counts)

    def survivors(self) -> "QuantileSketch":
        """The same without the paths that have no value."""
        counts = self.counts.copy()
        counts[..., MISSING] = 0
        return QuantileSketch(counts)

    def quantile(self, p: npt.ArrayLike, confidence: float = CONFIDENCE) -> Estimate:
        """Quantiles with distribution-free intervals at each entry.

        The interval is read outwards, from the outer edges of its bins, so that its coverage is
        that of exact ranks; it is of one entry, not of all at once.

        Args:
            p: Probabilities, shape (k,) or a scalar.
            confidence: Of each interval.

        Returns:
            Quantile (to `RELATIVE_ACCURACY`; NaN without paths), lower and upper end, shape
            (k, ...) or (...).

        Raises:
            ParameterError: If a probability is not between 0 and 1.
        """
        levels = np.asarray(p, dtype=float)
        entries = self.counts.shape[:-1]
        columns = levels.reshape(levels.shape + (1,) * len(entries))
        middle, low, high = quantile_ranks(columns, self.paths, confidence)
        bins = self._bins(np.stack([middle, low, high]).reshape(3, levels.size, -1))
        readings = zip((MIDDLE, LOW, HIGH), bins, strict=True)
        return Estimate(*(table[b].reshape(levels.shape + entries) for table, b in readings))

    def _bins(self, ranks: Ranks) -> Ranks:
        """Bin that holds each rank, or BINS, of ranks (..., entries)."""
        bins = np.empty_like(ranks)
        for entry, counts in enumerate(self.counts.reshape(-1, BINS)):
            filled = np.cumsum(counts, dtype=np.int64)
            bins[..., entry] = np.searchsorted(filled, ranks[..., entry])
        return bins
