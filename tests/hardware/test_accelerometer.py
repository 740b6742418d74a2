"""The accelerometer on the base: noise by Welch, tilt, range, bandwidth, delay, rate."""

import numpy as np
import pytest
from scipy import signal

from ftcfa import (
    Accelerometer,
    BaseAcceleration,
    BaseMotion,
    Constant,
    Gyroscope,
    Hardware,
    Harmonic,
    RandomPhase,
    Spectrum,
    Vibration,
    load_arm,
)

from .loops import ARM, signals
from .test_sensors import EXACT

G = 9.81
H = 1e-3


def readings(accelerometer, vibration=None, duration=0.5, **changes):
    """Readings of an accelerometer on a base, shape (samples, 3 or 6)."""
    hardware = Hardware(accelerometer=accelerometer)
    found = signals(hardware, duration, vibration=vibration, **changes)
    shown = [found[name] for name in ("base_measured", "base_rate_measured") if name in found]
    return np.concatenate(shown, axis=-1)


def test_a_level_base_at_rest_feels_gravity_upwards():
    shown = readings(Accelerometer(bias=[0.1, 0.0, -0.2]))
    np.testing.assert_allclose(shown - ([0.1, 0.0, G - 0.2],), 0.0, atol=EXACT)


@pytest.mark.parametrize("rate", [None, 250.0])
def test_noise_density_by_welch(rate):
    density = 0.02
    shown = readings(Accelerometer(noise_density=density, rate=rate), duration=60.0)
    every = 1 if rate is None else 4
    fs = 1.0 / (every * H)
    samples = shown[::every] - (0.0, 0.0, G)
    _, psd = signal.welch(samples, fs, nperseg=1024, axis=0)
    level = np.sqrt(psd[2:-2].mean(axis=0))
    np.testing.assert_allclose(level, density, rtol=0.02)  # some 60 segments, 500 lines
    assert np.all(np.abs(np.sqrt(psd[2:-2]) / density - 1) < 0.8)
    held = shown[: len(shown) // every * every].reshape(-1, every, 3)
    assert np.all(held == held[:, :1])


def sine(amplitude, frequency):
    return Vibration(BaseAcceleration("x"), Harmonic(amplitude, frequency))


def test_delay_is_a_shift_and_range_a_clip():
    now = readings(Accelerometer(), sine(5.0, 7.0))[:, 0]
    late = readings(Accelerometer(delay=6e-3), sine(5.0, 7.0))[:, 0]
    np.testing.assert_allclose(late[7:], now[1:-6], atol=EXACT)
    np.testing.assert_array_equal(late[0], 0.0)
    np.testing.assert_array_equal(late[1:7], now[1])  # as if it had moved so before
    clipped = readings(Accelerometer(range=3.0), sine(5.0, 7.0))
    np.testing.assert_allclose(clipped[:, 0], np.clip(now, -3, 3), atol=EXACT)
    np.testing.assert_allclose(clipped[:, 2], 3.0)  # gravity is beyond the range too


def test_a_reading_is_the_mean_of_the_last_step():
    amplitude, frequency = 5.0, 7.0
    shown = readings(Accelerometer(), sine(amplitude, frequency))[:, 0]
    angle = 2 * np.pi * frequency * H * (np.arange(1, len(shown)) - 0.5)
    waves = np.column_stack([np.sin(angle), np.cos(angle)])
    parts, rest, *_ = np.linalg.lstsq(waves, shown[1:], rcond=None)
    assert np.hypot(*parts) == pytest.approx(amplitude, rel=1e-3)
    assert rest[0] < 1e-9


def test_bandwidth():
    corner, frequency = 20.0, 35.0
    shown = readings(Accelerometer(bandwidth=corner), sine(5.0, frequency), duration=2.0)[1000:, 0]
    amplitude = np.sqrt(2) * shown.std()
    assert amplitude == pytest.approx(5.0 / np.hypot(1.0, frequency / corner), rel=0.02)


def test_a_tilted_base_feels_gravity_turned():
    swing = RandomPhase(Spectrum([0.5, 1.0, 2.0], [0.2, 0.2, 0.2]), lines=40)
    tilted = Vibration(BaseMotion("", "y"), swing)
    shown = readings(Accelerometer(6, gyroscope=Gyroscope()), tilted, duration=5.0)[2:]
    force, omega = shown[:, :3], shown[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), G, rtol=1e-9)
    angle = np.arctan2(-force[:, 0], force[:, 2])  # R(y, angle)^T (0, 0, g)
    assert np.ptp(angle) > 0.02
    np.testing.assert_allclose(np.diff(angle) / H, omega[:-1, 1], atol=2e-3 * np.abs(omega).max())
    np.testing.assert_allclose(omega[:, [0, 2]], 0.0, atol=EXACT)


def test_on_a_wall_the_axes_are_those_of_the_world():
    wall = load_arm("panda", mounting="wall")
    shown = readings(Accelerometer(), arm=wall, reference=Constant(wall.home))
    np.testing.assert_allclose(shown[0], [0.0, 0.0, G])


def test_it_needs_no_vibration_of_the_base():
    assert np.all(readings(Accelerometer())[:, :2] == 0.0)
    assert ARM.gravity[2] == pytest.approx(-G, abs=0.02)
