"""What a path amounts to, counted as it runs: settling, errors, torques, saturation, energy."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.control.protocol import Signals
from ftcfa.parts import Parameters, number_fields

ROUNDING = 1e-12
"""Of a time over the period."""


class Counts(NamedTuple):
    """State of `PathMetrics`; of many paths with a leading dimension each."""

    samples: Array
    """Samples seen, shape (1,)."""
    outside: Array
    """Samples up to the last one at which the error exceeded the tolerance, shape (1,)."""
    square: Array
    """Sum of squared errors since then, shape (1,) [rad^2 or m^2]."""
    peak: Array
    """Largest squared error since then, shape (1,) [rad^2 or m^2]."""
    late_square: Array
    """Sum of squared errors over the late samples, shape (1,) [rad^2 or m^2]."""
    late_peak: Array
    """Largest squared error of them, shape (1,) [rad^2 or m^2]."""
    first: Array
    """Error at the first sample, shape (n,) [rad or m]."""
    overshoot: Array
    """Largest error of the other sign than the first, shape (n,) [rad or m]."""
    torque: Array
    """Torque at the last sample, shape (n,) [N m or N]."""
    peak_torque: Array
    """Largest |u|, shape (n,) [N m or N]."""
    square_torque: Array
    """Sum of u^2, shape (n,)."""
    peak_change: Array
    """Largest change of u from sample to sample, shape (n,) [N m or N]."""
    square_change: Array
    """Sum of squared changes, shape (n,)."""
    saturated: Array
    """Samples at which some joint asked for more than its limit, shape (1,)."""
    energy: Array
    """Sum of |u v| over joints and samples, shape (1,) [W]."""


@dataclass(frozen=True, eq=False)
class PathMetrics:
    """An `Observer` that counts what a path amounts to.

    Attributes:
        tolerance: Overall tracking error |q - q_d| within which a path counts as settled [rad or
            m].
        after: Samples from this time on are late [s].
    """

    tolerance: float
    after: float = 0.0

    varies: ClassVar[Parameters] = number_fields("tolerance", "after")

    def __post_init__(self) -> None:
        positive("tolerance", self.tolerance, "rad or m")

    def init(self, n: int) -> Counts:
        """Nothing seen."""
        one, joints = np.zeros(1), np.zeros(n)
        return Counts(*[one] * 6, *[joints] * 7, *[one] * 2)

    def step(self, state: Counts, signals: Signals, period: float) -> Counts:
        """Count one sample."""
        error, u, v = signals["q"] - signals["q_d"], signals["u"], signals["v"]
        square = np.reshape(error @ error, (1,))
        inside = square <= self.tolerance**2
        late = np.where(state.samples * period >= self.after * (1 - ROUNDING), square, 0.0)
        first = np.where(state.samples > 0, state.first, error)
        change = np.where(state.samples > 0, np.abs(u - state.torque), 0.0)
        demand = np.max(np.abs(signals["u_command"]) - np.abs(u))
        return Counts(
            samples=state.samples + 1.0,
            outside=np.where(inside, state.outside, state.samples + 1.0),
            square=np.where(inside, state.square + square, 0.0),
            peak=np.where(inside, np.maximum(state.peak, square), 0.0),
            late_square=state.late_square + late,
            late_peak=np.maximum(state.late_peak, late),
            first=first,
            overshoot=np.maximum(state.overshoot, -np.sign(first) * error),
            torque=u,
            peak_torque=np.maximum(state.peak_torque, np.abs(u)),
            square_torque=state.square_torque + u**2,
            peak_change=np.maximum(state.peak_change, change),
            square_change=state.square_change + change**2,
            saturated=state.saturated + np.where(demand > 0.0, 1.0, 0.0),
            energy=state.energy + np.reshape(np.abs(u) @ np.abs(v), (1,)),
        )

    def results(self, counts: Counts, period: float) -> dict[str, Array]:
        """The metrics of many paths.

        Args:
            counts: At their ends, each entry of shape (paths, 1) or (paths, n).
            period: Sampling period [s].

        Returns:
            By name, each of shape (paths,) or (paths, n), as `UNITS` describes them; NaN where a
            path diverged.
        """
        samples, outside = counts.samples[:, 0], counts.outside[:, 0]
        inside = samples - outside
        settled = inside > 0
        late = np.maximum(samples - np.ceil(self.after / period * (1 - ROUNDING)), 0.0)
        changes = np.maximum(counts.samples - 1.0, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            rms = np.sqrt(counts.square[:, 0] / inside)
            late_rms = np.sqrt(counts.late_square[:, 0] / late)
        never = np.where(np.isnan(samples), np.nan, np.inf)
        return {
            "settling_time": np.where(settled, outside * period, never),
            "rms_error": np.where(settled, rms, np.nan),
            "peak_error": np.where(settled, np.sqrt(counts.peak[:, 0]), np.nan),
            "late_rms_error": late_rms,
            "late_peak_error": np.where(late > 0, np.sqrt(counts.late_peak[:, 0]), np.nan),
            "overshoot": counts.overshoot,
            "saturated": counts.saturated[:, 0] / samples,
            "peak_torque": counts.peak_torque,
            "rms_torque": np.sqrt(counts.square_torque / counts.samples),
            "peak_torque_rate": counts.peak_change / period,
            "rms_torque_rate": np.sqrt(counts.square_change / changes) / period,
            "energy": counts.energy[:, 0] * period,
        }


UNITS = {
    "settling_time": ("s", "time after which the error stays within the tolerance, inf if never"),
    "rms_error": ("rad", "rms of the overall tracking error after settling"),
    "peak_error": ("rad", "largest overall tracking error after settling"),
    "late_rms_error": ("rad", "rms of the overall tracking error over the late samples"),
    "late_peak_error": ("rad", "largest overall tracking error of the late samples"),
    "overshoot": ("rad", "largest error on the other side of the reference than at the start"),
    "saturated": ("1", "share of samples at which some joint asked for more than its limit"),
    "peak_torque": ("N m", "largest torque"),
    "rms_torque": ("N m", "rms of the torque"),
    "peak_torque_rate": ("N m/s", "largest change of the torque from sample to sample, over h"),
    "rms_torque_rate": ("N m/s", "rms of the changes of the torque from sample to sample, over h"),
    "energy": ("J", "time integral of |u v|, summed over the joints"),
}
"""Units and meaning of the metrics of revolute joints; prismatic joints have m for rad."""
