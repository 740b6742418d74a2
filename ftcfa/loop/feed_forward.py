"""Which band a feed-forward of the base's motion should have, and the loop that has it.

With the motion a of the base (its load is Lambda a), the low-pass F of the band, the transfer H of
accelerometer, motors, hold and delays, and the law's own answer T to a disturbance,

    error of the arm   W (1 - F H) Lambda a,     W = 1/((s + a1)(s + a2))
    torque             G Lambda a,           G = F H + (1 - F H) T,   T = ((a1 + a2) s + a1 a2) W

for a law of the rates a1 and a2 that all laws of the package share (`ftcfa.control.laws`). The
rule: among the bands whose largest torque rate, over the realised motion, stays within HEADROOM
of the rate limit of every joint, the one with the least mean-square error. None, where that is less
than TENTH below the error without feed-forward, or where no band keeps the limit: a limit that acts
turns the phase, and then a feed-forward does harm.
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
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.vibration.inputs.base_motion import BaseMotion
from ftcfa.vibration.inputs.noise_input import BaseAcceleration
from ftcfa.vibration.realisation import realise

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
    """

    band: float | None
    error: float
    peak_rate: float


def feed_forward_band(loop: ClosedLoop) -> FeedForwardBand:
    """The band of a feed-forward by the rule above, for the arm in its home posture.

    Args:
        loop: A loop whose base moves, with an accelerometer.

    Raises:
        ParameterError: If its base does not move, or it has no accelerometer.
    """
    hardware, vibration = _parts(loop)
    step, nominal = loop.step_length, getattr(loop.controller, "nominal", loop.arm)
    coupling = np.asarray(vibration.input.matrix(nominal, nominal.home))  # (n, m)
    motion = vibration.level * realise(vibration.excitation, coupling.shape[1], DURATION, step)
    f = np.fft.rfftfreq(len(motion), step)
    load = np.fft.rfft(motion, axis=0) @ coupling.T  # (F, n)
    s = 2j * np.pi * f
    W = 1.0 / ((s + A1) * (s + A2))
    T = ((A1 + A2) * s + A1 * A2) * W
    H = _chain(hardware, loop.period, step, cast(Spectrum, s))
    limit = np.broadcast_to(np.asarray(hardware.actuators.rate_limit, dtype=float), nominal.n)
    noise = _noise(hardware, coupling, len(motion), step)

    inside = slice(round(EDGE / step), -round(EDGE / step))

    def over_time(transfer: Spectrum) -> Array:
        """The load behind a transfer, without the ends, where the motion jumps, (samples, n)."""
        return np.asarray(np.fft.irfft(transfer[:, None] * load, len(motion), axis=0)[inside])

    def tried(band: float) -> tuple[float, float]:
        """Mean-square error and the largest torque rate over its limit, of a band; 0 is none."""
        F = (0.0 if band == 0 else 1.0 / (1.0 + s / (2 * np.pi * band))) * H
        error = np.sum(np.mean(over_time(W * (1.0 - F)) ** 2, axis=0))
        error += 2.0 * np.sum(np.abs(W * F) ** 2) * np.sum(noise) / len(motion) ** 2
        rates = np.abs(over_time(s * (F + (1.0 - F) * T))).max(axis=0)
        spread = np.sqrt(2.0 * np.sum(np.abs(s * F) ** 2) * noise) / len(motion)
        return float(error), float(np.max((rates + PEAK * spread) / limit))

    without, best = tried(0.0)[0], FeedForwardBand(None, 1.0, tried(0.0)[1])
    for band in BANDS:
        error, rate = tried(band)
        ratio = float(np.sqrt(error / without))
        if rate <= HEADROOM and ratio < min(best.error, 1.0 - TENTH):
            best = FeedForwardBand(band, ratio, rate)
    return best


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


def _parts(loop: ClosedLoop) -> tuple[Hardware, Any]:
    """The hardware and the vibration, if they are what a feed-forward needs."""
    hardware = cast(Hardware | None, loop.hardware)
    if hardware is None or hardware.accelerometer is None:
        remedy = "give the loop hardware=Hardware(accelerometer=Accelerometer(...))"
        raise ParameterError("feed-forward", "no accelerometer", "one on the base", remedy)
    moves = isinstance(getattr(loop.vibration, "input", None), BaseAcceleration | BaseMotion)
    if not moves:
        expected = "BaseAcceleration or BaseMotion"
        raise ParameterError("feed-forward", "a base that does not move", expected)
    return hardware, loop.vibration


def _chain(hardware: Hardware, period: float, step: float, s: Spectrum) -> Spectrum:
    """H(s): accelerometer, delays, motors, the hold of a period and the mean of a step."""
    sensor: Any = hardware.accelerometer
    hold = period if sensor.rate is None else 1.0 / sensor.rate
    late = sensor.delay + hardware.actuators.delay + (hold + step) / 2.0
    motors = np.min(np.asarray(hardware.actuators.bandwidth, dtype=float))
    lags = [1.0 / (1.0 + s / (2 * np.pi * corner)) for corner in (sensor.bandwidth, motors)]
    return cast(Spectrum, np.exp(-s * late) * lags[0] * lags[1])


def _noise(hardware: Hardware, coupling: Array, count: int, step: float) -> Array:
    """Mean square of a line of the noise's spectrum as a load of each joint, shape (n,)."""
    sensor: Any = hardware.accelerometer
    line = sensor.noise_density**2 * count / (2.0 * step)
    return np.asarray(line * np.sum(coupling**2, axis=1))
