"""The load of a moving base on the joints, and what an accelerometer on it makes of that load.

For the nominal arm at home. With the linear and angular acceleration a and omega' of the base, the
small tilt U (U'' = omega') and the gravity g, the base feels the specific force f - g with
f = a - g x U, and its load is -M_qb (f, omega').
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.hardware.accelerometer import Accelerometer
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.vibration.inputs.noise_input import AXES
from ftcfa.vibration.realisation import realise


class BaseLoad(NamedTuple):
    """Loads of each joint over time, shape (samples, n) [N m or N]."""

    true: Array
    """What the motion of the base does."""
    shown: Array
    """The same of the motion within the sensor's range: without noise, lag or delay."""
    beyond: float
    """Share of the samples at which a reading is beyond the sensor's range."""


def base_load(loop: ClosedLoop, duration: float) -> BaseLoad:
    """Loads of a realised motion of a loop's base, for the nominal arm at home.

    Args:
        loop: A loop with an accelerometer, whose base is moved by BaseAcceleration or BaseMotion.
        duration: Length of the motion [s].
    """
    nominal: Any = getattr(loop.controller, "nominal", loop.arm)
    vibration: Any = loop.vibration
    source, step = vibration.input, loop.step_length
    linear, angular = source.axes_of_motion
    channels = len(linear) + len(angular)
    motion = vibration.level * realise(vibration.excitation, channels, duration, step)
    gravity = np.asarray(nominal.gravity)
    turning = _placed(angular, motion[:, len(linear) :])
    tilt = np.cross(gravity, _integral(turning, step, 2))
    felt = _placed(linear, motion[:, : len(linear)]) - tilt
    coupling = np.asarray(nominal.base_coupling(nominal.home))  # (n, 6)
    sensor: Any = loop.interface.accelerometer
    shown, beyond = _within(felt - gravity, sensor.range)
    shown, seen = shown + gravity, np.zeros_like(turning)
    if sensor.gyroscope is not None:
        omega, too_fast = _within(_integral(turning, step, 1), sensor.gyroscope.range)
        seen = turning if not too_fast.any() else np.gradient(omega, step, axis=0)
        beyond = beyond | too_fast
    loads = _load(coupling, felt, turning), _load(coupling, shown, seen)
    return BaseLoad(*loads, float(np.mean(beyond)))


def noise_load(loop: ClosedLoop, f: Array) -> Array:
    """One-sided density of the load of the sensor's noise, shape (F, n) [N^2 m^2/Hz].

    The gyroscope's is that of its derivative. Beyond half the rate of the readings there is none.
    """
    nominal: Any = getattr(loop.controller, "nominal", loop.arm)
    sensor: Any = loop.interface.accelerometer
    coupling = np.asarray(nominal.base_coupling(nominal.home)) ** 2  # (n, 6)
    density = np.zeros((len(f), len(coupling))) + sensor.noise_density**2 * coupling[:, :3].sum(1)
    if sensor.gyroscope is not None:
        slope = sensor.gyroscope.noise_density * 2.0 * np.pi * f
        density = density + slope[:, None] ** 2 * coupling[:, 3:].sum(1)
    half_rate = 0.5 / loop.period if sensor.rate is None else 0.5 * sensor.rate
    return np.asarray(np.where(f[:, None] <= half_rate, density, 0.0))


def bias_load(loop: ClosedLoop) -> Array:
    """Load of the accelerometer's bias, shape (n,) [N m or N]."""
    nominal: Any = getattr(loop.controller, "nominal", loop.arm)
    sensor: Accelerometer = loop.interface.accelerometer
    bias = np.broadcast_to(np.asarray(sensor.bias, dtype=float), 3)
    return np.asarray(nominal.base_coupling(nominal.home)[:, :3] @ bias)


def _placed(axes: Any, motion: Array) -> Array:
    """Channels as columns of three axes, shape (samples, 3)."""
    columns = np.zeros((len(motion), 3))
    columns[:, [AXES.index(axis) for axis in axes]] = motion
    return columns


def _load(coupling: Array, linear: Array, angular: Array) -> Array:
    return np.asarray(-(linear @ coupling[:, :3].T + angular @ coupling[:, 3:].T))


def _within(values: Array, most: float) -> tuple[Array, npt.NDArray[np.bool_]]:
    """What a sensor shows of three axes, and at which samples one is beyond its range."""
    return np.clip(values, -most, most), np.any(np.abs(values) > most, axis=1)


def _integral(values: Array, step: float, times: int) -> Array:
    """The stationary integral of a periodic motion, taken some times, shape (samples, 3)."""
    s = 2j * np.pi * np.fft.rfftfreq(len(values), step)
    spectrum = np.fft.rfft(values, axis=0)
    spectrum[1:] /= s[1:, None] ** times
    spectrum[0] = 0.0
    return np.asarray(np.fft.irfft(spectrum, len(values), axis=0))
