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
    return {"finite-time": loop(), "asymptotic": loop(kappa=1.0)}


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
        few = abs(stats.skew(second - first)) / np.sqrt(PATHS) > 0.2
        of_interest = abs(got[0]) >= 0.01 * np.mean(first)
        apart = (got[1] > 0 or got[2] < 0) and of_interest
        one = result.sel(loop="asymptotic", metric=metric)
        assert one["carried_by_few"] == few
        assert one["significant"] == (apart and not few)


def test_medians_are_compared_by_the_sign_test(result):
    """By SciPy's binomial test at Bonferroni's level."""
    for metric in COMPARED:
        first, second = (result["values"].sel(loop=n, metric=metric).values for n in NAMES)
        change = second - first
        p = stats.binomtest(int(np.sum(change > 0)), int(np.sum(change != 0)) or 1).pvalue
        one = result.sel(loop="asymptotic", metric=metric)
        assert one["median_difference"].sel(bound="estimate") == np.sort(change)[PATHS // 2 - 1]
        if metric not in BINARY and np.all(change != 0):
            assert one["median_significant"] == (p < 0.05 / len(COMPARED))


NAMES = ("finite-time", "asymptotic")


def test_a_twin_is_not_run_twice(loops):
    found = compare({**loops, "twin": loop()}, 4, 0.1)
    assert found["loop"].values.tolist() == list(NAMES)
    assert found.attrs["same"] == "twin is the same as finite-time"
    assert "Not run twice: twin is the same as finite-time." in sentences(comparison_record(found))
    assert str(found["differs"].sel(loop="asymptotic").values) == "controller.gains.kappa"


def test_a_difference_that_is_of_no_interest_has_no_star():
    """A thousandth more of a gain: all paths differ in the same direction."""
    pair = {"one": loop(), "other": loop(c2=25.025)}
    strict, lax = (compare(pair, 64, 0.5, smallest=s).sel(loop="other") for s in (0.0, 0.01))
    assert strict["median_significant"].any()
    assert not lax["significant"].any()
    assert not lax["median_significant"].any()


def test_the_finite_time_law_follows_more_closely(result):
    """What the paper is about, significant with forty paths already."""
    one = result.sel(loop="asymptotic", metric="late_rms_error")
    assert one["significant"]
    assert one["median_significant"]
    assert one["median_difference"].sel(bound="low") > 0
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
    assert found["median_significant"].sel(loop="thrown", metric="late_rms_error")
    assert "not comparable" in sentences(comparison_record(found))[1]


def test_shares_are_compared_by_both_kinds_of_pairs_that_differ(result):
    """Of forty pairs, those of which one settles and the other does not, by SciPy's intervals."""
    first, second = (result["values"].sel(loop=n, metric="unsettled").values for n in NAMES)
    level = 1 - 0.05 / len(COMPARED) / 2
    more, less = (
        stats.binomtest(int(np.sum(sign * (second - first) > 0)), PATHS).proportion_ci(level)
        for sign in (1, -1)
    )
    got = result["difference"].sel(loop="asymptotic", metric="unsettled").values
    assert got[0] == pytest.approx(np.mean(second - first))
    np.testing.assert_allclose(got[1:], [more.low - less.high, more.high - less.low])
    same = result["difference"].sel(loop="finite-time", metric="unsettled").values
    assert same[1] < 0 < same[2]


class Thrown:
    """A law that always pushes with all its might."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
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
