"""Small loops with hardware, and what they measure."""

import numpy as np

from ftcfa import (
    FTCF,
    Accelerometer,
    Actuators,
    BaseAcceleration,
    ClosedLoop,
    Gyroscope,
    Hardware,
    Sensors,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
)

ARM = load_arm("double_pendulum")
SHAKEN = Vibration(BaseAcceleration("xz"), WhiteNoise(0.1))
EVERYTHING = Hardware(
    Sensors(
        resolution=1e-4, noise=1e-4, offset=1e-3, velocity_noise=1e-2, latency=1e-3, dropped=0.1
    ),
    Actuators(
        rate_limit=[500.0, 200.0], resolution=0.05, delay=1.5e-3, bandwidth=60.0, ripple=0.05,
        effort_limit=[12.0, 14.0],
    ),
    Accelerometer(
        6, noise_density=0.01, bias=0.1, range=30.0, bandwidth=80.0, delay=2e-3, rate=500.0,
        gyroscope=Gyroscope(1e-3, bias=0.01, range=2.0),
    ),
)  # fmt: skip
"""Hardware with every block switched on, for steps of 0.5 ms."""


def loop(hardware=None, arm=ARM, **changes):
    """A shaken pendulum with hardware."""
    parts = {
        "controller": FTCF(arm, compensation="bias"),
        "reference": Sinusoid([0.5, 0.4], 2.0),
        "vibration": SHAKEN,
        "hardware": hardware,
    }
    return ClosedLoop(arm, **{**parts, **changes})


def signals(hardware, duration=0.5, **changes):
    """All signals of a path of such a loop, as arrays by name."""
    options = {key: changes.pop(key) for key in ("seed", "engine") if key in changes}
    found = simulate(loop(hardware, **changes), duration, signals="all", **options)
    return {name: np.asarray(found[name]) for name in found.data_vars}
