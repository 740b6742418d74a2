"""Gains for an arm, its hardware and its base by rules of thumb, without a search.

The nominal error of a joint obeys z'' + (a1 + a2) z' + a1 a2 z = d, d the acceleration by the base.
The sampled loop answers after T: the latency and delays, the lags, and one and a half periods for
sample and hold. The rates are equal, a1 = a2 = a: of all rates with the same sum, to which the
torque rate belongs, they have the largest stiffness a1 a2. a is the smallest of

    0.27/T            phase margin: the open loop (2 a s + a^2) exp(-s T)/s^2 crosses 1 at 2.06 a,
                      where its phase is 76 deg - 2.06 a T above -180 deg: 44 deg
    sqrt(A/e)         at the stated error e the law asks for the torque that gravity leaves at home,
                      A = (u* - |h|)/M_jj, in the joint where that is least
    (R/(2 M_jj e))^(1/3)  an oscillation of the amplitude e at the rate 2 a, which a driver with the
                      rate limit R would turn into a limit cycle, needs no more than R
    a with            rms of s T(s) Lambda xi = R,   T = (2 a s + a^2)/(s + a)^2

the last in the joint where it is first; Lambda xi is the load of the base at home, and R the
driver's rate limit or, where there is none, u* in 50 ms. With a margin of 44 deg the loop bears
inertias, and so a gain, that are wrong by a factor of 2. Not considered: noise and resolution of
the sensors, and what the arm's own uncertainty costs.

For kappa < 1 the slope of (7) and (8) at zero error is infinite, so the loop is linearised by the
secant at the stated error e:

    a1 = c1 e^(kappa - 1) + 3/4 (1 + k1),   a2 = c2 (a1 e)^(kappa - 1) + 3/4 k2 + 5/4

Below e the rates are higher, as e^(kappa - 1). The phase margin is gone at 2.4 times the rates, so
T makes a limit cycle of some e/9 at most for kappa = 0.6.
"""

from dataclasses import replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.control.gains import Gains
from ftcfa.hardware.hardware import Hardware
from ftcfa.hardware.profiles import as_hardware
from ftcfa.model.arm import Arm
from ftcfa.vibration.inputs.noise_input import noise_input
from ftcfa.vibration.realisation import realise
from ftcfa.vibration.vibration import Vibration

MARGIN = 0.27
"""a T for a phase margin of 44 deg."""
FOR_BASE = 1.0
"""Share of the torque rate limit that the base's motion takes, rms: it then acts at times."""
SWING = 0.05
"""Time in which a torque may change by its limit, where no driver limits its rate [s]."""
AMPLITUDE = 0.01
"""The stated error e [rad or m]."""
DURATION, STEP = 10.0, 1e-4
"""Length of the realised vibration, and its longest step [s]."""
RATES = np.geomspace(2.0, 300.0, 101)
"""Rates a that are tried [1/s]."""


def suggest_gains(
    arm: Arm,
    period: float = 1e-3,
    hardware: Hardware | str | None = None,
    vibration: Vibration | None = None,
    *,
    amplitude: float = AMPLITUDE,
) -> Gains:
    """Gains of the paper's law by the rules above, with the paper's kappa, iota, lambda and tau.

    Args:
        arm: The arm as the controller knows it.
        period: Sampling period of the controller [s].
        hardware: What the robot measures and what its motors can do, or the name of a profile.
        vibration: How its base is shaken.
        amplitude: e, the error at which the law has the rate a [rad or m].

    Raises:
        ParameterError: If a number is out of range.
    """
    rate = suggest_rate(arm, period, hardware, vibration, amplitude=amplitude)
    return gains_of_rate(rate, amplitude)


def suggest_rate(
    arm: Arm,
    period: float = 1e-3,
    hardware: Hardware | str | None = None,
    vibration: Vibration | None = None,
    *,
    amplitude: float = AMPLITUDE,
) -> float:
    """The rate a = a1 = a2 of any law by the rules above [1/s]; see `suggest_gains`."""
    positive("suggest_gains period", period, "s")
    positive("suggest_gains amplitude", amplitude, "rad or m")
    known = None if hardware is None else as_hardware("suggest_gains hardware", hardware)
    inertia = np.diag(arm.mass_matrix(arm.home))
    cubes = _rate_limit(arm, known) / (2.0 * inertia * amplitude)
    rate = min(
        MARGIN / answer_time(period, known),
        float(np.sqrt(np.min(_spare_acceleration(arm, known)) / amplitude)),
        float(np.min(cubes) ** (1.0 / 3.0)),
        _rate_for_base(arm, known, vibration, period),
    )
    return max(rate, float(RATES[0]))


def gains_of_rate(rate: float, amplitude: float, others: Gains | None = None) -> Gains:
    """Gains whose secants at an error [rad or m] are a1 = a2 = rate [1/s].

    k1 and k2 are the paper's where their linear terms are at most half of the rate, else smaller;
    all else is that of ``others``, by default the paper's.
    """
    gains = replace(others or Gains(), k1=min(2.0, max(0.1, 2.0 * rate / 3.0 - 1.0)), k2=1.0 / 3.0)
    power = 1.0 - gains.kappa
    c1 = (rate - gains.linear_position_rate) * amplitude**power
    c2 = (rate - gains.linear_velocity_rate) * (rate * amplitude) ** power
    return replace(gains, c1=float(c1), c2=float(c2))


def answer_time(period: float, hardware: Hardware | None) -> float:
    """T, from a motion to the torque that answers it [s]."""
    time = 1.5 * period
    if hardware is not None:
        time += hardware.sensors.latency + hardware.actuators.delay
        for part in (hardware.actuators, hardware.sensors.velocity):
            time += 1.0 / (2.0 * np.pi * float(np.min(getattr(part, "bandwidth", np.inf))))
    return time


def _torque_limit(arm: Arm, hardware: Hardware | None) -> Array:
    limit = arm.effort_limit if hardware is None else hardware.limit(arm.effort_limit)
    return np.asarray(limit)


def _spare_acceleration(arm: Arm, hardware: Hardware | None) -> Array:
    """What gravity leaves of each torque at home, over the inertia [rad/s^2], shape (n,)."""
    limit = _torque_limit(arm, hardware)
    left = np.maximum(limit - np.abs(arm.potential_force(arm.home)), 0.1 * limit)
    return np.asarray(left / np.diag(arm.mass_matrix(arm.home)))


def _rate_limit(arm: Arm, hardware: Hardware | None) -> Array:
    """R of each joint, shape (n,) [N m/s]."""
    assumed = _torque_limit(arm, hardware) / SWING
    if hardware is None:
        return assumed
    known = np.asarray(hardware.actuators.rate_limit, dtype=float)
    return np.where(np.isfinite(known), known, assumed)


def _rate_for_base(
    arm: Arm, hardware: Hardware | None, vibration: Vibration | None, period: float
) -> float:
    """The rate a with which the base takes its share of the torque rate limit [1/s]."""
    if vibration is None:
        return np.inf
    limit = _rate_limit(arm, hardware)
    load = np.fft.rfft(_load(arm, vibration, period), axis=0)  # (F, n)
    f = 2j * np.pi * np.fft.rfftfreq(round(DURATION / period), period)
    for rate in RATES:
        answer = f * (2.0 * rate * f + rate**2) / (f + rate) ** 2
        wanted = np.sqrt(2.0 * np.sum(np.abs(answer[:, None] * load) ** 2, axis=0))
        if np.any(wanted / round(DURATION / period) > FOR_BASE * limit):
            return float(rate)
    return float(RATES[-1])


def _load(arm: Arm, vibration: Vibration, period: float) -> Array:
    """Mean load of the base on each joint at home over each period, shape (periods, n) [N m]."""
    coupling = np.asarray(noise_input(vibration.input).matrix(arm, arm.home))  # (n, m)
    parts = int(np.ceil(period / STEP))
    periods = round(DURATION / period)
    motion = realise(vibration.excitation, coupling.shape[1], periods * period, period / parts)
    means = motion[: periods * parts].reshape(periods, parts, -1).mean(axis=1)
    return np.asarray(vibration.level * means @ coupling.T)
