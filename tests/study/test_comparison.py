"""compare: the same noise for all, differences in pairs, paths that diverged never left out."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Gains,
    ParameterError,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    printed,
    simulate_paths,
)
from ftcfa.report.comparison import comparison_record, sentences
from ftcfa.study.comparison import BINARY, compare
from ftcfa.study.metrics.compared import COMPARED

PATHS, DURATION = 40, 1.0
ARM = load_arm("double_pendulum", gravity=9.8)


def loop(**gains):
    return ClosedLoop(
        ARM,
        printed(FTCF(ARM, Gains(**gains))),
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        Vibration(BaseAcceleration("xz"), WhiteNoise(0.1)),
        q0=[-0.1, 0.25],
        v0=[-0.3, 0.45],
    )


@pytest.fixture(scope="module")
def loops():
    return {"finite-time": loop(), "asymptotic": loop(kappa=1.0), "twin": loop()}


@pytest.fixture(scope="module")
def result(loops):
    return compare(loops, PATHS, DURATION, seed=3, after=0.8)


@pytest.fixture(scope="module")
def records(loops):
    return [simulate_paths(one, PATHS, DURATION, seed=3) for one in loops.values()]


def test_metrics_are_those_of_the_full_records(loops, result, records):
    for name, record in zip(loops, records, strict=True):
        late = record.ote.sel(time=slice(0.8 - 1e-9, None))
        outside = record.ote > 0.05
        last = outside.isel(time=slice(None, None, -1)).argmax("time")
        settling = np.where(outside.any("time"), (1001 - last) * 1e-3, 0.0)
        settling = np.minimum(settling, DURATION)
        u, v = record.u.values, record.v.values
        share = np.sqrt(np.mean(u**2, axis=1)) / ARM.effort_limit
        rate = np.sqrt(np.mean(np.diff(u, axis=1) ** 2, axis=1)) / 1e-3 / ARM.effort_limit
        expected = {
            "settling_time": settling,
            "late_rms_error": np.sqrt((late**2).mean("time")),
            "late_peak_error": late.max("time"),
            "late_mean_square_error": (late**2).mean("time"),
            "effort": np.sqrt(np.mean(share**2, axis=1)),
            "torque_rate": np.sqrt(np.mean(rate**2, axis=1)),
            "energy": np.abs(u * v).sum(axis=(1, 2)) * 1e-3,
        }
        for metric, values in expected.items():
            got = result["values"].sel(loop=name, metric=metric)
            np.testing.assert_allclose(got, values, rtol=1e-9, err_msg=metric)


def test_differences_are_paired_and_hold_together(result):
    """Near SciPy's paired t interval at Bonferroni's level, which knows of no skewness."""
    together = 1 - 0.05 / (2 * len(COMPARED))
    for metric in COMPARED:
        if metric in BINARY:
            continue
        first, second = (result["values"].sel(loop=n, metric=metric).values for n in NAMES)
        if np.ptp(second - first) == 0:
            continue
        interval = stats.ttest_rel(second, first).confidence_interval(together)
        got = result["difference"].sel(loop="asymptotic", metric=metric).values
        width = interval.high - interval.low
        np.testing.assert_allclose(got[1:], interval, rtol=0, atol=0.5 * width)
        assert got[0] == pytest.approx(np.mean(second - first))
        excludes_zero = got[1] > 0 or got[2] < 0
        assert result["significant"].sel(loop="asymptotic", metric=metric) == excludes_zero


NAMES = ("finite-time", "asymptotic")


def test_a_twin_differs_in_nothing(result):
    twin = result.sel(loop="twin")
    np.testing.assert_array_equal(twin["difference"], 0.0)
    assert not twin["significant"].any()
    assert str(twin["differs"].values) == ""
    assert str(result["differs"].sel(loop="asymptotic").values) == "controller.gains.kappa"


def test_the_finite_time_law_settles_sooner(result):
    """What the paper is about, significant with forty paths already."""
    one = result.sel(loop="asymptotic", metric="settling_time")
    assert one["significant"]
    assert one["difference"].sel(bound="low") > 0
    assert result["settled"].sel(loop="finite-time") == PATHS


def test_a_path_that_diverged_is_the_worst_of_all(loops):
    strong = load_arm("double_pendulum", effort_limit=1e9)
    free = replace(loops["finite-time"], arm=strong, controller=Thrown())
    found = compare({"sound": loops["finite-time"], "thrown": free}, 16, 0.5)
    assert found["diverged"].values.tolist() == [0, 16]
    per_path = [metric for metric in COMPARED if metric not in BINARY]
    assert np.all(np.isnan(found["mean"].sel(loop="thrown", metric=per_path)))
    assert np.all(np.isinf(found["quantiles"].sel(loop="thrown", metric=per_path)))
    difference = found["difference"].sel(loop="thrown", metric="diverged")
    assert difference.sel(bound="estimate") == 1.0
    assert found["significant"].sel(loop="thrown", metric="diverged")
    assert not found["significant"].sel(metric=per_path).any()
    assert "not comparable" in sentences(comparison_record(found))[1]


def test_shares_are_compared_by_mcnemars_exact_test(result):
    """Of forty pairs, those of which one settles and the other does not."""
    first, second = (result["values"].sel(loop=n, metric="unsettled").values for n in NAMES)
    more, less = np.sum(second > first), np.sum(second < first)
    p = stats.binomtest(int(more), int(more + less)).pvalue
    got = result["difference"].sel(loop="asymptotic", metric="unsettled").values
    assert got[0] == pytest.approx(np.mean(second - first))
    assert (p < 0.05 / (2 * len(COMPARED))) == (got[1] > 0)


class Thrown:
    """A law that always pushes with all its might."""

    def init(self, q, v, desired):
        return ()

    def step(self, state, q, v, desired, period):
        return {"u": 1e9 * np.ones_like(q)}, state


@pytest.mark.parametrize("count", [0, 1])
def test_one_loop_cannot_be_compared(count):
    with pytest.raises(ParameterError, match=f"compare: {count} loops, expected two or more"):
        compare(dict(list({"a": loop()}.items())[:count]), 2, 0.1)


def test_loops_have_the_same_joints():
    other = load_arm("ur5")
    far = ClosedLoop(other, FTCF(other), Sinusoid(offset=other.home))
    with pytest.raises(ParameterError, match="arms of different joints"):
        compare({"a": loop(), "b": far}, 2, 0.1)
