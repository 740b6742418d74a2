"""Chunks of an ensemble added up: the same bits in whatever order they come."""

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.statistics.moments import Moments
from ftcfa.statistics.quantile_sketch import QuantileSketch
from ftcfa.study.chunk import PATH_DIMENSIONS, moments_of, quantities, sums_of


class PairwiseMoments:
    """Moments of numbered chunks, merged in pairs of neighbours.

    A pair is merged when both of its chunks are there, then pairs of pairs. So the order in which
    chunks come changes no bit, and memory grows with the logarithm of their number only.
    """

    def __init__(self) -> None:
        self._parts: dict[tuple[int, int], Moments] = {}  # by first number and width

    def add(self, number: int, moments: Moments) -> None:
        """Add the moments of a chunk."""
        width = 1
        while (neighbour := (number ^ width, width)) in self._parts:
            other = self._parts.pop(neighbour)
            pair = (moments, other) if number < neighbour[0] else (other, moments)
            moments = pair[0].merge(pair[1])
            number, width = number & ~width, 2 * width
        self._parts[number, width] = moments

    @property
    def total(self) -> Moments:
        """Moments of all chunks together."""
        first, *rest = (self._parts[key] for key in sorted(self._parts))
        for part in rest:
            first = first.merge(part)
        return first


class Tally:
    """Sum of the chunks of an ensemble.

    Args:
        times: Number of recorded times.
        n: Number of joints.
    """

    def __init__(self, times: int, n: int) -> None:
        self.sketch = QuantileSketch.empty((times, quantities(n)))
        """Quantiles over time, entries (time, quantity)."""
        self._moments = PairwiseMoments()
        self._per_path: dict[int, dict[str, Array]] = {}
        self.paths = 0
        """Number of paths in the chunks."""

    def add(self, number: int, chunk: xr.Dataset) -> None:
        """Add a chunk."""
        counts = self.sketch.counts.reshape(-1)
        counts[chunk["filled"].values] += chunk["count"].values
        self._moments.add(number, moments_of(chunk["moments"].values))
        names = [name for name, rows in chunk.variables.items() if "path" in rows.dims]
        self._per_path[number] = {str(name): chunk[name].values.copy() for name in names}
        self.paths += chunk.sizes["path"]

    @property
    def moments(self) -> tuple[Moments, Moments]:
        """Moments of the quantities and of their squares, entries (time, quantity)."""
        sums = sums_of(self._moments.total)
        return moments_of(sums[:, 0]), moments_of(sums[:, 1])

    @property
    def per_path(self) -> xr.Dataset:
        """Variables of each path, by path number."""
        parts = [self._per_path[number] for number in sorted(self._per_path)]
        rows = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return xr.Dataset({name: (PATH_DIMENSIONS[: x.ndim], x) for name, x in rows.items()})
