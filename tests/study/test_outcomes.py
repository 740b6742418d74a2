"""What becomes of a path: by brute force from its full record, and in words."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    PaperPendulum,
    ParameterError,
    PDGravity,
    Sinusoid,
    Specification,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    printed,
    replay,
    simulate_paths,
    verify,
)
from ftcfa.loop.bounds import bounds_of
from ftcfa.report.ensemble import ensemble_record
from ftcfa.report.ensemble_text import _facts
from ftcfa.study.outcomes import BROKE, DIVERGED, KEPT, LOST, OUTCOMES

ARM = load_arm("double_pendulum", gravity=9.8)
SHAKEN = Vibration(BaseAcceleration("xz"), WhiteNoise(0.1))
RUNAWAY = ClosedLoop(
    ARM, printed(FTCF(ARM)), Sinusoid([1.5, 1.0], [1.0, 2.0]), SHAKEN, q0=[1.0, 1.0]
)
PATHS, DURATION = 24, 4.0


def told(loop, record, bounds):
    """Outcome, time, joint and share saturated before of each path, by brute force."""
    error, period = np.abs(record.q - record.q_d).values, loop.period
    q, v = record.q.values, record.v.values
    saturated = (np.abs(record.u_command) > np.abs(record.u)).any("joint").values
    outside = {
        LOST: error > bounds.error,
        BROKE: (q < bounds.lower) | (q > bounds.upper) | (np.abs(v) > bounds.velocity),
    }
    rows = []
    for i in range(len(q)):
        events = []
        for kind, beyond in outside.items():
            for joint in range(q.shape[2]):
                inside = np.flatnonzero(~beyond[i, :, joint])
                start = inside[-1] + 1 if len(inside) else 0
                if start < q.shape[1]:
                    events.append((start, kind, joint))
        if not events:
            rows.append((KEPT, np.nan, -1, np.nan))
            continue
        start, kind, joint = min(events)
        before = saturated[i, :start].mean() if start else np.nan
        rows.append((kind, start * period, joint, before))
    return np.array(rows).T


@pytest.mark.parametrize(
    "loop",
    [
        RUNAWAY,
        replace(RUNAWAY, controller=FTCF(ARM)),
        ClosedLoop(ARM, PDGravity(ARM, 3.0, 1.0), Constant([2.0, 2.0]), SHAKEN, q0=[0.0, 0.0]),
    ],
)
def test_outcomes_are_those_of_the_full_records(loop):
    loop = replace(loop, arm=replace(ARM, upper=np.array([1.9, np.inf])))
    result = ensemble(loop, PATHS, DURATION, lost=[0.5, 0.7])
    record = simulate_paths(loop, PATHS, DURATION, signals=["u_command"])
    bounds = bounds_of(loop.arm, [0.5, 0.7])
    outcome, time, joint, before = told(loop, record, bounds)
    np.testing.assert_array_equal(result.outcome, outcome)
    np.testing.assert_allclose(result.outcome_time, time, rtol=1e-12)
    np.testing.assert_array_equal(result.outcome_joint, joint)
    np.testing.assert_allclose(result.saturated_before, before, rtol=1e-12)
    beyond = (record.q > bounds.upper).values | (np.abs(record.v) > bounds.velocity).values
    first = beyond.any(axis=2).argmax(axis=1) * loop.period
    first = np.where(beyond.any(axis=(1, 2)), first, np.nan)
    np.testing.assert_allclose(result.limit_broken_at, first, rtol=1e-12)
    assert sum(result.attrs[name.replace(" ", "_")] for name in OUTCOMES) == PATHS


def test_a_runaway_is_lost_and_says_why():
    result = ensemble(RUNAWAY, PATHS, 8.0)
    assert result.attrs["lost_track"] + result.attrs["diverged"] == PATHS
    assert result.attrs["kept"] == 0
    assert "100 % of the paths fail; most lose track, first at joint" in result.diagnosis
    assert 'take anti_saturation = "bounded"' in result.diagnosis
    again = replay(result, 3)
    assert float(np.abs(again.rho).max()) == pytest.approx(float(result.largest_rho[3]))
    good = ensemble(replace(RUNAWAY, controller=FTCF(ARM)), PATHS, 8.0)
    assert (good.attrs["kept"], good.attrs["diagnosis"]) == (PATHS, "")
    assert np.isnan(good.outcome_time).all()


def test_a_weak_shoulder_is_named_with_its_gravity():
    weak = load_arm("panda", effort_limit={"panda_joint2": 5.0})
    law = FTCF(weak, compensation="bias")
    loop = ClosedLoop(weak, law, Constant([0.0, 1.2, 0.0, -1.0, 0.0, 1.5, 0.0]))
    result = ensemble(loop, 8, 3.0)
    gravity = abs(weak.potential_force(loop.reference.q)[1])
    assert result.attrs["kept"] == 0
    assert f"gravity on the reference needs {gravity:.3g} of 5 N m" in result.diagnosis
    assert "at joint 'panda_joint2'" in result.diagnosis


def test_a_path_that_diverges_is_named_so():
    strong = load_arm("double_pendulum", effort_limit=1e9)

    class Thrown(FTCF):
        def step(self, state, measured, desired, period):
            q = measured.q
            return {"u": 1e9 * np.ones_like(q)}, state

    result = ensemble(ClosedLoop(strong, Thrown(strong), Constant([0.0, 0.0])), 4, 0.5)
    np.testing.assert_array_equal(result.outcome, DIVERGED)
    np.testing.assert_array_equal(result.outcome_time, result.diverged_at)
    assert "most diverge" in result.diagnosis


def test_bounds_of_arms_without_limits_and_of_slides():
    assert bounds_of(PaperPendulum()).velocity == np.inf
    np.testing.assert_array_equal(bounds_of(PaperPendulum()).error, np.pi / 2)
    np.testing.assert_array_equal(bounds_of(ARM, 0.3).error, 0.3)


def test_a_specification_may_count_limits():
    """The paths are good, but a joint passes a limit that is drawn at a tenth of its swing."""
    narrow = replace(ARM, upper=np.array([0.2, np.inf]))
    loop = replace(RUNAWAY, arm=narrow, controller=FTCF(ARM), q0=[0.0, 0.0])
    told, counted = (
        verify(loop, Specification(0.3, 1.0, budget=256, limits=limits), 2.0)
        for limits in (False, True)
    )
    assert (told.answer, told.broke_limits) == ("yes", told.verdict.trials)
    assert f"{told.broke_limits} of these paths broke a limit of the URDF" in str(told)
    assert (counted.answer, counted.broke_limits) == ("no", 0)


RUN = """
duration = 8.0
paths = 16
q0 = [1.0, 1.0]
[arm]
robot = "double_pendulum"
[controller]
type = "FTCF"
anti_saturation = "paper"
[reference]
type = "Sinusoid"
amplitude = [1.5, 1.0]
angular_frequency = [1.0, 2.0]
"""


def test_the_command_line_says_what_became_of_the_paths(tmp_path):
    (tmp_path / "runaway.toml").write_text(RUN)
    run = subprocess.run(
        [sys.executable, "-m", "ftcfa", "run", "runaway.toml", "--out", "out"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    words = " ".join(run.stdout.split())
    assert "lost track 16, a share of 0.79 to 1: paths 0, 1, 2" in words
    assert "diagnosis 100 % of the paths fail; most lose track, first at joint" in words


class Overflowing(PDGravity):
    """PD whose command overflows at its sixth sample, and which then forgets that it ran."""

    def init(self, measured, desired):
        return np.zeros(1)

    def step(self, state, measured, desired, period):
        signals, _ = super().step((), measured, desired, period)
        huge = np.exp(np.where(state > 4.5, 1000.0, 0.0))  # infinite in double precision
        return {"u": signals["u"] * huge}, state + 1.0


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_samples_without_a_finite_torque_are_counted(engine):
    """It overflows at sample 5, waits for sample 6 to start anew, and overflows at 11, 17, ..."""
    loop = replace(RUNAWAY, controller=Overflowing(ARM))
    record = simulate_paths(loop, 3, 0.05, engine=engine, signals=["u_command"])
    without = ~np.isfinite(record.u_command).all("joint").values
    np.testing.assert_array_equal(np.flatnonzero(without[0]), np.arange(5, 51, 6))
    assert np.all(record.u.values[without] == 0.0)
    counted = ensemble(loop, 3, 0.05)
    np.testing.assert_array_equal(counted.without_torque, without.sum(axis=1))
    facts = dict(_facts(ensemble_record(counted, 3)))
    assert facts["no torque"].startswith("24 samples of 3 paths: the law asked for a torque that")


@pytest.mark.parametrize("lost", [-1.0, 0.0, [1.0, -1.0]])
def test_an_error_at_which_track_is_lost_is_positive(lost):
    with pytest.raises(ParameterError, match=r"lost: .*, expected numbers > 0"):
        ensemble(RUNAWAY, 2, 0.1, lost=lost)


def test_a_start_beyond_the_limits_fails_from_the_first_sample():
    loop = replace(RUNAWAY, arm=replace(ARM, upper=np.array([0.5, np.inf])), controller=FTCF(ARM))
    with pytest.warns(UserWarning, match="the start q0 is 1 rad at joint 'shoulder' at 0 s"):
        result = ensemble(loop, 4, 0.01)
    assert "first at joint 'shoulder', from 0 s on in the median: try" in result.diagnosis


def test_only_the_papers_law_has_a_printed_form():
    with pytest.raises(ParameterError, match=r"printed: a PDGravity, expected an FTCF\(arm\)"):
        printed(PDGravity(ARM))
