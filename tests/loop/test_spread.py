"""What differs from path to path, and desired motions that are scaled."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    MinimumJerk,
    Sinusoid,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.errors import FtcfaError

ARM = load_arm("double_pendulum")
LOOP = ClosedLoop(
    ARM,
    FTCF(ARM, compensation="bias"),
    Sinusoid([0.4, 0.2], 2.0, 0.5, [0.1, -0.2]),
    Vibration(BaseAcceleration(), WhiteNoise(0.1)),
)
SPREAD = replace(LOOP, spread={"reference_scale": (0.5, 1.5), "vibration.level": (0.0, 2.0)})
ROUNDING = 1e-12


def test_a_scaled_sinusoid_is_a_sinusoid_of_that_amplitude():
    """About the first posture: offset + A sin(phase) stays where it is."""
    scale = 0.35
    first = [0.1 + 0.4 * np.sin(0.5), -0.2 + 0.2 * np.sin(0.5)]
    offset = np.array(first) - scale * np.array([0.4, 0.2]) * np.sin(0.5)
    same = replace(LOOP, reference=Sinusoid([0.4 * scale, 0.2 * scale], 2.0, 0.5, offset))
    ours, theirs = (
        simulate(it, 0.5, seed=3) for it in (replace(LOOP, reference_scale=scale), same)
    )
    for name in ("q_d", "q", "u", "ote"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0, atol=1e-10, err_msg=name)


@pytest.mark.parametrize(
    "reference", [LOOP.reference, MinimumJerk([0.0, 0.4], [[0.1, 0.0], [0.3, -0.1]])]
)
def test_scaled_to_zero_it_stands_still_at_its_first_posture(reference):
    it = replace(LOOP, reference=reference, reference_scale=0.0)
    q, v, a = it.desired(np.linspace(0.0, 1.0, 11))
    np.testing.assert_array_equal(q, np.broadcast_to(reference.at(np.zeros(1)).q, q.shape))
    assert not v.any()
    assert not a.any()


def test_its_rates_are_its_derivatives():
    it, t, h = replace(LOOP, reference_scale=1.7), np.linspace(0.1, 1.0, 10), 1e-5
    before, now, after = (it.desired(t + dt) for dt in (-h, 0.0, h))
    np.testing.assert_allclose((after.q - before.q) / (2 * h), now.v, atol=1e-8)
    np.testing.assert_allclose((after.v - before.v) / (2 * h), now.a, atol=1e-8)


def test_every_path_has_its_own_scale_on_both_engines():
    scales = [0.0, 0.7, 1.0]
    paths = [
        simulate_paths(LOOP, 3, 0.1, vary={"reference_scale": scales}, engine=engine)
        for engine in ("compiled", "interpreted")
    ]
    for name in ("q", "u", "q_d", "ote"):
        np.testing.assert_allclose(*(run[name] for run in paths), atol=1e-10, err_msg=name)
    for i, scale in enumerate(scales):
        alone = simulate(replace(LOOP, reference_scale=scale), 0.1, path=i)
        for name in ("q", "u", "q_d", "ote"):
            np.testing.assert_allclose(paths[0][name][i], alone[name], atol=1e-10, err_msg=name)


def test_drawn_values_are_uniform_and_belong_to_the_path():
    many = simulate_paths(SPREAD, 500, 0.01)
    scale, level = many["reference_scale"].values, many["vibration.level"].values
    assert stats.kstest(scale - 0.5, "uniform").pvalue > 1e-6
    assert stats.kstest(level / 2.0, "uniform").pvalue > 1e-6
    assert abs(np.corrcoef(scale, level)[0, 1]) < 5.0 / np.sqrt(500)
    np.testing.assert_array_equal(simulate_paths(SPREAD, [77], 0.01).q[0], many.q[77])


def test_an_ensemble_counts_errors_from_each_path_s_own_reference():
    found = ensemble(SPREAD, 9, 0.3, after=0.1, record_every=10)
    paths = simulate_paths(SPREAD, 9, 0.3)
    rms = np.sqrt((paths.ote.isel(time=slice(100, None)) ** 2).mean("time"))
    np.testing.assert_allclose(found.late_rms_error, rms, rtol=1e-9)
    mean = paths.ote.isel(time=slice(0, None, 10)).mean("path")
    np.testing.assert_allclose(found["ote_mean"].sel(bound="estimate"), mean, rtol=1e-9)


@pytest.mark.parametrize(
    ("spread", "message"),
    [
        ({"reference_scales": (0.0, 1.0)}, "mean 'reference_scale'"),
        ({"reference_scale": 2.0}, "spread of reference_scale: 2.0, expected a smallest and a"),
        ({"reference_scale": (2.0, 1.0)}, "expected a smallest and a largest number"),
        ({"controller.gains.c1": (-1.0, 1.0)}, "expected numbers > 0"),
        ({"vibration.level": (-1.0, 1.0)}, "expected"),
    ],
)
def test_a_wrong_spread_is_refused(spread, message):
    with pytest.raises(FtcfaError, match=message):
        replace(LOOP, spread=spread)
