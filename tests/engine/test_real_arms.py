"""The paper's controller on real arms, shaken: home + 0.3 sin t for 10 s at 1 ms."""

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Gains,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.model.urdf.catalogue import catalogue

PATHS = 8
TIGHT = 0.01
"""What the rms overall tracking error of the last half must stay below [rad]."""

POSTURES = {
    "panda": {},
    "ur5": {},
    "xarm7": {},
    # The wrist bent: outstretched, joints 4 and 6 turn about nearly one axis, and the shaken base
    # throws them at 27 rad/s^2 for each m/s^2.
    "kinova": {"j2s6s200_joint_4": 1.5708, "j2s6s200_joint_5": 1.5708},
    # The elbow bent: outstretched, gravity alone takes half of the shoulder's torque, and the
    # shaken base the rest for a quarter of the time.
    "talos_left_arm": {"arm_left_4_joint": -1.57},
}
"""Arms that the paper's gains keep within 0.01 rad, with what differs from their home."""


def shaken(robot, *, posture=None, gains=None, compensation="bias", intensity=0.1):
    arm = load_arm(robot)
    start = dict(zip(arm.joint_names, arm.home, strict=True)) | (posture or {})
    home = np.array(list(start.values()))
    return ClosedLoop(
        arm,
        FTCF(arm, gains or Gains(), compensation=compensation),
        Sinusoid(0.3, offset=home),
        Vibration(BaseAcceleration(), WhiteNoise(intensity)),
        q0=home,
    )


def tracked(loop):
    """Rms overall tracking error of the last half of each path, after what holds for all arms."""
    dataset = simulate_paths(loop, PATHS, 10.0)
    assert np.all(np.isnan(dataset.diverged_at))
    assert np.all(np.isfinite(dataset.q))
    assert np.all(np.abs(dataset.u) <= loop.arm.effort_limit)
    assert np.all((dataset.q > loop.arm.lower) & (dataset.q < loop.arm.upper))
    return np.sqrt(np.mean(dataset.ote.values[:, 5000:] ** 2, axis=1))


@pytest.mark.parametrize("robot", POSTURES)
def test_the_papers_gains_track_tightly(robot):
    assert np.all(tracked(shaken(robot, posture=POSTURES[robot])) < TIGHT)


def test_a_small_arm_wants_larger_gains():
    """SO-ARM101: with links of 0.1 m, 1 m/s^2 of the base is 10 rad/s^2 in the joints.

    The paper's gains, laid out for links of a metre, hold it to 0.03 rad; four times c2 is tight.
    """
    assert np.all(tracked(shaken("so101")) < 0.06)
    assert np.all(tracked(shaken("so101", gains=Gains(c2=100.0))) < TIGHT)


@pytest.mark.parametrize("robot", ["so101", "panda"])
def test_without_vibration_the_error_vanishes(robot):
    assert np.all(tracked(shaken(robot, intensity=0.0)) < TIGHT / 100.0)


def test_gravity_without_compensation_costs_a_tenth_of_a_radian():
    """The paper's law as it is knows no gravity: Panda sags by 0.10 rad."""
    assert tracked(shaken("panda", compensation="none")) == pytest.approx(0.10, rel=0.15)


def test_friction_compensation_is_stable_on_light_joints():
    """xArm7's last link, 1e-4 kg m^2 with 1 N m of friction: unshaken it must simply track."""
    loop = shaken("xarm7", intensity=0.0)
    dataset = simulate(loop, 10.0)
    error = np.abs(dataset.q - dataset.q_d)[5000:]
    assert np.all(error.max("time") < 1e-3)


def test_interpreted_on_pinocchio_the_arm_tracks_as_well():
    loop = shaken("ur5")
    dataset = simulate(loop, 4.0, engine="interpreted")
    assert np.sqrt(np.mean(dataset.ote[2000:] ** 2)) < TIGHT
    assert np.all(np.abs(dataset.u) <= loop.arm.effort_limit)


@pytest.mark.parametrize("robot", list(catalogue()))
def test_every_arm_of_the_catalogue_runs(robot):
    """Half a second: deterministic, within the torque limits, no exception."""
    loop = shaken(robot)
    first, again = (simulate(loop, 0.5) for _ in range(2))
    np.testing.assert_array_equal(first.q, again.q)
    assert np.isnan(first.diverged_at)
    assert np.all(np.abs(first.u) <= loop.arm.effort_limit)
