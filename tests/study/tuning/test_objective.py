"""Costs, limits, and the order of candidates."""

import numpy as np
import pytest

from ftcfa import ClosedLoop, Limit, Objective, Term
from ftcfa.errors import FtcfaError
from ftcfa.study.tuning.objective import STATISTICS, Score, default_objective

from .loops import loop

RATE = "rms_torque_rate"


def values(errors, rates, failed=0.0):
    errors = np.asarray(errors, dtype=float)
    return {
        "late_rms_error": errors,
        RATE: np.broadcast_to(np.asarray(rates, dtype=float), errors.shape),
        "failed": np.broadcast_to(failed, errors.shape),
    }


def test_statistics_are_what_they_say():
    x = np.random.default_rng(1).permutation(np.arange(1.0, 101.0))
    found = {name: float(of(x)) for name, of in STATISTICS.items()}
    assert found == {"mean": 50.5, "median": 50.5, "q95": 96.0, "cvar95": 98.0, "largest": 100.0}


def test_the_cost_is_the_weighted_sum():
    it = Objective((Term("late_rms_error", 2.0, "mean"), Term(RATE, 0.1, "largest")))
    score = it.score(values([[1.0, 3.0]], [10.0, 30.0]), values([0.0], 0.0))
    assert score.cost.tolist() == [2.0 * 2.0 + 0.1 * 30.0]
    assert score.excess.tolist() == [0.0]


def test_a_limit_counts_before_any_cost():
    it = Objective((Term("late_rms_error", 1.0, "mean"),), (Limit(RATE, 10.0),))
    rows = values([[1.0], [5.0], [0.1]], [[20.0], [10.0], [15.0]])
    score = it.score(rows, values([0.0], 0.0))
    np.testing.assert_allclose(score.excess, [1.0, 0.0, 0.5])
    assert score.order.tolist() == [1, 2, 0]
    assert it.broken({name: x[2] for name, x in rows.items()}, values([0.0], 0.0)) == (
        "rms_torque_rate (mean) 15 N m/s, at most 10",
    )


def test_a_limit_without_a_number_is_that_of_the_loop_as_given():
    it = Objective((Term("late_rms_error"),), (Limit(RATE),))
    score = it.score(values([[1.0]], [[20.0]]), values([1.0], 16.0))
    np.testing.assert_allclose(score.excess, [0.25])


def test_a_share_of_one_percent_is_none():
    assert Limit("saturated").most({"saturated": np.zeros(3)}) == 0.01
    assert Limit("saturated", 0.0).most({"saturated": np.zeros(3)}) == 0.0


def test_a_path_that_diverged_is_the_worst_and_lost_paths_come_before_all():
    it = Objective((Term("late_rms_error"),), (Limit(RATE, 10.0),), kept=0.5)
    rows = values([[np.nan, 1.0], [1.0, 1.0]], [[np.nan, 1.0], [50.0, 50.0]], [[1.0], [0.0]])
    score = it.score(rows, values([0.0, 0.0], 0.0))
    assert np.isinf(score.cost[0])
    assert score.order.tolist() == [1, 0]


def test_order_of_equal_excess_is_that_of_the_cost():
    score = Score(np.array([0.0, 0.0, 1.0]), np.array([3.0, 2.0, 1.0]))
    assert score.order.tolist() == [1, 0, 2]


def test_the_default_knows_the_driver():
    assert "rate_limited" not in default_objective(loop()).metrics
    from ftcfa import Actuators, Hardware

    limited = loop(hardware=Hardware(actuators=Actuators(rate_limit=100.0)))
    assert "rate_limited" in default_objective(limited).metrics
    assert isinstance(limited, ClosedLoop)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Term("rms"), "unknown name|did you mean|expected one of"),
        (lambda: Term("late_rms_error", -1.0), "Term weight: -1.0, expected a number > 0"),
        (lambda: Term("late_rms_error", 1.0, "q50"), "statistic"),
        (lambda: Limit(RATE, -1.0), "Limit at_most: -1.0, expected a number >= 0"),
        (lambda: Objective(()), "Objective terms: none, expected one Term or more"),
        (lambda: Objective((Term("energy"),), kept=1.5), "Objective kept: 1.5, expected a share"),
    ],
)
def test_wrong_ones_are_refused(make, message):
    with pytest.raises(FtcfaError, match=message):
        make()
