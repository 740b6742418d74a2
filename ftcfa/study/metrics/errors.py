"""Metrics of the tracking error: when it settles, and how large it is then and late in the run."""

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.study.metrics.metric import Metric, Sample


def _squared_tool_error(sample: Sample) -> Traceable:
    """Squared error of the tool, shape (1,) [m^2]; NaN for a robot without frames."""
    return sample.signals.get("tool_error", np.nan * sample.squared_error) ** 2


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
LATE_RMS_ERROR = Metric(
    label="rms error, late",
    unit="rad",
    meaning="rms of the overall tracking error over the late samples",
    step=lambda total, sample: total + np.where(sample.late, sample.squared_error, 0.0),
    result=lambda total, totals: np.sqrt(total / totals.late),
)
LATE_PEAK_ERROR = Metric(
    label="peak error, late",
    unit="rad",
    meaning="largest overall tracking error of the late samples",
    step=lambda peak, sample: np.maximum(peak, np.where(sample.late, sample.squared_error, 0.0)),
    result=lambda peak, totals: np.where(totals.late > 0, np.sqrt(peak), np.nan),
)
LATE_RMS_TOOL_ERROR = Metric(
    label="rms tool error, late",
    unit="m",
    meaning="rms of the tool's distance from its desired place over the late samples",
    step=lambda total, sample: total + np.where(sample.late, _squared_tool_error(sample), 0.0),
    result=lambda total, totals: np.sqrt(total / totals.late),
)
LATE_PEAK_TOOL_ERROR = Metric(
    label="peak tool error, late",
    unit="m",
    meaning="largest distance of the tool from its desired place among the late samples",
    step=lambda peak, sample: np.maximum(
        peak, np.where(sample.late, _squared_tool_error(sample), 0.0)
    ),
    result=lambda peak, totals: np.where(totals.late > 0, np.sqrt(peak), np.nan),
)
LATE_RMS_JOINT_ERROR = Metric(
    label="rms joint error, late",
    unit="rad",
    meaning="rms of the tracking error of the joint over the late samples",
    step=lambda total, sample: total + np.where(sample.late, sample.error**2, 0.0),
    result=lambda total, totals: np.sqrt(total / totals.late),
    per_joint=True,
)
LATE_PEAK_JOINT_ERROR = Metric(
    label="peak joint error, late",
    unit="rad",
    meaning="largest tracking error of the joint among the late samples",
    step=lambda peak, sample: np.maximum(peak, np.where(sample.late, np.abs(sample.error), 0.0)),
    result=lambda peak, totals: np.where(totals.late > 0, peak, np.nan),
    per_joint=True,
)
OVERSHOOT = Metric(
    label="overshoot",
    unit="rad",
    meaning="largest error on the other side of the reference than at the start",
    step=lambda peak, sample: np.maximum(peak, -np.sign(sample.first_error) * sample.error),
    result=lambda peak, _: peak,
    per_joint=True,
)
