"""All metrics by which loops are compared, each computed from the metrics of an ensemble."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from ftcfa.arrays import Array
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import KEPT


class ComparedMetric(NamedTuple):
    """A number for each path by which loops are compared."""

    unit: str
    """Unit for revolute joints."""
    meaning: str
    """What the number is, in one phrase."""
    values: Callable[[xr.Dataset, Array], Array]
    """(Dataset of an ensemble, effort limit of each joint) -> values, shape (paths,)."""
    column: str = ""
    """Heading of its column in tables; without one, it has none."""
    binary: bool = False
    """Whether it is 0 or 1 for each path, so that its mean is a share of paths."""

    @property
    def percent(self) -> bool:
        """Whether tables show it in per cent: it has no unit."""
        return self.unit == "1"


def _unchanged(name: str) -> Callable[[xr.Dataset, Array], Array]:
    """A metric of the ensemble as it is."""
    return lambda run, _: run[name].values


def _over_limit(name: str) -> Callable[[xr.Dataset, Array], Array]:
    """The rms over the joints of a metric over the effort limit."""
    return lambda run, limit: np.sqrt(np.mean((run[name].values / limit) ** 2, axis=1))


def _worst(name: str) -> Callable[[xr.Dataset, Array], Array]:
    """The largest of the joints."""
    return lambda run, _: run[name].values.max(axis=1)


def _settling_time(run: xr.Dataset, _: Array) -> Array:
    return np.minimum(run["settling_time"].values, run.attrs["duration"])


def _late_mean_square_error(run: xr.Dataset, _: Array) -> Array:
    return run["late_rms_error"].values ** 2


def _unsettled(run: xr.Dataset, _: Array) -> Array:
    return 1.0 - np.isfinite(run["settling_time"].values)


def _diverged(run: xr.Dataset, _: Array) -> Array:
    return 1.0 * np.isfinite(run["diverged_at"].values)


def _beyond_limits(run: xr.Dataset, _: Array) -> Array:
    return 1.0 * np.isfinite(run["limit_broken_at"].values)


def _failed(run: xr.Dataset, _: Array) -> Array:
    return 1.0 * (run["outcome"].values != KEPT)


COMPARED: dict[str, ComparedMetric] = {
    "settling_time": ComparedMetric(
        "s", "time to settle, the duration where that never happens", _settling_time, "settle"
    ),
    "late_rms_error": ComparedMetric(
        "rad", "rms of |q - q_d| late in the run", _unchanged("late_rms_error"), "rms"
    ),
    "late_peak_error": ComparedMetric(
        "rad", "largest |q - q_d| late in the run", _unchanged("late_peak_error"), "peak"
    ),
    "late_rms_tool_error": ComparedMetric(
        "m", METRICS["late_rms_tool_error"].meaning, _unchanged("late_rms_tool_error")
    ),
    "late_peak_tool_error": ComparedMetric(
        "m", METRICS["late_peak_tool_error"].meaning, _unchanged("late_peak_tool_error")
    ),
    "late_mean_square_error": ComparedMetric(
        "rad^2", "mean of |q - q_d|^2 late in the run", _late_mean_square_error
    ),
    "effort": ComparedMetric(
        "1", "rms torque over its limit, rms over the joints", _over_limit("rms_torque"), "effort"
    ),
    "torque_rate": ComparedMetric(
        "1/s",
        "rms torque rate over the torque limit, rms over the joints",
        _over_limit("rms_torque_rate"),
        "rate",
    ),
    "rms_torque_rate": ComparedMetric(
        "N m/s", "rms torque rate of the joint where it is largest", _worst("rms_torque_rate")
    ),
    "rate_limited": ComparedMetric(
        "1",
        "share of samples at which the driver limits the rate, of the joint where it is largest",
        _worst("rate_limited"),
        "limited",
    ),
    "oscillation": ComparedMetric(
        "N m", "rms torque above 20 Hz of the joint where it is largest", _worst("oscillation")
    ),
    "saturated": ComparedMetric(
        "1", METRICS["saturated"].meaning, _unchanged("saturated"), "satur."
    ),
    "unsettled": ComparedMetric(
        "1", "1 for a path that does not settle, or diverges", _unsettled, "unsettled", binary=True
    ),
    "failed": ComparedMetric(
        "1",
        "1 for a path that is not kept: it loses track, breaks a limit or diverges",
        _failed,
        "failed",
        binary=True,
    ),
    "beyond_limits": ComparedMetric(
        "1",
        "1 for a path that is beyond a limit of position or velocity at some time",
        _beyond_limits,
        binary=True,
    ),
    "diverged": ComparedMetric("1", "1 for a path that diverges", _diverged, binary=True),
    "energy": ComparedMetric("J", METRICS["energy"].meaning, _unchanged("energy")),
}
"""Metrics by which loops are compared, by name, in the order of tables."""
