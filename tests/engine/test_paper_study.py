"""Section V of the paper: its pendulum, its gains, its noise as printed, its comparison."""

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Gains,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    printed,
    simulate,
    simulate_paths,
)

PATHS = 16
AGREEMENT = 0.10
"""Relative; paths differ among themselves by some 2 %."""
LEVEL = 0.05
"""Overall tracking error that counts as settled [rad]."""
RMS_OTE = {0.6: 0.0030, 1.0: 0.038}
"""Over the last half of 20 s, from a prototype that was written apart from this code [rad]."""


def study(kappa, filter="implicit", period=1e-3):
    arm = load_arm("double_pendulum", gravity=9.8)
    return ClosedLoop(
        arm,
        printed(FTCF(arm, Gains(kappa=kappa), filter=filter)),
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        Vibration(BaseAcceleration("xz"), WhiteNoise(0.1, "amplitude")),
        period=period,
        q0=[-0.1, 0.25],
        v0=[-0.3, 0.45],
    )


def rms_of_last_half(dataset):
    ote = dataset.ote.values
    return np.sqrt(np.mean(ote[..., ote.shape[-1] // 2 :] ** 2, axis=-1))


@pytest.fixture(scope="module", params=list(RMS_OTE))
def study_result(request):
    return request.param, simulate_paths(study(request.param), PATHS, 20.0)


def test_the_steady_tracking_error_is_that_of_the_study(study_result):
    kappa, dataset = study_result
    assert rms_of_last_half(dataset) == pytest.approx(RMS_OTE[kappa], rel=AGREEMENT)


def test_the_torque_stays_within_15_newton_metres(study_result):
    _, dataset = study_result
    assert np.all(np.isnan(dataset.diverged_at))
    assert np.abs(dataset.u).max() <= 15.0


def test_finite_time_settles_early_and_the_asymptotic_law_does_not(study_result):
    """kappa = 0.6: below 0.05 rad for good from 0.5 to 0.6 s; kappa = 1: above it after 17 s."""
    kappa, dataset = study_result
    above = dataset.ote.values > LEVEL
    last = dataset.time.values[above.shape[1] - 1 - np.argmax(above[:, ::-1], axis=1)]
    if kappa == 0.6:
        assert np.all((last > 0.5) & (last < 0.6))
    else:
        assert np.all(last > 17.0)


@pytest.mark.slow
def test_the_interpreted_engine_gives_the_study_too():
    dataset = simulate(study(0.6), 20.0, engine="interpreted")
    assert rms_of_last_half(dataset) == pytest.approx(RMS_OTE[0.6], rel=AGREEMENT)
    assert np.abs(dataset.u).max() <= 15.0


def test_the_explicit_filter_needs_a_tenth_of_the_period():
    """At 1 ms it limit-cycles: abar strays by 0.1 and more; at 0.1 ms it does as the implicit."""
    stray = {}
    for period in (1e-3, 1e-4):
        dataset = simulate(study(0.6, "explicit", period), 10.0, signals=["alpha", "abar"])
        half = dataset.isel(time=slice(dataset.sizes["time"] // 2, None))
        stray[period] = float(np.abs(half.abar - half.alpha).max())
        if period == 1e-4:
            assert rms_of_last_half(dataset) == pytest.approx(RMS_OTE[0.6], rel=AGREEMENT)
    assert stray[1e-3] > 0.1
    assert stray[1e-4] < 0.01
    implicit = simulate(study(0.6), 10.0, signals=["alpha", "abar"])
    assert np.abs(implicit.abar - implicit.alpha)[5000:].max() < 0.002
