"""The sensors against their definitions, on recorded signals."""

import numpy as np
import pytest
from scipy import stats

from ftcfa import Hardware, Sensors, simulate_paths

from .loops import loop, signals

EXACT = 1e-12
"""Difference of a number that is computed twice."""
ERROR_RATE = 1e-6
"""Probability with which a right sampler fails a statistical test."""


def test_readings_are_late_offset_and_rounded():
    resolution, offset, late = 2e-4, np.array([1e-3, -2e-3]), 3
    it = signals(Hardware(Sensors(resolution, offset=offset, latency=late * 1e-3)))
    before = np.concatenate([np.repeat(it["q"][:1], late, axis=0), it["q"][:-late]])
    expected = resolution * np.floor((before + offset) / resolution + 0.5)
    np.testing.assert_allclose(it["q_measured"], expected, atol=EXACT)
    assert np.abs(it["q_measured"] - before - offset).max() <= resolution / 2 + EXACT
    v = np.concatenate([np.repeat(it["v"][:1], late, axis=0), it["v"][:-late]])
    np.testing.assert_allclose(it["v_measured"], v, atol=EXACT)


def test_latency_counts_integration_steps():
    fine = signals(Hardware(Sensors(latency=5e-4)), period=5e-4)
    coarse = signals(Hardware(Sensors(latency=5e-4)), substeps=2, duration=1e-3)
    assert fine["q_measured"][2, 0] == pytest.approx(fine["q"][1, 0], abs=EXACT)
    first = coarse["q"][0] + 5e-4 * coarse["v"][0]  # after one Euler step of two
    np.testing.assert_allclose(coarse["q_measured"][1], first, atol=EXACT)


@pytest.mark.parametrize(("name", "field"), [("q", "noise"), ("v", "velocity_noise")])
def test_noise_is_white_and_normal(name, field):
    size = np.array([1e-3, 3e-3])
    it = signals(Hardware(Sensors(**{field: size})), duration=4.0)
    errors = (it[f"{name}_measured"] - it[name]) / size
    for one in errors.T:
        assert stats.kstest(one, "norm").pvalue > ERROR_RATE
        assert abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < 5 / np.sqrt(len(one))
    assert abs(np.corrcoef(errors.T)[0, 1]) < 5 / np.sqrt(len(errors))


def test_lost_samples_hold_the_reading_before():
    share = 0.2
    it = signals(Hardware(Sensors(dropped=share)), duration=4.0)
    lost = np.any(it["q_measured"] != it["q"], axis=1)
    assert stats.binomtest(int(lost.sum()), len(lost), share).pvalue > ERROR_RATE
    assert not lost[0] or np.array_equal(it["q_measured"][0], it["q"][0])
    after = np.flatnonzero(lost[1:]) + 1
    for name in ("q_measured", "v_measured"):
        np.testing.assert_array_equal(it[name][after], it[name][after - 1])


def test_velocity_is_measured_as_late_as_position():
    it = signals(Hardware(Sensors(latency=2e-3)))
    np.testing.assert_allclose(it["v_measured"][5:], it["v"][3:-2], atol=EXACT)


def test_latency_may_differ_from_path_to_path():
    times = np.array([0.0, 1e-3, 4e-3])
    many = simulate_paths(
        loop(Hardware(Sensors(latency=1e-3, largest_latency=4e-3))), 3, 0.3,
        vary={"hardware.sensors.latency": times},
    )  # fmt: skip
    for path, time in enumerate(times):
        alone = simulate_paths(loop(Hardware(Sensors(latency=time))), [path], 0.3)
        np.testing.assert_allclose(many.q[path], alone.q[0], atol=1e-9)
    assert np.ptp(np.asarray(many.q[:, -1, 0])) > 1e-6
