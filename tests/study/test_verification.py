"""`verify`: yes, no and undecided, and what it counts, against plain NumPy on full records."""

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ParameterError,
    ShapeError,
    Sinusoid,
    Specification,
    Vibration,
    WhiteNoise,
    load_arm,
    printed,
    simulate,
    simulate_paths,
    verify,
)
from ftcfa.statistics.proportions import proportion
from ftcfa.study.verification import CHUNK

DURATION = 0.8
TIGHT = Specification(error=0.05, within=0.555, share=0.75, budget=40)
"""About three paths in four keep it, so 40 paths cannot tell."""


@pytest.fixture(scope="module")
def loop():
    arm = load_arm("double_pendulum", gravity=9.8)
    return ClosedLoop(
        arm,
        printed(FTCF(arm)),
        Sinusoid((1.5, 1.0), (1.0, 2.0)),
        Vibration(BaseAcceleration("xz"), WhiteNoise(0.1, "amplitude")),
        q0=(-0.1, 0.25),
        v0=(-0.3, 0.45),
    )


@pytest.fixture(scope="module")
def record(loop):
    return simulate_paths(loop, CHUNK, DURATION)


def settling_times(record, tolerance):
    """Time after the last sample outside, inf if that is the end."""
    outside = record.ote.values > tolerance
    last = outside.shape[1] - np.argmax(outside[:, ::-1], axis=1)
    first = np.where(outside.any(axis=1), last, 0)
    return np.where(first < outside.shape[1], first * 1e-3, np.inf)


def peak_rate(record):
    return np.abs(np.diff(record.u.values, axis=1)).max(axis=1) / 1e-3  # (paths, n)


def test_yes(loop, record):
    required = Specification(error=0.05, within=0.6)
    verification = verify(loop, required, DURATION)
    assert np.all(settling_times(record, 0.05) <= 0.6)
    assert (verification.answer, verification.worst) == ("yes", ())
    verdict = verification.verdict
    assert (verdict.successes, verdict.trials) == (74, 74)  # see SequentialTest
    assert verdict.low > 0.95
    assert str(verification).startswith("yes: 74 of 74 paths settle below 0.05 within 0.6 s")


def test_no_with_the_worst_paths_first(loop, record):
    rate = np.quantile(peak_rate(record).max(axis=1), 0.5)
    verification = verify(loop, Specification(0.05, 0.6, torque_rate=rate), DURATION)
    assert verification.answer == "no"
    assert verification.verdict.high < 0.95
    kept = np.all(peak_rate(record) <= rate, axis=1)
    assert verification.verdict.successes == kept[: verification.verdict.trials].sum()
    assert [*map(float, verification.fixed)] == [*map(float, proportion(int(kept.sum()), CHUNK))]
    excess = peak_rate(record).max(axis=1) / rate
    order = np.argsort(-excess)[:5]
    assert [one.path for one in verification.worst] == order.tolist()
    assert [one.excess for one in verification.worst] == pytest.approx(excess[order])
    worst = verification.worst[0]
    assert worst.reason == f"torque rate {excess.max():.3g} times its limit"
    again = simulate(loop, DURATION, seed=verification.seed, path=worst.path)
    steepest = np.abs(np.diff(again.u.values, axis=0)).max() / 1e-3
    assert steepest / rate == pytest.approx(worst.excess)


def test_undecided_within_the_budget(loop, record):
    verification = verify(loop, TIGHT, DURATION)
    kept = settling_times(record, 0.05)[:40] <= 0.555
    assert 0.6 < kept.mean() < 0.9
    assert verification.answer == "undecided"
    assert (verification.verdict.successes, verification.verdict.trials) == (kept.sum(), 40)
    assert verification.verdict.low < 0.75 < verification.verdict.high


@pytest.mark.parametrize(
    ("effort", "answer"), [(15.0, "yes"), ([15.0, 15.0], "yes"), ([20.0, 14.9], "no"), (14.0, "no")]
)
def test_the_torque_of_every_joint_has_its_limit(loop, record, effort, answer):
    """The arm's own limit of 15 N m is reached by both joints of every path."""
    assert np.all(np.abs(record.u.values).max(axis=1) == 15.0)
    verification = verify(loop, Specification(0.05, 0.6, effort=effort), DURATION)
    assert verification.answer == answer
    if answer == "no":
        excess = 15.0 / np.min(effort)
        assert verification.worst[0].reason == f"torque {excess:.3g} times its limit"
        assert verification.worst[0].excess == pytest.approx(excess)


def test_what_never_settles_is_not_called_diverged(loop):
    verification = verify(loop, Specification(error=1e-6, within=0.5), DURATION)
    assert verification.answer == "no"
    assert all(one.reason.startswith("error ") for one in verification.worst)
    assert np.isfinite(verification.worst[0].excess)


def test_the_worst_paths_are_those_with_the_largest_errors(loop):
    required = Specification(error=1e-3, within=0.6, budget=300)
    verification = verify(loop, required, DURATION)
    ran = simulate_paths(loop, 256, DURATION)
    late = ran.ote.sel(time=slice(0.6 - 1e-9, None)).max("time").values
    assert [one.path for one in verification.worst] == np.argsort(-late)[:5].tolist()
    assert verification.worst[0].excess == pytest.approx(late.max() / 1e-3)


def test_what_diverges_is_named_with_its_time(loop):
    shaken = Vibration(BaseAcceleration("xz"), WhiteNoise(1e10))
    wild = ClosedLoop(loop.arm, loop.controller, loop.reference, shaken)
    verification = verify(wild, Specification(0.05, 0.2, budget=64), 0.3)
    worst = verification.worst[0]
    diverged_at = float(simulate(wild, 0.3, path=worst.path).diverged_at)
    assert worst.reason == f"diverges at {diverged_at:.4g} s"


@pytest.mark.parametrize("required", [TIGHT, Specification(0.05, 0.555, share=0.95)])
def test_the_answer_does_not_depend_on_the_paths_run_at_once(loop, monkeypatch, required):
    verdicts = []
    for chunk in (1, 7, CHUNK):
        monkeypatch.setattr("ftcfa.study.verification.CHUNK", chunk)
        verdicts.append(verify(loop, required, DURATION).verdict)
    assert {one.answer for one in verdicts} == {"undecided" if required is TIGHT else "no"}
    if required is not TIGHT:  # what cannot be decided any more is looked at to the chunk's end
        assert verdicts[0] == verdicts[1] == verdicts[2]


def test_progress_counts_to_the_decision(loop):
    seen = []
    verify(loop, TIGHT, DURATION, progress=lambda *args: seen.append(args))
    assert seen == [(40, 40)]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"error": 0.0}, "Specification error: 0.0, expected a number > 0 [rad or m]"),
        ({"within": -1}, "Specification within: -1, expected a number > 0 [s]"),
        ({"share": 1.0}, "Specification share: 1.0, expected a number between 0 and 1"),
        ({"confidence": 0.5}, "Specification confidence: 0.5, expected 2/3 or more"),
        ({"budget": 0}, "Specification budget: 0, expected an integer >= 1"),
        ({"effort": -1.0}, "Specification effort: -1.0, expected a number > 0 [N m or N]"),
        (
            {"torque_rate": [1, 0]},
            "Specification torque_rate: [1.0, 0.0], expected numbers > 0 [N m/s or N/s]",
        ),
    ],
)
def test_a_specification_checks_its_numbers(values, message):
    with pytest.raises(ParameterError) as caught:
        Specification(**{"error": 0.05, "within": 0.5, **values})
    assert str(caught.value) == message


def test_a_specification_must_go_with_the_loop(loop):
    with pytest.raises(ParameterError, match=r"within: 0\.8 s, expected less than the duration"):
        verify(loop, Specification(0.05, 0.8), DURATION)
    with pytest.raises(ShapeError, match=r"Specification effort: shape \(3,\)"):
        verify(loop, Specification(0.05, 0.5, effort=[1, 2, 3]), DURATION)
