"""A metric of a path: one counter that every sample updates, and the value it has at the end."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.control.protocol import Signals

Condition: TypeAlias = npt.NDArray[np.bool_]
"""Truth values or, while a loop is traced, CasADi symbols."""


class Sample(NamedTuple):
    """One sample of a path, as metrics see it."""

    signals: Signals
    """Signals of the sample, as `ClosedLoop.step` gives them: q, q_d, v, u, u_command, ..."""
    number: Traceable
    """Number of the sample, from 1, shape (1,)."""
    error: Traceable
    """Tracking error q - q_d, shape (n,) [rad or m]."""
    first_error: Traceable
    """Tracking error at the first sample, shape (n,) [rad or m]."""
    squared_error: Traceable
    """Squared overall tracking error |q - q_d|^2, shape (1,) [rad^2 or m^2]."""
    change: Traceable
    """Size of the change of u since the sample before, 0 at the first, shape (n,) [N m or N]."""
    wanted_change: Traceable
    """Size of the change of the command within the limits, shape (n,) [N m or N]."""
    fast_torque: Traceable
    """u behind a high-pass, 0 at the first sample, shape (n,) [N m or N]."""
    inside: Condition
    """Whether the overall tracking error is within the tolerance, shape (1,)."""
    settled: Traceable
    """Number of samples since the last one outside the tolerance, shape (1,)."""
    late: Condition
    """Whether the sample counts as late, shape (1,)."""


class Totals(NamedTuple):
    """Numbers of samples of many paths at their ends, each of shape (paths, 1)."""

    samples: Array
    """Number of samples; NaN where the path diverged."""
    settled: Array
    """Number of samples since the last one outside the tolerance."""
    late: Array
    """Number of late samples."""
    period: float
    """Sampling period [s]."""


@dataclass(frozen=True)
class Metric:
    """A number for each path, or for each joint of each path.

    The counter of a path has the shape (1,), that of its joints the shape (n,).

    Attributes:
        label: Name in tables.
        unit: Unit for revolute joints; prismatic joints have m for rad and N for N m.
        meaning: What the metric is, in one phrase.
        step: (counter, sample) -> counter after the sample. It is traced with the loop: NumPy
            expressions without branches on values.
        result: (counter, totals) -> metric, both of shape (paths, 1) or (paths, n).
        per_joint: Whether every joint has its own counter.
        start: Counter before the first sample.
    """

    label: str
    unit: str
    meaning: str
    step: Callable[[Traceable, Sample], Traceable]
    result: Callable[[Array, Totals], Array]
    per_joint: bool = False
    start: float = 0.0
