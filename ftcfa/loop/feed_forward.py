"""Which band a feed-forward of the base's motion should have, and the loop that has it.

With the load d of the base, the load d_s that the sensor's range leaves of it, the low-pass F of
the band, the transfer H of accelerometer, motors, hold and delays, and the law's own answer T to a
disturbance,

    error of the arm   W (d - F H d_s),     W = 1/((s + a1)(s + a2))
    torque             F H d_s + T (d - F H d_s),     T = ((a1 + a2) s + a1 a2) W

for a law of the rates a1 and a2 that all laws of the package share (`ftcfa.control.laws`). Noise
and bias of the sensor come on top, through F and the motors. The rule: among the bands whose
largest torque rate, over the realised motion, stays within HEADROOM of the rate limit of every
joint, and whose noise stays within NOISY of its effort limit, the one with the least mean-square
error. None, where that is less than TENTH below the error without
feed-forward, or where no band keeps the limit: a limit that acts turns the phase, and then a
feed-forward can do harm. The rule is careful: where it says none because of the limit,
`ftcfa.tune` with ``{"controller.band": (0.1, 300.0)}`` tries by simulation.
"""

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.control.feed_forward import FeedForward
from ftcfa.control.gains import A1, A2
from ftcfa.errors import ParameterError
from ftcfa.hardware.hardware import Hardware
from ftcfa.loop.base_load import base_load, bias_load, noise_load
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.vibration.inputs.base_motion import BaseMotion
from ftcfa.vibration.inputs.noise_input import BaseAcceleration

DURATION = 40.0
"""Length of the realised motion [s]."""
EDGE = 1.0
"""What is left out at both ends, where the repeated motion jumps [s]."""
BANDS = (*np.geomspace(0.1, 300.0, 36).tolist(), np.inf)
"""Bands that are tried [Hz]."""
TENTH = 0.1
"""Least relative decrease of the rms error that is worth a feed-forward."""
HEADROOM = 0.4
"""Share of the rate limit that the base's motion may take. The rest is for the reference, for
robots that differ from the nominal one, and for gains that are larger at small errors."""
NOISY = 0.2
"""Share of the effort limit that the sensor's noise may take at its peaks."""
BEYOND = 0.01
"""Share of the samples at which a reading may be out of range: beyond it the load jumps."""
PEAK = 4.5
"""Largest deviation of a Gaussian sequence of some 10^5, in standard deviations."""

Spectrum = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class FeedForwardBand:
    """What the rule says.

    Attributes:
        band: Corner frequency of the low-pass [Hz], or None where no feed-forward is better.
        error: Predicted rms error with it over that without.
        peak_rate: Predicted largest torque rate over the limit, of the joint where it is largest;
            0 without a limit.
        why: Why there is none; empty if there is one.
    """

    band: float | None
    error: float
    peak_rate: float
    why: str = ""


def feed_forward_band(loop: ClosedLoop) -> FeedForwardBand:
    """The band of a feed-forward by the rule above, for the arm in its home posture.

    Args:
        loop: A loop whose base moves, with an accelerometer.

    Raises:
        ParameterError: If its base does not move, or it has no accelerometer.
    """
    hardware = _parts(loop)
    step, nominal = loop.step_length, getattr(loop.controller, "nominal", loop.arm)
    loads = base_load(loop, DURATION)
    count = len(loads.true)
    f = np.fft.rfftfreq(count, step)
    true, shown = (np.fft.rfft(load, axis=0) for load in loads[:2])  # (F, n)
    s = 2j * np.pi * f
    W = 1.0 / ((s + A1) * (s + A2))
    T = ((A1 + A2) * s + A1 * A2) * W
    sensor, motors = _chain(hardware, loop.period, step, cast(Spectrum, s))
    limit = np.broadcast_to(np.asarray(hardware.actuators.rate_limit, dtype=float), nominal.n)
    noise, bias = noise_load(loop, f) * f[1], bias_load(loop)  # (F, n), (n,)
    inside = slice(round(EDGE / step), -round(EDGE / step))

    def over_time(spectrum: Spectrum) -> Array:
        """A motion of its spectrum, without the ends, where it jumps, shape (samples, n)."""
        return np.asarray(np.fft.irfft(spectrum, count, axis=0)[inside])

    def tried(band: float) -> tuple[float, Array]:
        """Mean-square error and the largest torque rates over their limits; band 0 is none."""
        F = (0.0 if band == 0 else 1.0 / (1.0 + s / (2 * np.pi * band))) * motors
        cancelled = (F * sensor)[:, None] * shown
        left = true - cancelled
        error = np.sum(np.mean(over_time(W[:, None] * left) ** 2, axis=0))
        error += np.sum(np.abs(W * F)[:, None] ** 2 * noise)
        error += np.sum((np.abs(W * F)[0] * bias) ** 2)
        rates = np.abs(over_time(s[:, None] * (cancelled + T[:, None] * left))).max(axis=0)
        spread = PEAK * np.sqrt(np.sum(np.abs(s * F)[:, None] ** 2 * noise, axis=0))
        noisy = PEAK * np.sqrt(np.sum(np.abs(F)[:, None] ** 2 * noise, axis=0))
        too_noisy = np.any(noisy > NOISY * nominal.effort_limit)
        return np.inf if too_noisy else float(error), (rates + spread) / limit

    without, rates = tried(0.0)
    best = FeedForwardBand(None, 1.0, float(np.max(rates)))
    if without == 0.0:
        return replace(best, why="the base does not move")
    if loads.beyond > BEYOND:
        return replace(best, why=f"readings are out of range at {loads.beyond:.0%} of the samples")
    beyond = (1.0, 0, 0.0)  # the best band that asks for too much: error, joint, rate
    for band in BANDS:
        error, rates = tried(band)
        ratio, joint = float(np.sqrt(error / without)), int(np.argmax(rates))
        if rates[joint] > HEADROOM:
            beyond = min(beyond, (ratio, joint, float(rates[joint])))
        elif ratio < min(best.error, 1.0 - TENTH):
            best = FeedForwardBand(band, ratio, float(rates[joint]))
    if best.band is not None:
        return best
    return replace(best, why=_why(loop, *beyond))


def _why(loop: ClosedLoop, ratio: float, joint: int, rate: float) -> str:
    """Why there is no band, from the best one that asks for too much."""
    if ratio >= 1.0 - TENTH:
        return (
            "no band makes the error a tenth less: the reading is too late, too noisy, out of "
            "range, or its bias (what a calibration leaves) is too large"
        )
    name = loop.arm.joint_names[joint]
    return (
        f"the error would be {ratio:.2g} of that without, but takes {rate:.2g} of the torque rate "
        f"limit of {name}; the rule allows {HEADROOM:g}"
    )


def with_feed_forward(loop: ClosedLoop) -> ClosedLoop:
    """The loop with a feed-forward of the band that the rule chooses; the loop itself for None.

    Raises:
        ParameterError: As for `feed_forward_band`.
    """
    band = feed_forward_band(loop).band
    if band is None:
        return loop
    nominal = getattr(loop.controller, "nominal", loop.arm)
    return replace(loop, controller=FeedForward(nominal, loop.controller, band))


def _parts(loop: ClosedLoop) -> Hardware:
    """The hardware of a loop that can have a feed-forward."""
    if not isinstance(loop, ClosedLoop):
        raise ParameterError("feed-forward", f"a {type(loop).__name__}", "a ClosedLoop")
    hardware = cast(Hardware | None, loop.hardware)
    if hardware is None or hardware.accelerometer is None:
        remedy = "give the loop hardware=Hardware(accelerometer=Accelerometer(...))"
        raise ParameterError("feed-forward", "no accelerometer", "one on the base", remedy)
    if not isinstance(getattr(loop.vibration, "input", None), BaseAcceleration | BaseMotion):
        expected = "BaseAcceleration or BaseMotion"
        raise ParameterError("feed-forward", "a base that does not move", expected)
    return hardware


def _chain(
    hardware: Hardware, period: float, step: float, s: Spectrum
) -> tuple[Spectrum, Spectrum]:
    """H(s) in two: of the accelerometer with all delays, the hold and the step; of the motors."""
    sensor: Any = hardware.accelerometer
    hold = period if sensor.rate is None else 1.0 / sensor.rate
    late = sensor.delay + hardware.actuators.delay + (hold + step) / 2.0
    motors = np.min(np.asarray(hardware.actuators.bandwidth, dtype=float))
    lags = [1.0 / (1.0 + s / (2 * np.pi * corner)) for corner in (sensor.bandwidth, motors)]
    return cast(Spectrum, np.exp(-s * late) * lags[0]), cast(Spectrum, lags[1])
