"""What is said of a loop before it runs: by joint, time and numbers, and nothing of a good one."""

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    ClosedLoop,
    Constant,
    PaperPendulum,
    Sinusoid,
    Specification,
    compare,
    ensemble,
    load_arm,
    simulate,
    simulate_paths,
    verify,
)
from ftcfa.loop.feasibility import doubts

PANDA = load_arm("panda")
PENDULUM = load_arm("double_pendulum", gravity=9.8)


def loop_of(arm, reference, **options):
    return ClosedLoop(arm, FTCF(arm, compensation="bias"), reference, **options)


@pytest.mark.parametrize(
    "loop",
    [
        loop_of(PANDA, Sinusoid(0.3, offset=PANDA.home)),
        loop_of(PENDULUM, Sinusoid([1.5, 1.0], [1.0, 2.0]), q0=[-0.1, 0.25]),
        loop_of(PaperPendulum(), Sinusoid([1.5, 1.0], [1.0, 2.0])),
        loop_of(load_arm("double_pendulum_relative"), Constant([0.0, 0.0])),
    ],
)
def test_of_a_good_loop_nothing_is_said(loop):
    assert doubts(loop, 10.0) == []


def test_a_reference_beyond_the_limits_of_position():
    """Joint 4 swings by 2.5 rad about -3 pi/4, its limits are -3.0718 and -0.0698."""
    swing = np.where(np.arange(7) == 3, 2.5, 0.1)
    (doubt,) = doubts(loop_of(PANDA, Sinusoid(swing, 0.8, offset=PANDA.home)), 10.0)
    worst = -3 * np.pi / 4 - 2.5
    assert doubt == (
        f"the reference is {worst:.3g} rad at joint 'panda_joint4' at {3 * np.pi / 1.6:.3g} s; its "
        "limits are -3.07 and -0.0698 rad"
    )


def test_a_reference_that_is_too_fast():
    """0.1 rad at 30 rad/s are 3 rad/s; the limits are 2.175 and 2.61 rad/s."""
    (doubt,) = doubts(loop_of(PANDA, Sinusoid(0.1, 30.0, offset=PANDA.home)), 1.0)
    assert doubt.startswith("the velocity of the reference is 3 rad/s at joint 'panda_joint1' at 0")
    assert "its limits are -2.17 and 2.17 rad/s; also beyond: panda_joint2, " in doubt


@pytest.mark.parametrize("given", ["reference", "q0"])
def test_degrees_that_should_be_radians(given):
    degrees = np.array([0.0, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0])
    reference = Constant(degrees if given == "reference" else PANDA.home)
    start = {"q0": degrees} if given == "q0" else {}
    first, far = doubts(loop_of(PANDA, reference, **start), 1.0)
    assert "is -135 rad at joint 'panda_joint4' at 0 s" in first
    for doubt in (first, far):
        assert "degrees? 135 rad are 21.5 turns, 135 degrees are 2.36 rad" in doubt


def test_degrees_of_a_joint_without_limits_show_at_the_start():
    (doubt,) = doubts(loop_of(PaperPendulum(), Constant([90.0, 0.0])), 1.0)
    assert doubt.startswith("joint 'shoulder' starts at 0 rad, 90 rad from the reference, 90 rad")
    assert "90 degrees are 1.57 rad" in doubt


def test_a_start_far_from_the_reference():
    """A quarter turn is far; a tenth of the travel of a slide is."""
    far = PENDULUM.home + np.array([0.0, 1.6])
    (doubt,) = doubts(loop_of(PENDULUM, Constant(PENDULUM.home), q0=far), 1.0)
    assert doubt == (
        "joint 'elbow' starts at 1.6 rad, 1.6 rad from the reference, 0 rad at 0 s; start nearer "
        "with q0"
    )


def test_gravity_beyond_the_effort_limit():
    """The need is that of the closed form of the paper's pendulum."""
    weak = load_arm("double_pendulum", gravity=9.8, effort_limit=5.0)
    reference = Sinusoid([np.pi / 2, 0.0], 1.0)
    (doubt,) = doubts(loop_of(weak, reference), 10.0)
    needed = abs(PaperPendulum().potential_force(np.array([np.pi / 2, 0.0]))[0])
    assert doubt.startswith(f"gravity needs {needed:.3g} of 5 N m at joint 'shoulder' on the")


BAD = loop_of(PENDULUM, Constant(PENDULUM.home), q0=[0.0, 2.0])


@pytest.mark.parametrize(
    "run",
    [
        lambda: simulate(BAD, 0.01),
        lambda: simulate_paths(BAD, 2, 0.01),
        lambda: ensemble(BAD, 2, 0.01),
        lambda: verify(BAD, Specification(0.1, 0.005, budget=2), 0.01),
        lambda: compare({"one": BAD, "other": loop_of(PENDULUM, Constant([0.0, 0.1]))}, 2, 0.01),
    ],
)
def test_every_run_warns_its_caller(run):
    with pytest.warns(UserWarning, match="joint 'elbow' starts at 2 rad") as caught:
        run()
    if "compare" not in run.__code__.co_names:
        assert caught[0].filename == __file__
