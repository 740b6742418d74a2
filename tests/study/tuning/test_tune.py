"""Searches: their answers, their honesty, and that they go on where they were stopped."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    ComputedTorque,
    Experiment,
    Gains,
    Limit,
    Objective,
    Term,
    ensemble,
    front,
    gain_shortfall,
    sensitivity,
    simulate_paths,
    tune,
)
from ftcfa.errors import FtcfaError
from ftcfa.study.plan import Plan
from ftcfa.study.progress import Interrupted
from ftcfa.study.tuning import tune as module
from ftcfa.study.tuning.result import FRESH
from ftcfa.study.tuning.space import Space
from ftcfa.study.tuning.trial import Trial

from .loops import ARM, BUDGET, SHAKEN, Spring, loop, paper

ERROR = Objective((Term("late_rms_error", 1.0, "mean"),))


def trial(it, objective=ERROR, duration=0.3, **options):
    return Trial(it, Plan(duration), objective, Space(it, options.pop("space", None)), **options)


def test_a_candidate_has_the_metrics_of_an_ensemble_with_its_gains():
    it = loop()
    one = trial(it)
    points = np.array([[0.3, 0.4], [0.6, 0.7]])
    found = one.metrics(points, range(3, 8))
    for row, point in enumerate(points):
        own = ensemble(one.space.loop_at(it, point), 8, 0.3)
        np.testing.assert_allclose(found["late_rms_error"][row], own.late_rms_error[3:8], rtol=1e-9)


def test_a_race_keeps_the_order_of_the_better_half():
    it = loop()
    one = trial(it)
    points = np.random.default_rng(0).uniform(size=(8, 2))
    race, all_paths = one.raced(points, range(16)), one.metrics(points, range(16))
    whole = all_paths["late_rms_error"].mean(axis=1)
    assert race.order[0] == np.argmin(whole)
    last = race.stage == race.stage.max()
    assert last.sum() == 2
    np.testing.assert_allclose(race.score.cost[last], whole[last], rtol=1e-9)


def test_it_finds_the_best_gains_of_a_law_that_has_one_number():
    """A spring on a still, certain robot: the error over the stiffness is known on a grid."""
    law = Spring(ARM, damping=20.0)
    it = loop(law, vibration=None, uncertainty=None)
    names = {"controller.stiffness": (1.0, 1000.0)}
    grid = np.geomspace(1.0, 1000.0, 200)
    paths = simulate_paths(it, len(grid), 1.0, vary={"controller.stiffness": grid})
    late = np.sqrt((paths.ote.sel(time=slice(0.5, None)) ** 2).mean("time")).values
    found = tune(it, 1.0, ERROR, names, generations=12, candidates=8, paths=1)
    assert found.cost == pytest.approx(np.nanmin(late), rel=0.02)


def test_tuned_gains_do_better_on_paths_that_the_search_never_saw():
    median = Objective((Term("late_rms_error", 1.0, "median"),))
    found = tune(loop(), 1.0, median, generations=8, candidates=8, paths=8)
    fresh = found.validate(100)
    assert found.answer == "yes"
    change = fresh["median_difference"].sel(loop="tuned", metric="late_rms_error")
    assert change.sel(bound="high") < 0
    assert fresh.attrs["seed"] == FRESH
    assert fresh.attrs["cost"] == pytest.approx(found.cost, rel=0.3)
    own = ensemble(found.loop, 100, 1.0, seed=FRESH).late_rms_error.median()
    assert fresh.attrs["cost"] == pytest.approx(float(own), rel=1e-9)


def test_the_same_seed_gives_the_same_gains_and_another_one_others():
    first, again, other = (tune(loop(), 0.3, ERROR, seed=seed, **BUDGET) for seed in (1, 1, 2))
    assert first.gains == again.gains
    assert first.gains != other.gains
    np.testing.assert_array_equal(first.history.cost, again.history.cost)


def test_stopped_and_resumed_it_ends_as_if_it_had_not_been(tmp_path):
    whole = tune(loop(), 0.3, ERROR, **BUDGET)

    def stop(done, _):
        if done == 2:
            raise KeyboardInterrupt

    file = tmp_path / "search.json"
    with pytest.raises(Interrupted) as caught:
        tune(loop(), 0.3, ERROR, store=file, progress=stop, **BUDGET)
    assert caught.value.partial.history.sizes["generation"] == 2
    assert len(json.loads(file.read_text())["rows"]) == 2
    resumed = tune(loop(), 0.3, ERROR, store=file, **BUDGET)
    assert resumed.gains == whole.gains
    np.testing.assert_array_equal(resumed.history.cost, whole.history.cost)


def test_a_resumed_search_runs_no_path_again(tmp_path, monkeypatch):
    file = tmp_path / "search.json"
    whole = tune(loop(), 0.3, ERROR, store=file, **BUDGET)
    monkeypatch.setattr(Trial, "raced", None)
    assert tune(loop(), 0.3, ERROR, store=file, **BUDGET).gains == whole.gains


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[]", "not the file of a search"),
        ("{", "not the file of a search"),
        ('{"identity": {}, "rows": []}', "of another search: .*loop.* differ"),
        ('{"identity": {}, "rows": [{"cost": ["x"]}]}', "not the file of a search"),
    ],
)
def test_the_file_of_another_search_is_refused(tmp_path, content, message):
    file = tmp_path / "search.json"
    file.write_text(content)
    with pytest.raises(FtcfaError, match=message):
        tune(loop(), 0.3, ERROR, store=file, **BUDGET)
    assert file.read_text() == content


def test_an_impossible_objective_is_answered_with_what_was_tried():
    impossible = Objective((Term("late_rms_error"),), (Limit("rms_torque_rate", 1e-6),))
    found = tune(loop(), 0.3, impossible, **BUDGET)
    assert found.answer == "no"
    assert found.excess > 0
    assert found.sentence.startswith(
        "no: none of 18 candidates of 2 numbers keeps the limits. The "
    )
    assert "rms_torque_rate (mean)" in found.sentence
    assert "at most 1e-06" in found.sentence


def test_where_everything_is_lost_it_says_so():
    it = loop(Spring(ARM, 1.0, 0.1), q0=[2.0, 2.0], vibration=replace(SHAKEN, level=50.0))
    found = tune(it, 0.5, Objective((Term("late_rms_error"),)), lost=1e-6, **BUDGET)
    assert found.answer == "no"
    assert "100.0% of the paths are lost, at most 0.0%" in found.sentence


def test_a_condition_of_ones_own_holds():
    def slow(it):
        return it.controller.position_rate - 5.0

    found = tune(loop(), 0.3, ERROR, condition=slow, generations=5, candidates=8, paths=4)
    assert found.loop.controller.position_rate <= 5.0


def test_gains_that_are_best_already_stay():
    best = tune(loop(), 0.3, ERROR, generations=10, candidates=8, paths=4)
    names = {"controller.position_rate": (0.3, 0.31), "controller.velocity_rate": (1.0, 1.01)}
    again = tune(best.loop, 0.3, ERROR, names, **BUDGET)
    assert again.point is None
    assert again.loop is best.loop
    assert "none of 18 candidates of 2 numbers is better" in again.sentence
    assert again.validate(4).sizes["loop"] == 1


def test_the_paper_s_law_is_tuned_joint_by_joint_and_saved(tmp_path):
    from ftcfa import joint_by_joint, load_experiment

    it = joint_by_joint(paper())
    found = tune(it, 0.2, ERROR, generations=2, candidates=4, paths=2)
    assert np.shape(found.loop.controller.gains.c1) == (2,)
    file = tmp_path / "tuned.toml"
    space = {"controller.gains.c1": (1.0, 9.0)}
    Experiment(found.loop, 1.0, objective=ERROR, space=space).save(file)
    again = load_experiment(file)
    np.testing.assert_array_equal(again.loop.controller.gains.c1, found.loop.controller.gains.c1)
    assert again.objective == ERROR
    assert tuple(again.space["controller.gains.c1"]) == (1.0, 9.0)


def test_a_front_is_in_order_and_nobody_beats_anybody():
    terms = (Term("late_rms_error"), Term("rms_torque_rate", 1.0, "mean"))
    found = front(loop(), 0.3, terms, generations=3, candidates=12, paths=4)
    error, rate = found["first"].values, found["second"].values
    assert len(error) > 2
    assert np.all(np.diff(error) > 0)
    assert np.all(np.diff(rate) < 0)
    again = front(loop(), 0.3, terms, generations=3, candidates=12, paths=4)
    np.testing.assert_array_equal(error, again["first"])
    with pytest.raises(FtcfaError, match="front terms: 1 terms, expected two"):
        front(loop(), 0.3, terms[:1])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"generations": 0}, "tune generations: 0, expected an integer >= 1"),
        ({"candidates": 3}, "tune candidates: 3, expected 4 or more"),
        ({"paths": 0.5}, "tune paths: 0.5, expected an integer >= 1"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"after": 9.0}, "after: 9.0, expected a number from 0 to below the 0.3 s"),
        ({"seed": -1}, "seed"),
        ({"space": {}}, "tune space: nothing"),
    ],
)
def test_wrong_arguments_are_refused(options, message):
    with pytest.raises(FtcfaError, match=message):
        tune(loop(), 0.3, ERROR, **{**BUDGET, **options})
    with pytest.raises(FtcfaError, match=r"tune: a ComputedTorque, expected a ClosedLoop"):
        tune(ComputedTorque(ARM), 0.3)


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "cmaes", None)
    with pytest.raises(FtcfaError, match=r'cmaes is not installed.*pip install "ftcfa\[tune\]"'):
        module.tune(loop(), 0.3, ERROR, **BUDGET)


def test_sensitivity_is_what_a_change_of_one_gain_does():
    it = loop()
    found = sensitivity(it, 0.3, ERROR, paths=8)
    assert found.sizes == {"parameter": 2, "factor": 13}
    for name, position, velocity in (("position", 3.0 * 2.0, 5.0), ("velocity", 3.0, 10.0)):
        own = ensemble(replace(it, controller=ComputedTorque(ARM, position, velocity)), 8, 0.3)
        cost = found.cost.sel(parameter=f"controller.{name}_rate").sel(factor=2.0, method="nearest")
        assert float(cost) == pytest.approx(float(own.late_rms_error.mean()), rel=1e-9)


def test_the_theorem_s_conditions_can_be_asked_for():
    """k1 >= 3/2 w_s/(w_s - 1/4): a search is free to go below, but is not wanted there."""
    assert gain_shortfall(paper()) == 0.0
    assert gain_shortfall(loop(FTCF(ARM, Gains(k1=1.0)))) > 0.0
    space = {"controller.gains.k1": (0.1, 10.0), "controller.gains.k2": (0.01, 10.0)}
    found = tune(paper(), 0.2, ERROR, space, condition=gain_shortfall, **BUDGET)
    assert gain_shortfall(found.loop) == 0.0
    assert found.answer == "yes"
    with pytest.raises(FtcfaError, match="the only law that Theorem 1 covers"):
        gain_shortfall(loop())
