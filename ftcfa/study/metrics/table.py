"""All metrics of a path: a new one is a file beside this one and a line here."""

from ftcfa.study.metrics.errors import (
    LATE_PEAK_ERROR,
    LATE_RMS_ERROR,
    OVERSHOOT,
    PEAK_ERROR,
    RMS_ERROR,
    SETTLING_TIME,
)
from ftcfa.study.metrics.metric import Metric
from ftcfa.study.metrics.torques import (
    ENERGY,
    PEAK_TORQUE,
    PEAK_TORQUE_RATE,
    RMS_TORQUE,
    RMS_TORQUE_RATE,
    SATURATED,
)

METRICS: dict[str, Metric] = {
    "settling_time": SETTLING_TIME,
    "rms_error": RMS_ERROR,
    "peak_error": PEAK_ERROR,
    "late_rms_error": LATE_RMS_ERROR,
    "late_peak_error": LATE_PEAK_ERROR,
    "overshoot": OVERSHOOT,
    "saturated": SATURATED,
    "rms_torque": RMS_TORQUE,
    "peak_torque": PEAK_TORQUE,
    "rms_torque_rate": RMS_TORQUE_RATE,
    "peak_torque_rate": PEAK_TORQUE_RATE,
    "energy": ENERGY,
}
"""Metrics by the name of their Dataset variable, in the order of tables."""
