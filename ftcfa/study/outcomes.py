"""What became of a path: kept, lost track, broke a limit, or diverged; when, and at which joint.

A joint has lost track while its error is beyond a bound, and breaks a limit while its position or
velocity is beyond the URDF's. Both are judged at the end of the run: the outcome is the first of
these events that does not end before. A path that diverges is named so whatever came before.
"""

from typing import NamedTuple

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.control.protocol import Signals
from ftcfa.loop.bounds import Bounds

OUTCOMES = ("kept", "lost track", "broke a limit", "diverged")
"""What becomes of a path; in results the number of its place here."""
WORDS = tuple(outcome.replace(" ", "_") for outcome in OUTCOMES)
"""The same as one word each, for attributes and files."""
KEPT, LOST, BROKE, DIVERGED = range(len(OUTCOMES))
VARIABLES = {
    "outcome": ("", "what became of the path"),
    "outcome_time": ("s", "time from which it is so, NaN for a path that is kept"),
    "outcome_joint": ("", "number of the joint, -1 if there is none"),
    "saturated_before": ("1", "share of samples before, at which a torque was beyond its limit"),
    "largest_rho": ("rad/s", "largest |rho| of a joint, NaN for a law without rho"),
    "without_torque": ("", "number of samples at which the law asked for no finite torque"),
    "limit_broken_at": ("s", "first time at which a joint was beyond a limit, NaN if never"),
}
"""Variables of each path, with unit and meaning."""


class Events(NamedTuple):
    """State of the observer: what is needed to tell the outcome at the end."""

    tracked: Traceable
    """Number of the last sample at which the joint kept its track, shape (n,)."""
    tracked_saturated: Traceable
    """Number of saturated samples until then, shape (n,)."""
    within: Traceable
    """Number of the last sample at which the joint was within its limits, shape (n,)."""
    within_saturated: Traceable
    """Number of saturated samples until then, shape (n,)."""
    saturated: Traceable
    """Number of samples at which a torque was beyond its limit, shape (1,)."""
    kept_limits: Traceable
    """Number of samples before the first one beyond a limit, shape (1,)."""
    largest_rho: Traceable
    """Largest |rho|, shape (1,) [rad/s]."""
    without_torque: Traceable
    """Number of samples at which the law asked for a torque that is not finite, shape (1,)."""


def no_events(n: int) -> Events:
    """The state before the first sample, for n joints."""
    joints, one = np.zeros(n), np.zeros(1)
    return Events(joints, joints, joints, joints, one, one, one, one)


def step(bounds: Bounds, state: Events, signals: Signals, number: Traceable) -> Events:
    """The state after a sample; ``number`` is that of the sample, from 1, shape (1,)."""
    q, v = signals["q"], signals["v"]
    excess = np.max(np.abs(signals["u_command"]) - np.abs(signals["u_wanted"]))
    saturated = state.saturated + np.where(excess > 0.0, 1.0, 0.0)
    near = np.abs(q - signals["q_d"]) <= bounds.error
    inside = np.logical_and(q >= bounds.lower, q <= bounds.upper)
    inside = np.logical_and(inside, np.abs(v) <= bounds.velocity)
    all_before = state.kept_limits > number - 1.5
    all_inside = np.logical_and(np.min(np.where(inside, 1.0, 0.0)) > 0.5, all_before)
    finite = np.max(np.abs(signals["u_command"])) < np.inf
    rho = np.max(np.abs(signals.get("rho", 0.0 * q)))
    return Events(
        tracked=np.where(near, number, state.tracked),
        tracked_saturated=np.where(near, saturated, state.tracked_saturated),
        within=np.where(inside, number, state.within),
        within_saturated=np.where(inside, saturated, state.within_saturated),
        saturated=saturated,
        kept_limits=np.where(all_inside, number, state.kept_limits),
        largest_rho=np.maximum(state.largest_rho, rho),
        without_torque=state.without_torque + np.where(finite, 0.0, 1.0),
    )


def results(events: Events, samples: Array, period: float) -> dict[str, Array]:
    """The `VARIABLES` of many paths, each of shape (paths,).

    Args:
        events: States at their ends, each entry of shape (paths, n) or (paths, 1).
        samples: Numbers of their samples, shape (paths, 1); NaN where the path diverged.
        period: Sampling period [s].
    """
    ends = np.concatenate([events.tracked, events.within], axis=1)  # (paths, 2 n)
    saturated = np.concatenate([events.tracked_saturated, events.within_saturated], axis=1)
    begins = np.where(ends < samples, ends, np.inf)
    first = np.argmin(begins, axis=1)
    rows, n = np.arange(len(ends)), events.tracked.shape[1]
    start = begins[rows, first]
    diverged, failed = np.isnan(samples[:, 0]), np.isfinite(start)
    outcome = np.where(failed, np.where(first < n, LOST, BROKE), KEPT)
    with np.errstate(invalid="ignore", divide="ignore"):
        before = saturated[rows, first] / start
    broken = events.kept_limits < samples
    return {
        "outcome": np.where(diverged, DIVERGED, outcome).astype(np.int8),
        "outcome_time": np.where(failed, start * period, np.nan),
        "outcome_joint": np.where(failed, first % n, -1).astype(np.int16),
        "saturated_before": np.where(failed, before, np.nan),
        "largest_rho": events.largest_rho[:, 0],
        "without_torque": events.without_torque[:, 0].astype(np.int32),
        "limit_broken_at": np.where(broken, events.kept_limits * period, np.nan)[:, 0],
    }
