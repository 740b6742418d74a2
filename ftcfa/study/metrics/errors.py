"""Metrics of the tracking error: when it settles, and how large it is then and late in the run."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.study.metrics.metric import Metric, Sample

Squared: TypeAlias = Callable[[Sample], Traceable]
"""Square of an error at a sample."""


def _squared_tool_error(sample: Sample) -> Traceable:
    """Squared error of the tool, shape (1,) [m^2]; NaN for a robot without frames."""
    return sample.signals.get("tool_error", np.nan * sample.squared_error) ** 2


def _squared_error(sample: Sample) -> Traceable:
    """Squared overall tracking error, shape (1,)."""
    return sample.squared_error


def _squared_joint_errors(sample: Sample) -> Traceable:
    """Squared tracking error of each joint, shape (n,)."""
    return sample.error**2


def _late_rms(
    label: str, unit: str, meaning: str, squared: Squared, per_joint: bool = False
) -> Metric:
    """The rms of an error over the late samples."""
    return Metric(
        label,
        unit,
        meaning,
        step=lambda total, sample: total + np.where(sample.late, squared(sample), 0.0),
        result=lambda total, totals: np.sqrt(total / totals.late),
        per_joint=per_joint,
    )


def _late_peak(
    label: str, unit: str, meaning: str, squared: Squared, per_joint: bool = False
) -> Metric:
    """The largest error among the late samples."""
    return Metric(
        label,
        unit,
        meaning,
        step=lambda peak, sample: np.maximum(peak, np.where(sample.late, squared(sample), 0.0)),
        result=lambda peak, totals: np.where(totals.late > 0, np.sqrt(peak), np.nan),
        per_joint=per_joint,
    )


SETTLING_TIME = Metric(
    label="settling time",
    unit="s",
    meaning="time after which the error stays within the tolerance, inf if never",
    step=lambda _, sample: sample.number - sample.settled,
    result=lambda outside, totals: np.where(
        totals.settled > 0,
        outside * totals.period,
        np.where(np.isnan(totals.samples), np.nan, np.inf),
    ),
)
RMS_ERROR = Metric(
    label="rms error, settled",
    unit="rad",
    meaning="rms of the overall tracking error after settling",
    step=lambda total, sample: np.where(sample.inside, total + sample.squared_error, 0.0),
    result=lambda total, totals: np.where(
        totals.settled > 0, np.sqrt(total / totals.settled), np.nan
    ),
)
PEAK_ERROR = Metric(
    label="peak error, settled",
    unit="rad",
    meaning="largest overall tracking error after settling",
    step=lambda peak, sample: np.where(sample.inside, np.maximum(peak, sample.squared_error), 0.0),
    result=lambda peak, totals: np.where(totals.settled > 0, np.sqrt(peak), np.nan),
)
LATE_RMS_ERROR = _late_rms(
    "rms error, late", "rad", "rms of the overall tracking error over the late samples",
    _squared_error,
)  # fmt: skip
LATE_PEAK_ERROR = _late_peak(
    "peak error, late", "rad", "largest overall tracking error of the late samples", _squared_error
)
LATE_RMS_TOOL_ERROR = _late_rms(
    "rms tool error, late", "m",
    "rms of the tool's distance from its desired place over the late samples", _squared_tool_error,
)  # fmt: skip
LATE_PEAK_TOOL_ERROR = _late_peak(
    "peak tool error, late", "m",
    "largest distance of the tool from its desired place among the late samples",
    _squared_tool_error,
)  # fmt: skip
LATE_RMS_JOINT_ERROR = _late_rms(
    "rms joint error, late", "rad", "rms of the tracking error of the joint over the late samples",
    _squared_joint_errors, per_joint=True,
)  # fmt: skip
LATE_PEAK_JOINT_ERROR = _late_peak(
    "peak joint error, late", "rad",
    "largest tracking error of the joint among the late samples", _squared_joint_errors,
    per_joint=True,
)  # fmt: skip
OVERSHOOT = Metric(
    label="overshoot",
    unit="rad",
    meaning="largest error on the other side of the reference than at the start",
    step=lambda peak, sample: np.maximum(peak, -np.sign(sample.first_error) * sample.error),
    result=lambda peak, _: peak,
    per_joint=True,
)
