"""The observer that counts the metrics of a path while it runs."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, not_negative, positive_or_infinite
from ftcfa.control.protocol import Signals
from ftcfa.loop.bounds import NO_BOUNDS, Bounds
from ftcfa.parts import Part
from ftcfa.study import outcomes
from ftcfa.study.metrics.metric import Sample, Totals
from ftcfa.study.metrics.table import METRICS

FAST = 20.0
"""Corner of the high-pass for torques, above the bandwidth of every law's nominal loop [Hz]."""
ROUNDING = 1e-12
"""Rounding of a time over the period, relative."""


class Counts(NamedTuple):
    """State of `PathMetrics`; with a leading dimension for the path where there are many."""

    samples: Traceable
    """Number of samples, shape (1,)."""
    settled: Traceable
    """Number of samples since the last one outside the tolerance, shape (1,)."""
    first_error: Traceable
    """Tracking error at the first sample, shape (n,) [rad or m]."""
    torque: Traceable
    """Torque at the last sample, shape (n,) [N m or N]."""
    wanted: Traceable
    """Command within the limits at the last sample, shape (n,) [N m or N]."""
    fast_torque: Traceable
    """Torque behind a high-pass, shape (n,) [N m or N]."""
    metrics: tuple[Traceable, ...]
    """Counter of each metric, shape (1,) or (n,)."""
    events: outcomes.Events
    """What is needed to tell what became of the path."""


@dataclass(frozen=True, eq=False)
class PathMetrics(Part):
    """An `Observer` that counts the metrics of a path.

    Attributes:
        tolerance: Overall tracking error |q - q_d| within which a path counts as settled [rad or
            m].
        after: Samples from this time on are late [s].
        bounds: Bounds of the joints, which decide what became of the path.
    """

    tolerance: Annotated[float, Check(positive_or_infinite, "rad or m")]
    after: Annotated[float, Check(not_negative, "s")] = 0.0
    bounds: Bounds = NO_BOUNDS

    def init(self, n: int) -> Counts:
        """Counters before the first sample."""
        counters = tuple(np.full(n if m.per_joint else 1, m.start) for m in METRICS.values())
        events = outcomes.no_events(n)
        none, still = np.zeros(1), np.zeros(n)
        return Counts(none, none, still, still, still, still, counters, events)

    def step(self, state: Counts, signals: Signals, period: float) -> Counts:
        """Count one sample."""
        error, u, wanted = signals["q"] - signals["q_d"], signals["u"], signals["u_wanted"]
        change = np.where(state.samples > 0, u - state.torque, 0.0)
        fast = np.exp(-2.0 * np.pi * FAST * period) * (state.fast_torque + change)
        squared_error = np.reshape(error @ error, (1,))
        inside = squared_error <= self.tolerance**2
        sample = Sample(
            signals=signals,
            number=state.samples + 1.0,
            error=error,
            first_error=np.where(state.samples > 0, state.first_error, error),
            squared_error=squared_error,
            change=np.abs(change),
            wanted_change=np.where(state.samples > 0, np.abs(wanted - state.wanted), 0.0),
            fast_torque=fast,
            inside=inside,
            settled=np.where(inside, state.settled + 1.0, 0.0),
            late=state.samples * period >= self.after * (1 - ROUNDING),
        )
        counters = zip(METRICS.values(), state.metrics, strict=True)
        metrics = tuple(metric.step(counter, sample) for metric, counter in counters)
        events = outcomes.step(self.bounds, state.events, signals, sample.number)
        return Counts(
            sample.number, sample.settled, sample.first_error, u, wanted, fast, metrics, events
        )

    def results(self, counts: Counts, period: float) -> dict[str, Array]:
        """The metrics of many paths.

        Args:
            counts: Counts at their ends, each entry of shape (paths, 1) or (paths, n).
            period: Sampling period [s].

        Returns:
            Metrics by name, each of shape (paths,) or (paths, n); NaN where a path diverged. With
            them the variables of `ftcfa.study.outcomes`.
        """
        early = np.ceil(self.after / period * (1 - ROUNDING))
        late = np.maximum(counts.samples - early, 0.0)
        totals = Totals(counts.samples, counts.settled, late, period)
        results = {}
        with np.errstate(divide="ignore", invalid="ignore"):
            for (name, metric), counter in zip(METRICS.items(), counts.metrics, strict=True):
                values = metric.result(counter, totals)
                results[name] = values if metric.per_joint else values[:, 0]
        return results | outcomes.results(counts.events, counts.samples, period)
