"""The final of a search: what paired intervals tell apart leaves, and the answer says how sure."""

import numpy as np
import pytest

from ftcfa import ComputedTorque, Objective, Term, compare
from ftcfa.study.plan import Plan
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.trial import FINAL_STAGES, Trial

from .loops import ARM, loop

ERROR = Objective((Term("late_rms_error", 1.0, "mean"),))
SPACE = {"controller.position_rate": (1.0, 30.0), "controller.velocity_rate": (1.0, 30.0)}


@pytest.fixture
def trial():
    it = loop(ComputedTorque(ARM, 3.0, 5.0))
    return Trial(it, Plan(0.3), ERROR, Space(it, SPACE))


def test_a_clear_winner_is_chosen_after_the_first_stage(trial):
    points = np.array([[0.9, 0.9], [0.1, 0.1]])
    final = trial.final(points, 100, 8)
    np.testing.assert_array_equal(final.point, points[0])
    assert final.paths == 8
    low, high = final.less
    assert 0 < low < final.cost_given - final.cost < high


def test_candidates_alike_run_all_stages(trial):
    points = np.array([[0.9, 0.9], [0.9, 0.9]])
    final = trial.final(points, 100, 4)
    assert final.paths == 4 << (FINAL_STAGES - 1)


def test_cost_and_interval_are_those_of_a_comparison_on_the_same_paths(trial):
    point = np.array([0.5, 0.5])
    final = trial.final(point[None], 0, 16)
    it, better = trial.loop, trial.space.loop_at(trial.loop, point)
    found = compare({"given": it, "better": better}, final.paths, 0.3)
    means = found["mean"].sel(metric="late_rms_error", bound="estimate").values
    assert [final.cost_given, final.cost] == pytest.approx(means.tolist(), rel=1e-9)
    values = found["values"].sel(metric="late_rms_error").values
    difference = values[0] - values[1]
    half = 2.13 * difference.std(ddof=1) / np.sqrt(final.paths)  # Student, 15 degrees of freedom
    ends = [difference.mean() - half, difference.mean() + half]
    assert final.less == pytest.approx(ends, abs=half / 2)
