"""Metrics of the torque: its size, its changes, its limits and the energy it costs."""

from typing import Any

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.study.metrics.metric import Metric, Sample, Totals


def _beyond_limit_of_joint(sample: Sample) -> Traceable:
    """1.0 where the controller requests more than the limit of a joint, else 0.0, shape (n,)."""
    excess = np.abs(sample.signals["u_command"]) - np.abs(sample.signals["u_wanted"])
    return np.where(excess > 0.0, 1.0, 0.0)


def _beyond_limit(sample: Sample) -> Traceable:
    """The same of any joint."""
    any_joint: Any = np.max(_beyond_limit_of_joint(sample))
    return any_joint


def _share(count: Array, totals: Totals) -> Array:
    """Share of the samples."""
    return count / totals.samples


def _power(sample: Sample) -> Traceable:
    """Sum of |u v| over the joints, shape (1,) [W]."""
    return np.reshape(np.abs(sample.signals["u"]) @ np.abs(sample.signals["v"]), (1,))


def _rms_rate(total: Array, totals: Totals) -> Array:
    """Rms rate of a sum of squared changes from sample to sample."""
    return np.asarray(np.sqrt(total / np.maximum(totals.samples - 1.0, 1.0)) / totals.period)


SATURATED = Metric(
    label="saturated share",
    unit="1",
    meaning="share of samples at which the controller requests more than the limit of some joint",
    step=lambda count, sample: count + _beyond_limit(sample),
    result=_share,
)
JOINT_SATURATED = Metric(
    label="saturated share of a joint",
    unit="1",
    meaning="share of samples at which the controller requests more than the limit of the joint",
    step=lambda count, sample: count + _beyond_limit_of_joint(sample),
    result=_share,
    per_joint=True,
)
RMS_TORQUE = Metric(
    label="rms torque",
    unit="N m",
    meaning="rms of the torque",
    step=lambda total, sample: total + sample.signals["u"] ** 2,
    result=lambda total, totals: np.sqrt(total / totals.samples),
    per_joint=True,
)
PEAK_TORQUE = Metric(
    label="peak torque",
    unit="N m",
    meaning="largest torque",
    step=lambda peak, sample: np.maximum(peak, np.abs(sample.signals["u"])),
    result=lambda peak, _: peak,
    per_joint=True,
)
RMS_TORQUE_RATE = Metric(
    label="rms torque rate",
    unit="N m/s",
    meaning="rms of the changes of the torque from sample to sample, over the period",
    step=lambda total, sample: total + sample.change**2,
    result=_rms_rate,
    per_joint=True,
)
PEAK_TORQUE_RATE = Metric(
    label="peak torque rate",
    unit="N m/s",
    meaning="largest change of the torque from sample to sample, over the period",
    step=lambda peak, sample: np.maximum(peak, sample.change),
    result=lambda peak, totals: peak / totals.period,
    per_joint=True,
)
RMS_WANTED_RATE = Metric(
    label="rms wanted rate",
    unit="N m/s",
    meaning="rms of the changes of the command within the limits, over the period",
    step=lambda total, sample: total + sample.wanted_change**2,
    result=_rms_rate,
    per_joint=True,
)
RATE_LIMITED = Metric(
    label="rate-limited share",
    unit="1",
    meaning="share of samples at which the driver limits the rate of the torque",
    step=lambda count, sample: count + sample.signals.get("rate_limited", 0.0 * sample.error),
    result=_share,
    per_joint=True,
)
OSCILLATION = Metric(
    label="rms torque above 20 Hz",
    unit="N m",
    meaning="rms of the torque behind a first-order high-pass of 20 Hz",
    step=lambda total, sample: total + sample.fast_torque**2,
    result=lambda total, totals: np.sqrt(total / totals.samples),
    per_joint=True,
)
ENERGY = Metric(
    label="energy",
    unit="J",
    meaning="time integral of |u v|, summed over the joints",
    step=lambda total, sample: total + _power(sample),
    result=lambda total, totals: total * totals.period,
)
