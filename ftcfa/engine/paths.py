"""What an engine gives of many paths."""

from typing import Any, NamedTuple, Self

import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.protocol import Signals
from ftcfa.engine.compiler.flatten import leaves, like, size


class Paths(NamedTuple):
    """Paths that were run."""

    signals: Signals
    """Over paths and kept samples, each of shape (paths, kept, ...); NaN from divergence on."""
    died: Array
    """Times of divergence, shape (paths,) [s]; NaN where there was none."""
    observed: Any
    """The observer's states at the end, with a leading dimension for the path; NaN where it
    diverged."""

    @classmethod
    def of(cls, signals: Signals, died: Array, observed: Array, observer: Any) -> Self:
        """From the observer's states in rows, shape (paths, entries), and one as a template."""
        rows = np.where(np.isnan(died)[:, None], observed, np.nan)
        ends = np.cumsum([size(leaf) for leaf in leaves(observer)])
        parts = np.split(rows, ends[:-1], axis=1) if len(ends) else []
        shaped = [
            part.reshape(len(rows), *np.shape(leaf))
            for part, leaf in zip(parts, leaves(observer), strict=True)
        ]
        return cls(signals, died, like(observer, iter(shaped)))
