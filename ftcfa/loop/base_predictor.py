"""A predictor of the base's motion from the filter of its spectrum."""

from typing import Any, cast

import numpy as np
from scipy.linalg import block_diag, expm, solve_discrete_are

from ftcfa.arrays import Array
from ftcfa.control.feed_forward import Predictor
from ftcfa.errors import ParameterError
from ftcfa.hardware.hardware import Hardware
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.vibration.excitations.shaped_noise import ShapedNoise
from ftcfa.vibration.inputs.noise_input import AXES, BaseAcceleration
from ftcfa.vibration.spectra.linear_filter import LinearFilter
from ftcfa.vibration.vibration import Vibration

ROUNDING = 1e-9
"""Relative rounding of a rate, and the least level."""
EXACT = 1e-6
"""Noise of a reading that is none, as a share of the variance: what keeps the equation solvable."""


def base_predictor(loop: ClosedLoop) -> Predictor:
    """The steady Kalman predictor of a base that shaped noise shakes.

    For each axis with the filter dx = A x dt + B dW, a = C x: the reading at a sample is C x plus
    the accelerometer's noise, and the prediction is C exp(A t) x over the time t from the middle of
    what a reading shows to the middle of the period in which its torque acts.

    It makes the mean-square error of the acceleration least, of all frequencies alike. That serves
    an arm where the spectrum is narrow, as that of a road or of a sea; where most of it lies above
    the frequencies that move an arm, as on the truck of MIL-STD-810G, the error that is left at low
    frequencies is larger than without a predictor. It knows the delay and the noise of the reading,
    but neither the bandwidth of the accelerometer nor that of the motors. `feed_forward_band` does
    not judge it: compare the loop with and without.

    Args:
        loop: A loop with an accelerometer, `BaseAcceleration` and `ShapedNoise`.

    Raises:
        ParameterError: If it has none of one of them, or not a reading at every sample.
    """
    hardware, vibration = cast(Hardware | None, loop.hardware), loop.vibration
    sensor: Any = None if hardware is None else hardware.accelerometer
    if hardware is None or sensor is None:
        raise ParameterError("predictor", "no accelerometer", "hardware with an Accelerometer")
    source, excitation = (getattr(vibration, name, None) for name in ("input", "excitation"))
    if not (isinstance(source, BaseAcceleration) and isinstance(excitation, ShapedNoise)):
        got = f"{type(source).__name__} and {type(excitation).__name__}"
        raise ParameterError("predictor", got, "BaseAcceleration and ShapedNoise")
    if sensor.rate is not None and sensor.rate * loop.period < 1.0 - ROUNDING:
        expected = f"a reading at every sample, {1.0 / loop.period:g} Hz"
        raise ParameterError("predictor", f"an accelerometer of {sensor.rate:g} Hz", expected)
    rate = 1.0 / loop.period if sensor.rate is None else sensor.rate
    ahead = sensor.delay + hardware.actuators.delay + (loop.period + loop.step_length) / 2.0
    level = max(cast(Vibration, vibration).level, ROUNDING)
    noise = (sensor.noise_density / level) ** 2 * rate / 2.0
    parts = [_predictor(one, loop.period, ahead, noise) for one in excitation.filters]
    A, K, C, P = (block_diag(*(part[k] for part in parts)) for k in range(4))
    placed = np.eye(3)[:, [AXES.index(axis) for axis in source.axes]]  # (3, m)
    return Predictor(A, K @ placed.T, placed @ C, placed @ P)


def _predictor(
    filter: LinearFilter, period: float, ahead: float, noise: float
) -> tuple[Array, Array, Array, Array]:
    """A, K, C and P of a `Predictor` of a filter's outputs, whose readings have a variance."""
    A, C = expm(filter.A * period), filter.C
    covariance = filter.covariance()
    Q = covariance - A @ covariance @ A.T
    variance = C @ covariance @ C.T
    R = (noise + EXACT * np.trace(variance)) * np.eye(len(C))
    before = solve_discrete_are(A.T, C.T, (Q + Q.T) / 2.0, R)
    K = before @ C.T @ np.linalg.inv(C @ before @ C.T + R)
    return A, K, C @ A, C @ expm(filter.A * ahead)
