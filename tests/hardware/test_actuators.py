"""The actuators against their definitions, on recorded signals."""

import numpy as np
import pytest
from scipy import signal, stats

from ftcfa import Actuators, Hardware, ensemble, simulate_paths

from .loops import ARM, loop, signals
from .test_sensors import ERROR_RATE, EXACT

H = 1e-3
LIMIT = ARM.effort_limit


def held():
    """The torque that holds the arm before the first sample."""
    return np.clip(ARM.potential_force(ARM.home), -LIMIT, LIMIT)


def wanted(it):
    """Commands within the limits."""
    return np.clip(it["u_command"], -LIMIT, LIMIT)


def limited(commands, rate, start):
    """An independent rate limiter, sample by sample."""
    now, out = start, []
    for row in commands:
        now = now + np.clip(row - now, -rate * H, rate * H)
        out.append(now)
    return np.array(out)


def test_the_rate_limit():
    rate = np.array([300.0, 100.0])
    it = signals(Hardware(actuators=Actuators(rate_limit=rate)))
    expected = limited(wanted(it), rate, held())
    np.testing.assert_allclose(it["u_driven"], expected, atol=EXACT)
    np.testing.assert_allclose(it["u"], expected, atol=EXACT)
    steps = np.abs(np.diff(it["u"], axis=0)) / H
    assert np.all(steps <= rate * (1 + 1e-9))
    assert np.mean(steps[:, 0] > 0.999 * rate[0]) > 0.05  # it does act


def test_quantised_torques():
    it = signals(Hardware(actuators=Actuators(resolution=0.25)))
    np.testing.assert_allclose(it["u"], 0.25 * np.floor(wanted(it) / 0.25 + 0.5), atol=EXACT)


def test_delay():
    it = signals(Hardware(actuators=Actuators(delay=3e-3)))
    expected = np.concatenate([np.repeat(held()[None], 3, axis=0), wanted(it)[:-3]])
    np.testing.assert_allclose(it["u"], expected, atol=EXACT)


def test_the_lag_is_that_of_a_first_order_filter_with_held_input():
    bandwidth = 30.0
    it = signals(Hardware(actuators=Actuators(bandwidth=bandwidth)))
    w = 2 * np.pi * bandwidth
    one = np.ones((1, 1))
    system = signal.cont2discrete((-w * one, w * one, one, 0 * one), H, "zoh")
    for joint in range(2):
        u = wanted(it)[:, joint]
        _, y, _ = signal.dlsim((*system[:4], H), u, x0=np.array([held()[joint]]))
        np.testing.assert_allclose(it["u"][:-1, joint], y[1:, 0], atol=1e-9)  # at the step's end


def test_ripple():
    it = signals(Hardware(actuators=Actuators(ripple=0.02, effort_limit=100.0)), duration=2.0)
    inside = np.abs(wanted(it)) < LIMIT - 0.2
    errors = (it["u"] - it["u_driven"])[np.all(inside, axis=1)] / 0.02
    for one in errors.T:
        assert stats.kstest(one, "norm").pvalue > ERROR_RATE


def test_saturation_comes_last_and_takes_the_lower_limit():
    own = np.array([4.0, 100.0])
    it = signals(Hardware(actuators=Actuators(ripple=2.0, effort_limit=own)))
    limit = np.minimum(own, LIMIT)
    assert np.all(np.abs(it["u"]) <= limit)
    assert np.abs(it["u"][:, 0]).max() == pytest.approx(4.0)


def test_before_the_first_sample_the_motors_hold_the_arm():
    q0 = np.array([0.6, 0.4])
    it = signals(Hardware(actuators=Actuators(delay=2e-3)), q0=q0, vibration=None, duration=0.01)
    np.testing.assert_allclose(it["u"][0], ARM.potential_force(q0), atol=EXACT)
    np.testing.assert_allclose(it["q"][2], q0, atol=1e-9)  # it has not moved


def test_metrics_of_the_limits():
    """The shares and rates of an ensemble against the signals of its paths."""
    it = loop(Hardware(actuators=Actuators(rate_limit=[300.0, 100.0])))
    runs = ensemble(it, 3, 0.5)
    paths = simulate_paths(it, 3, 0.5, signals="all")
    wanted = np.clip(paths.u_command, -LIMIT, LIMIT)
    acting = (np.abs(paths.u_driven - wanted) > 0).mean("time")
    np.testing.assert_allclose(runs.rate_limited, acting, atol=EXACT)
    assert 0.05 < float(acting[:, 0].mean()) < 0.95
    rate = np.sqrt((wanted.diff("time") ** 2).mean("time")) / H
    np.testing.assert_allclose(runs.rms_wanted_rate, rate, rtol=1e-9)
    assert np.all(runs.peak_torque_rate <= np.array([300.0, 100.0]) * (1 + 1e-9))
    beyond = (np.abs(paths.u_command) > LIMIT).any("joint").mean("time")
    np.testing.assert_allclose(runs.saturated, beyond, atol=EXACT)
