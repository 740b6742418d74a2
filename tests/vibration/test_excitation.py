"""Sine on random, and different excitations on different channels."""

import numpy as np
import pytest
from scipy import signal, stats

from ftcfa import (
    Harmonic,
    LinearFilter,
    ParameterError,
    RandomPhase,
    Record,
    RecordedAcceleration,
    ShapedNoise,
    ShapeError,
    SineSweep,
    Stacked,
    Superposition,
    WhiteNoise,
    simulate_paths,
)

from .masses import CONFIDENCE, check_engines, pushed, run_process

TRUCK = "mil_std_810g_highway_truck_vertical"
LAG = LinearFilter([[-20.0]], [[1.0]], [[3.0]])


def recorded(samples=200, axes=1, random_start=True):
    values = np.random.default_rng(0).standard_normal((samples, axes))
    values = signal.sosfilt(signal.butter(4, 50.0, fs=1e3, output="sos"), values, axis=0)
    return RecordedAcceleration(Record(1e-3, values), random_start)


def all_kinds():
    return (
        ShapedNoise(LAG) + recorded() + Harmonic(1.0, 20.0) + WhiteNoise(0.1)
        + SineSweep(1.0, 5.0, 50.0, 0.1) + RandomPhase("astm_d4169_truck_low", 5)
    )  # fmt: skip


@pytest.mark.parametrize(
    "loop",
    [
        pushed(all_kinds(), period=5e-4),
        pushed(WhiteNoise(0.1) + Harmonic(1.0, [20.0, 30.0]), 2, substeps=2),
        pushed(Stacked((WhiteNoise(0.1), recorded(axes=2)), (1, 2)), 3, substeps=2),
        pushed(Stacked((all_kinds(), Harmonic(1.0, 20.0), ShapedNoise(LAG))), 3, period=5e-4),
        pushed(Stacked((recorded(), WhiteNoise(0.1))) + Harmonic(1.0, 10.0), 2),
    ],
)
def test_the_engines_agree(loop):
    check_engines(loop)


def test_a_sum_is_the_sum_of_its_parts():
    """Each part with its own share of the deviates."""
    parts = [ShapedNoise(LAG), recorded(), Harmonic(1.0, 20.0), WhiteNoise(0.1)]
    processes = [part.process(1, 1e-3) for part in parts]
    rng = np.random.default_rng(0)
    normals = [rng.standard_normal((50, p.normals)) for p in processes]
    initial = [rng.standard_normal(p.initial_normals) for p in processes]
    apart = [
        run_process(p, 50, own, start, first=30)[0]
        for p, own, start in zip(processes, normals, initial, strict=True)
    ]
    joint = np.hstack(normals), np.concatenate(initial)
    total = Superposition(parts).process(1, 1e-3)
    np.testing.assert_allclose(run_process(total, 50, *joint, first=30)[0], sum(apart), rtol=1e-13)
    stacked = Stacked(parts).process(4, 1e-3)
    np.testing.assert_array_equal(
        run_process(stacked, 50, *joint, first=30)[0], np.column_stack(apart)
    )


def test_sine_on_random():
    """The mean over paths is the sine, the variance about it the noise's."""
    paths, varpi = 2000, 0.01
    v = simulate_paths(pushed(WhiteNoise(varpi) + Harmonic(2.0, 10.0, 0.3)), paths, 0.1).v
    t, w = v.time.values, 2 * np.pi * 10.0
    sine = 2.0 / w * (np.sin(w * t + 0.3) - np.sin(0.3))
    about = v.values[:, :, 0] - sine
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    for k in (1, 10, 100):
        assert low < np.mean(about[:, k] ** 2) / (varpi * t[k]) < high
        assert abs(np.mean(about[:, k])) < stats.norm.isf(1e-6) * np.sqrt(varpi * t[k] / paths)


def test_the_same_excitation_twice_is_two_independent_ones():
    noise, paths = WhiteNoise(0.01), 2000
    v = simulate_paths(pushed(noise + noise), paths, 0.01).v.values[:, -1, 0]
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    assert low < np.mean(v**2) / (2 * 0.01 * 0.01) < high


def test_white_noise_on_one_channel_and_a_record_on_the_other():
    source = recorded(random_start=False)
    paths = 2000
    v = simulate_paths(pushed(Stacked((WhiteNoise(0.1), source)), 2), paths, 0.05).v.values
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    assert low < np.mean(v[:, -1, 0] ** 2) / (0.1 * 0.05) < high
    rows = source.process(1, 1e-3).rows[:50, 0]
    np.testing.assert_allclose(v[:, 1:, 1], np.tile(np.cumsum(rows), (paths, 1)), atol=1e-12)


def test_sums_are_flat():
    a, b, c = WhiteNoise(0.1), Harmonic(1.0, 10.0), Harmonic(1.0, 20.0)
    assert (a + b + c).parts == (a, b, c)
    assert (a + (b + c)).parts == (a, b, c)
    assert Superposition([a + b, Superposition((c,))]).parts == (a, b, c)


def test_which_channels_are_integrable():
    white, sine = WhiteNoise(0.1), Harmonic(1.0, 10.0)
    assert all((white + sine).process(2, 1e-3).why_no_integrals(k) for k in (0, 1))
    assert not any((sine + recorded(axes=2)).process(2, 1e-3).why_no_integrals(k) for k in (0, 1))
    stacked = Stacked((white, sine, recorded()), (2, 1, 1)).process(4, 1e-3)
    assert [bool(stacked.why_no_integrals(k)) for k in range(4)] == [True, True, False, False]
    W, U = stacked.integrals(stacked.init(np.ones(2)), stacked.rows[0])
    assert W.shape == U.shape == (4,)
    assert (stacked.normals, stacked.initial_normals, stacked.random_start) == (2, 2, True)


def test_one_record_only():
    message = (
        "excitation: 2 records among its parts, expected at most one; add their values, or "
        "make them axes of one Record"
    )
    for excitation in (recorded() + recorded(), Stacked((recorded(), recorded()))):
        with pytest.raises(ParameterError) as refused:
            pushed(excitation, 2 if isinstance(excitation, Stacked) else 1)
        assert str(refused.value) == message


@pytest.mark.parametrize("other", [3, "noise", None, [WhiteNoise()]])
def test_what_is_no_excitation_is_not_added(other):
    with pytest.raises(ParameterError, match=r"Superposition parts: .*, expected an excitation"):
        WhiteNoise(0.1) + other
    with pytest.raises(ParameterError, match=r"Stacked parts: .*, expected an excitation"):
        Stacked((WhiteNoise(0.1), other))


def test_no_parts():
    for kind in (Superposition, Stacked):
        with pytest.raises(ParameterError, match=f"{kind.__name__} parts: none, expected one"):
            kind(())


def test_wrong_numbers_of_channels():
    two = (WhiteNoise(0.1), Harmonic(1.0, 10.0))
    with pytest.raises(ShapeError, match="Stacked channels: 3 numbers, expected 2 parts"):
        Stacked(two, (1, 1, 1))
    with pytest.raises(ParameterError, match="Stacked channels: 0, expected an integer >= 1"):
        Stacked(two, (1, 0))
    with pytest.raises(ParameterError, match="Stacked channels: 'x', expected an integer >= 1"):
        Stacked(two, "xy")
    with pytest.raises(ShapeError, match="Stacked: 4 channels, expected 3 channels"):
        pushed(Stacked(two, 2), 3)
    with pytest.raises(ShapeError, match="Harmonic amplitude"):
        pushed(WhiteNoise(0.1) + Harmonic([1.0, 2.0], 10.0), 3)
