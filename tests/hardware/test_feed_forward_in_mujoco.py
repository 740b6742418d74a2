"""The feed-forward on MuJoCo's moving base: other physics, the same law, the same error."""

from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    Accelerometer,
    BaseAcceleration,
    ClosedLoop,
    FeedForward,
    Hardware,
    Harmonic,
    ShapedNoise,
    Sinusoid,
    Vibration,
    realise,
    simulate,
)
from ftcfa.control.protocol import BaseReading, Desired, Measured

from ..vibration.test_moving_base import Oracle, arm_of

PERIOD, SUBSTEPS, DURATION, SEED = 1e-3, 4, 1.5, 1
DELAY = 2e-3
WITHIN = 0.1
"""Relative difference of the rms errors that the two simulations may have."""
ARM = arm_of("panda")
TRUCK = ShapedNoise.from_psd("mil_std_810g_highway_truck_vertical")
BASES = {"truck": TRUCK, "sine": Harmonic(5.0, 5.0)}


def in_mujoco(loop):
    """Rms of the error after half a second, by MuJoCo's accelerations on a base that slides."""
    h, late = loop.step_length, round(DELAY / loop.step_length)
    steps = round(DURATION / h)
    motion = np.zeros((steps, 3))
    motion[:, 2:] = realise(loop.vibration.excitation, 1, DURATION, h, seed=SEED)
    q, v, base, speed = ARM.home.copy(), np.zeros(ARM.n), np.zeros(3), np.zeros(3)
    oracle, state, errors = Oracle("panda", "slides"), None, []
    for k in range(steps):
        if k % SUBSTEPS == 0:
            desired = Desired(*(x[0] for x in loop.reference.at(np.array([k * h]))))
            shown = motion[k - 1 - late] if k - 1 - late >= 0 else np.zeros(3)
            measured = Measured(q, v, BaseReading(shown - ARM.gravity))
            if state is None:
                state = loop.controller.init(measured, desired)
            signals, state = loop.controller.step(state, measured, desired, PERIOD)
            u = np.clip(signals["u"], -ARM.effort_limit, ARM.effort_limit)
            errors.append(np.linalg.norm(q - desired.q))
        friction = ARM.damping_matrix(v) @ v
        a = oracle.acceleration(q, v, base, speed, motion[k], ARM.gravity, u - friction)
        q, v = q + h * v, v + h * a
        base, speed = base + h * speed, speed + h * motion[k]
    return float(np.sqrt(np.mean(np.square(errors[500:]))))


@pytest.mark.parametrize("name", BASES)
def test_the_error_is_ours(name):
    loop = ClosedLoop(
        ARM,
        FTCF(ARM, compensation="bias"),
        Sinusoid(0.3, offset=ARM.home),
        Vibration(BaseAcceleration("z"), BASES[name]),
        PERIOD,
        SUBSTEPS,
        hardware=Hardware(accelerometer=Accelerometer(delay=DELAY)),
    )
    errors = {}
    for law in (loop.controller, FeedForward(ARM, loop.controller)):
        it = replace(loop, controller=law)
        ote = simulate(it, DURATION, seed=SEED).ote.values[500:-1]
        errors[law] = float(np.sqrt(np.mean(ote**2)))
        assert in_mujoco(it) == pytest.approx(errors[law], rel=WITHIN)
    without, with_it = errors.values()
    assert with_it < 0.5 * without
