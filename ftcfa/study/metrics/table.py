"""All metrics of a path: a new one is a file beside this one and a line here."""

from pkgutil import resolve_name

from ftcfa.study.metrics.metric import Metric

NAMES = {
    "settling_time": "ftcfa.study.metrics.errors:SETTLING_TIME",
    "rms_error": "ftcfa.study.metrics.errors:RMS_ERROR",
    "peak_error": "ftcfa.study.metrics.errors:PEAK_ERROR",
    "late_rms_error": "ftcfa.study.metrics.errors:LATE_RMS_ERROR",
    "late_peak_error": "ftcfa.study.metrics.errors:LATE_PEAK_ERROR",
    "late_rms_tool_error": "ftcfa.study.metrics.errors:LATE_RMS_TOOL_ERROR",
    "late_peak_tool_error": "ftcfa.study.metrics.errors:LATE_PEAK_TOOL_ERROR",
    "late_rms_joint_error": "ftcfa.study.metrics.errors:LATE_RMS_JOINT_ERROR",
    "late_peak_joint_error": "ftcfa.study.metrics.errors:LATE_PEAK_JOINT_ERROR",
    "overshoot": "ftcfa.study.metrics.errors:OVERSHOOT",
    "saturated": "ftcfa.study.metrics.torques:SATURATED",
    "joint_saturated": "ftcfa.study.metrics.torques:JOINT_SATURATED",
    "rms_torque": "ftcfa.study.metrics.torques:RMS_TORQUE",
    "peak_torque": "ftcfa.study.metrics.torques:PEAK_TORQUE",
    "rms_torque_rate": "ftcfa.study.metrics.torques:RMS_TORQUE_RATE",
    "peak_torque_rate": "ftcfa.study.metrics.torques:PEAK_TORQUE_RATE",
    "rms_wanted_rate": "ftcfa.study.metrics.torques:RMS_WANTED_RATE",
    "rate_limited": "ftcfa.study.metrics.torques:RATE_LIMITED",
    "oscillation": "ftcfa.study.metrics.torques:OSCILLATION",
    "energy": "ftcfa.study.metrics.torques:ENERGY",
}
"""Name of the Dataset variable of each metric, and the metric as ``module:name``."""
METRICS: dict[str, Metric] = {name: resolve_name(metric) for name, metric in NAMES.items()}
"""Metrics by the name of their Dataset variable, in the order of tables."""
