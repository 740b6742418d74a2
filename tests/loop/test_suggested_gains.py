"""Suggested gains: the rules one by one, and that the loops hold."""

from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    Actuators,
    BaseAcceleration,
    ClosedLoop,
    Hardware,
    Sensors,
    ShapedNoise,
    Sinusoid,
    Uncertainty,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    suggest_gains,
)
from ftcfa.errors import FtcfaError
from ftcfa.loop.suggested_gains import MARGIN, gains_of_rate, suggest_rate

ARM = load_arm("double_pendulum_relative")
STRONG = load_arm("double_pendulum_relative", effort_limit=1e9)


def test_the_secants_at_the_amplitude_are_the_rate():
    for rate in (3.0, 10.0, 100.0):
        g, e = gains_of_rate(rate, 0.01), 0.01
        a1 = g.c1 * e ** (g.kappa - 1.0) + 0.75 * (1.0 + g.k1)
        a2 = g.c2 * (rate * e) ** (g.kappa - 1.0) + 0.75 * g.k2 + 1.25
        np.testing.assert_allclose([a1, a2], rate)
    assert gains_of_rate(100.0, 0.01).k1 == 2.0


def test_with_strong_motors_on_a_still_base_the_delay_decides():
    assert suggest_rate(STRONG, 1e-3) == pytest.approx(MARGIN / 1.5e-3)
    assert suggest_rate(STRONG, 4e-3) == pytest.approx(MARGIN / 6e-3)
    late = Hardware(Sensors(latency=5e-3), Actuators(delay=2e-3, bandwidth=50.0))
    time = 1.5e-3 + 7e-3 + 1.0 / (2.0 * np.pi * 50.0)
    assert suggest_rate(STRONG, 1e-3, late) == pytest.approx(MARGIN / time)


def test_the_phase_margin_is_as_stated():
    """Of (2 a s + a^2) exp(-s T)/s^2, on a fine grid of frequencies."""
    w = np.geomspace(0.1, 10.0, 100_001)  # in units of a
    open_loop = (2j * w + 1.0) / (1j * w) ** 2
    crossing = np.argmin(np.abs(np.abs(open_loop) - 1.0))
    phase = np.degrees(np.angle(open_loop[crossing])) % 360.0 - 180.0
    assert w[crossing] == pytest.approx(2.06, abs=0.005)
    assert phase - np.degrees(w[crossing] * MARGIN) == pytest.approx(44.0, abs=1.0)


def test_the_torque_that_gravity_leaves_holds_the_error():
    q = ARM.home
    spare = (ARM.effort_limit - np.abs(ARM.potential_force(q))) / np.diag(ARM.mass_matrix(q))
    weak = Hardware(actuators=Actuators(rate_limit=1e12))
    assert suggest_rate(ARM, 1e-4, weak) == pytest.approx(np.sqrt(np.min(spare) / 0.01))


def test_the_driver_s_rate_limit_bears_an_oscillation():
    limited = Hardware(actuators=Actuators(rate_limit=50.0))
    inertia = np.max(np.diag(STRONG.mass_matrix(STRONG.home)))
    found = suggest_rate(STRONG, 1e-4, limited, amplitude=0.02)
    assert found == pytest.approx((50.0 / (2.0 * inertia * 0.02)) ** (1.0 / 3.0))


def test_a_base_that_shakes_twice_as_much_never_gets_more():
    shaken = Vibration(BaseAcceleration("xyz"), ShapedNoise("mil_std_810g_highway_truck_vertical"))
    shaken = replace(shaken, input=BaseAcceleration("x"))
    rates = [suggest_rate(ARM, vibration=replace(shaken, level=level)) for level in (0, 1, 20, 400)]
    assert rates[0] == suggest_rate(ARM)
    assert np.all(np.diff(rates) <= 0)
    assert rates[-1] < rates[0]


@pytest.mark.parametrize("robot", ["panda", "ur5", "xarm7", "talos_left_arm", "double_pendulum"])
def test_the_loops_hold(robot):
    """Uncertain robots whose bases shake, from 0.05 rad off in every joint."""
    arm = load_arm(robot)
    shaken = Vibration(BaseAcceleration(), WhiteNoise(0.1))
    law = FTCF(arm, suggest_gains(arm, vibration=shaken), compensation="bias")
    it = ClosedLoop(
        arm,
        law,
        Sinusoid(0.3, offset=arm.home),
        shaken,
        q0=arm.home + 0.05,
        uncertainty=Uncertainty(mass=0.2, centre=0.01, shape=0.1),
    )
    found = ensemble(it, 50, 2.0)
    assert int(found.attrs["kept"]) == 50
    assert float(found.late_rms_error.median()) < 0.05


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0.0}, "suggest_gains period: 0.0, expected a number > 0"),
        ({"amplitude": -1.0}, "suggest_gains amplitude: -1.0, expected a number > 0"),
        ({"hardware": "fr4"}, "fr4"),
    ],
)
def test_wrong_arguments_are_refused(options, message):
    with pytest.raises(FtcfaError, match=message):
        suggest_gains(ARM, **options)
