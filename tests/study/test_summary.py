"""The summary of an ensemble against plain NumPy and SciPy on the full record of its paths."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from scipy import signal, stats

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    ParameterError,
    Sinusoid,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    replay,
    settled_in_mean_square,
    settling,
    simulate_paths,
)
from ftcfa.statistics.quantile_sketch import RELATIVE_ACCURACY

PATHS, DURATION, EVERY, CHUNK = 90, 0.8, 20, 32
TOLERANCE, AFTER = 0.05, 0.3
ROUNDING = 1e-9
"""Sums in another order; relative."""
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
LARGEST = 1e4
"""A path beyond this has diverged, by the definition of the loop [rad or rad/s]."""


@cache
def pendulum():
    """The paper's, which starts away from its reference and saturates."""
    arm = load_arm("double_pendulum")
    return ClosedLoop(
        arm,
        FTCF(arm),
        Sinusoid((1.5, 1.0), (1.0, 2.0)),
        Vibration(BaseAcceleration("xz"), WhiteNoise(0.1)),
        q0=(-0.1, 0.25),
        v0=(-0.3, 0.45),
    )


class NoLaw:
    """No torque: what shakes alone decides."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
        return {"u": 0.0 * q}, state


@cache
def shaken_apart():
    """A pendulum shaken so hard that some of its paths leave every bound."""
    arm = load_arm("double_pendulum")
    return ClosedLoop(
        arm, NoLaw(), Constant([0.0, 0.0]), Vibration(BaseAcceleration("xz"), WhiteNoise(1e7))
    )


@pytest.fixture(scope="module")
def dataset():
    return ensemble(
        pendulum(), PATHS, DURATION, seed=3, record_every=EVERY, tolerance=TOLERANCE, after=AFTER,
        chunk=CHUNK,
    )  # fmt: skip


@pytest.fixture(scope="module")
def record():
    """Every sample of every path."""
    return simulate_paths(pendulum(), PATHS, DURATION, seed=3, signals=["u_command"])


def kept(record):
    return record.isel(time=slice(None, None, EVERY))


@pytest.mark.filterwarnings("ignore:Precision loss")  # of SciPy, where all torques are at the limit
@pytest.mark.parametrize("name", ["ote", "error", "u"])
def test_means_and_mean_squares_with_students_interval(dataset, record, name):
    values = {"ote": record.ote, "error": record.q - record.q_d, "u": record.u}[name]
    x = values.isel(time=slice(None, None, EVERY)).transpose("path", "time", ...).values
    estimate, low, high = dataset[f"{name}_mean"].values
    np.testing.assert_allclose(estimate, x.mean(axis=0), rtol=ROUNDING, atol=1e-12)
    t = stats.ttest_1samp(x[:, 1:], 0.0).confidence_interval(0.95)
    np.testing.assert_allclose(low[1:], t.low, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(high[1:], t.high, rtol=1e-6, atol=1e-9)
    square, low, high = dataset[f"{name}_mean_square"].values
    np.testing.assert_allclose(square, (x**2).mean(axis=0), rtol=ROUNDING, atol=1e-15)
    assert np.all((low <= square) & (square <= high))
    not_diverged = dataset[f"{name}_mean_square_not_diverged"].values[0]
    np.testing.assert_array_equal(not_diverged, square)  # none has diverged


def test_quantiles_to_the_accuracy_of_the_sketch(dataset, record):
    for name, values in (("ote", record.ote), ("u", record.u)):
        x = values.isel(time=slice(None, None, EVERY)).transpose("path", "time", ...).values
        ordered = np.sort(x, axis=0)
        n = len(x)
        for p, found in zip(LEVELS, dataset[f"{name}_quantile"].values[0], strict=True):
            exact = ordered[int(np.ceil(n * p)) - 1]
            np.testing.assert_allclose(found, exact, rtol=RELATIVE_ACCURACY, atol=1e-8)
        median = LEVELS.index(0.5)
        low, high = dataset[f"{name}_quantile"].values[1:, median]
        ranks = stats.binom.ppf([0.025, 0.975], n, 0.5).astype(int)
        slack = RELATIVE_ACCURACY * 2 * np.abs(ordered[[ranks[0] - 1, ranks[1]]]) + 1e-8
        assert np.all(np.abs(low - ordered[ranks[0] - 1]) <= slack[0])
        assert np.all(np.abs(high - ordered[ranks[1]]) <= slack[1])


def settled_since(ote, tolerance):
    """Index of the first sample after the last one outside, or None."""
    outside = np.flatnonzero(ote > tolerance)
    first = outside[-1] + 1 if outside.size else 0
    return first if first < len(ote) else None


def test_settling_and_errors_since_by_their_definition(dataset, record):
    time = record.time.values
    assert np.isfinite(dataset.settling_time).sum() > PATHS / 2
    for path, ote in zip(dataset.path.values, record.ote.values, strict=True):
        found, first = dataset.sel(path=path), settled_since(ote, TOLERANCE)
        if first is None:
            assert float(found.settling_time) == np.inf
            assert np.isnan(found.rms_error)
            assert np.isnan(found.peak_error)
            continue
        assert float(found.settling_time) == pytest.approx(time[first])
        assert float(found.rms_error) == pytest.approx(np.sqrt(np.mean(ote[first:] ** 2)))
        assert float(found.peak_error) == pytest.approx(ote[first:].max())


def above_20_hz(u, h):
    """Torques behind the first-order high-pass y' = u' - 2 pi 20 Hz y, changes at the samples."""
    kept = np.exp(-2 * np.pi * 20.0 * h)
    changes = u.diff("time").pad(time=(1, 0), constant_values=0.0)
    values = signal.lfilter([kept], [1.0, -kept], changes.values, axis=u.get_axis_num("time"))
    return u.copy(data=values)


def test_other_metrics_by_their_definition(dataset, record):
    h = 1e-3
    error, u, v = ((record.q - record.q_d), record.u, record.v)
    late = record.ote.where(record.time >= AFTER - h / 2, drop=True)
    change = u.diff("time")
    first = error.isel(time=0)
    other_side = (-np.sign(first) * error).max("time").clip(min=0.0)
    expected = {
        "late_rms_error": np.sqrt((late**2).mean("time")),
        "late_peak_error": late.max("time"),
        "overshoot": other_side,
        "saturated": (np.abs(record.u_command) > np.abs(u)).any("joint").mean("time"),
        "peak_torque": np.abs(u).max("time"),
        "rms_torque": np.sqrt((u**2).mean("time")),
        "peak_torque_rate": np.abs(change).max("time") / h,
        "rms_torque_rate": np.sqrt((change**2).mean("time")) / h,
        "rms_wanted_rate": np.sqrt((change**2).mean("time")) / h,  # ideal motors
        "rate_limited": 0.0 * u.isel(time=0),
        "oscillation": np.sqrt((above_20_hz(u, h) ** 2).mean("time")),
        "energy": np.abs(u * v).sum(("time", "joint")) * h,
    }
    for name, values in expected.items():
        found = dataset[name]
        np.testing.assert_allclose(found, values.transpose(*found.dims), rtol=1e-8, atol=1e-12)
    assert 0 < float(dataset.saturated.min()) < float(dataset.saturated.max()) < 1
    assert float(dataset.overshoot.max()) > 0


def test_every_variable_has_units_and_the_whole_says_how_to_run_it_again(dataset):
    assert all("units" in dataset[name].attrs for name in dataset.data_vars)
    assert dataset.ote_mean_square.attrs["units"] == "rad^2"
    assert dataset.u_mean_square.attrs["units"] == "(N m)^2"
    path = int(dataset.path[np.argmax(dataset.late_peak_error.values)])
    again = replay(dataset, path)
    late = again.ote.where(again.time >= AFTER - 5e-4, drop=True)
    assert float(late.max()) == pytest.approx(float(dataset.late_peak_error.max()))


def test_a_loop_of_ones_own_is_asked_for_where_it_is_to_be_replayed(half_diverged):
    with pytest.raises(ParameterError, match="give loop=, the loop that ran"):
        replay(half_diverged, 0)
    path = int(np.flatnonzero(np.isnan(half_diverged.diverged_at.values))[0])
    again = replay(half_diverged, path, loop=shaken_apart())
    late = again.ote.where(again.time >= 0.15 - 5e-4, drop=True)
    assert float(late.max()) == pytest.approx(float(half_diverged.late_peak_error[path]))


def test_variables_are_in_one_order_wherever_chunks_come_from(dataset, tmp_path):
    def run():
        return ensemble(
            pendulum(), PATHS, DURATION, seed=3, record_every=EVERY, tolerance=TOLERANCE,
            after=AFTER, chunk=CHUNK, store=tmp_path / "store",
        )  # fmt: skip

    for again in (run(), run()):  # computed, then read
        assert list(again.data_vars) == list(dataset.data_vars)
        xr.testing.assert_identical(again, dataset)


def test_settling_is_the_empirical_distribution_up_to_the_end(dataset):
    found = settling(dataset)
    times = dataset.settling_time.values
    assert found.settled == np.isfinite(times).sum()
    assert found.censored == PATHS - found.settled
    assert found.diverged == 0
    for time, share in zip(found.time, found.share.value, strict=True):
        assert share == pytest.approx(np.mean(times <= time))


@pytest.mark.parametrize("settles", [True, False])
def test_the_band_where_all_or_none_have_settled_is_the_exact_one(settles):
    """Greenwood's has no value there; 0.025^(1/n) is Clopper and Pearson's."""
    n, end = 50, 5.0
    times = np.full(n, 0.0 if settles else np.inf)
    dataset = xr.Dataset(
        {"settling_time": ("path", times), "diverged_at": ("path", np.full(n, np.nan))},
        attrs={"duration": end, "confidence": 0.95},
    )
    found = settling(dataset)
    bound = 0.025 ** (1 / n)
    if settles:
        assert found.share.low[0] == pytest.approx(bound)
        assert tuple(map(float, found.quantile(0.9))) == (0.0, 0.0, 0.0)
    else:
        assert found.share.high[-1] == pytest.approx(1 - bound)
        assert float(found.quantile(0.5).low) == np.inf


def test_definition_1_is_read_off_the_upper_bound(dataset):
    upper, time = dataset.ote_mean_square.values[2], dataset.time.values
    for epsilon in (TOLERANCE**2, 1e-3):
        reached = settled_in_mean_square(dataset, epsilon)
        assert np.all(upper[time >= reached] < epsilon)
        assert upper[time < reached][-1] >= epsilon
    assert np.isnan(settled_in_mean_square(dataset, upper[-1] / 2))


@pytest.fixture(scope="module")
def half_diverged():
    return ensemble(shaken_apart(), 64, 0.3, seed=1, record_every=50, chunk=16)


def test_paths_that_diverged_are_counted_and_make_means_undefined(half_diverged):
    full = simulate_paths(shaken_apart(), 64, 0.3, seed=1)
    speed = np.abs(full.v).max("joint")
    diverged = np.isfinite(half_diverged.diverged_at.values)
    assert 0 < diverged.sum() < 64
    assert half_diverged.attrs["diverged"] == diverged.sum()
    np.testing.assert_array_equal(diverged, np.isnan(speed.isel(time=-1)))
    last = half_diverged.isel(time=-1)
    assert np.all(np.isnan(last.ote_mean_square))
    others = full.ote.values[~diverged, -1]
    assert float(last.ote_mean_square_not_diverged[0]) == pytest.approx(np.mean(others**2))
    assert float(last.ote_mean_not_diverged[0]) == pytest.approx(np.mean(others))
    ordered = np.sort(np.where(diverged, np.inf, full.ote.values[:, -1]))
    for p, found in zip(LEVELS, last.ote_quantile.values[0], strict=True):
        exact = ordered[int(np.ceil(64 * p)) - 1]
        assert found == pytest.approx(exact, rel=RELATIVE_ACCURACY)
    for name in ("settling_time", "energy", "late_rms_error"):
        assert np.all(np.isnan(half_diverged[name].values[diverged]))
    assert settling(half_diverged).diverged == diverged.sum()
    assert np.isnan(settled_in_mean_square(half_diverged, 1e12))
