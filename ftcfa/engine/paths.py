"""The result of an engine: signals, times of divergence and observations of many paths."""

from typing import Any, NamedTuple, Self

import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.protocol import Signals
from ftcfa.engine.compiler.flatten import leaves, like, split


class Paths(NamedTuple):
    """Paths that an engine has run."""

    signals: Signals
    """Signals over paths and kept samples, shape (paths, kept, ...); NaN from divergence on."""
    diverged_at: Array
    """Times of divergence, shape (paths,) [s]; NaN for a path that did not diverge."""
    observed: Any
    """States of the observer at the end, with a leading dimension for the path; NaN for a path that
    diverged."""

    @classmethod
    def of(cls, signals: Signals, diverged_at: Array, observed: Array, observer: Any) -> Self:
        """Paths from the observer's states as rows, shape (paths, entries), and one as template."""
        rows = np.where(np.isnan(diverged_at)[:, None], observed, np.nan)
        arrays = split(rows, map(np.shape, leaves(observer)))
        return cls(signals, diverged_at, like(observer, iter(arrays)))
