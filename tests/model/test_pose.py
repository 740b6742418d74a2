"""Poses of frames: against Pinocchio's forward kinematics and by hand; errors of the tool."""

import numpy as np
import pinocchio as pin
import pytest

import ftcfa
from ftcfa.errors import UnknownNameError
from ftcfa.model.pose import Pose, angle, distance
from ftcfa.model.twins import unchecked
from ftcfa.model.urdf.catalogue import catalogue

EXACT = 1e-12


def pinocchio_pose(arm, frame, q):
    data = arm.model.createData()
    pin.framesForwardKinematics(arm.model, data, arm.G @ q + arm.g0)
    return data.oMf[arm.model.getFrameId(frame, pin.FrameType.BODY)]


@pytest.mark.parametrize("name", list(catalogue()))
def test_both_twins_are_where_pinocchio_is(name):
    arm = ftcfa.load_arm(name, mounting="wall")
    twin = unchecked(arm)
    for q in np.random.default_rng(0).uniform(-1, 1, (3, arm.n)):
        expected = pinocchio_pose(arm, arm.tool, q)
        for one in (arm, twin):
            pose = one.pose(q)
            np.testing.assert_allclose(pose.position, expected.translation, atol=EXACT)
            np.testing.assert_allclose(pose.rotation, expected.rotation, atol=EXACT)


def test_the_pendulum_by_hand():
    arm = ftcfa.load_arm("double_pendulum")
    down = arm.position(np.zeros(2))
    assert down[:2] == pytest.approx([0.0, 0.0], abs=EXACT)
    lengths = np.abs(down[2])
    out = arm.position(np.full(2, np.pi / 2))  # absolute angles: both links level
    assert np.linalg.norm(out) == pytest.approx(lengths, abs=EXACT)
    assert out[2] == pytest.approx(0.0, abs=EXACT)


def test_a_tool_of_ones_own_and_an_unknown_one():
    arm = ftcfa.load_arm("panda", tool="panda_link4")
    expected = pinocchio_pose(arm, "panda_link4", arm.home)
    np.testing.assert_allclose(arm.position(arm.home), expected.translation, atol=EXACT)
    flange = pinocchio_pose(arm, "panda_link8", arm.home).homogeneous
    np.testing.assert_allclose(arm.pose(arm.home, "panda_link8").matrix, flange, atol=EXACT)
    with pytest.raises(UnknownNameError, match=r"tool of panda.*panda_link8"):
        ftcfa.load_arm("panda", tool="panda_lnk8")
    with pytest.raises(UnknownNameError, match="frame of panda"):
        arm.pose(arm.home, "gripper")


@pytest.mark.parametrize("turn", [1e-9, 1e-4, 0.3, 3.0, np.pi])
def test_distance_and_angle(turn):
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    a = Pose(np.eye(3), np.zeros(3))
    b = Pose(pin.exp3(turn * axis), np.array([0.3, 0.0, 0.4]))
    assert angle(a, b) == pytest.approx(turn, rel=1e-6)
    assert distance(a, b) == pytest.approx(0.5, rel=EXACT)


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
@pytest.mark.parametrize("name", ["ur10", "double_pendulum"])
def test_the_error_of_the_tool_is_that_of_forward_kinematics(name, engine):
    arm = ftcfa.load_arm(name)
    loop = ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1)),
        q0=arm.home + 0.1,
    )
    names = ["tool_error", "tool_angle_error"]
    path = ftcfa.simulate(loop, 0.02, signals=names, engine=engine)
    for k in range(path.sizes["time"]):
        real, wanted = (pinocchio_pose(arm, arm.tool, np.asarray(path[x][k])) for x in ("q", "q_d"))
        gap = np.linalg.norm(real.translation - wanted.translation)
        turn = np.linalg.norm(pin.log3(real.rotation.T @ wanted.rotation))
        assert float(path.tool_error[k].squeeze()) == pytest.approx(gap, abs=EXACT)
        assert float(path.tool_angle_error[k].squeeze()) == pytest.approx(turn, abs=1e-8)
    assert path.tool_error.units == "m"


def test_metrics_and_specification_of_the_tool():
    arm = ftcfa.load_arm("panda")
    loop = ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration(), ftcfa.WhiteNoise(0.1)),
    )
    runs = ftcfa.ensemble(loop, 3, 0.4, record_every=1)
    for number in range(3):
        path = ftcfa.simulate(loop, 0.4, path=number, signals=["tool_error"])
        late = np.asarray(path.tool_error)[path.time.values >= 0.2 - 1e-9]
        rms, peak = (float(runs[f"late_{x}_tool_error"][number]) for x in ("rms", "peak"))
        assert rms == pytest.approx(np.sqrt(np.mean(late**2)), rel=1e-9)
        assert peak == pytest.approx(late.max(), rel=1e-12)
    worst = float(runs.late_peak_tool_error.max())
    for limit, answer in ((2 * worst, "yes"), (worst / 10, "no")):
        required = ftcfa.Specification(np.inf, 0.2, tool_error=limit)
        found = ftcfa.verify(loop, required, 0.4)
        assert found.answer == answer
        assert "mm at the tool" in str(found)
    assert "tool error" in found.worst[0].reason


def test_errors_and_saturation_of_each_joint():
    arm = ftcfa.load_arm("double_pendulum", effort_limit=[15.0, 4.0])
    loop = ftcfa.ClosedLoop(
        arm, ftcfa.FTCF(arm, compensation="bias"), ftcfa.Sinusoid([1.5, 1.0], 2.0), q0=[0.3, -0.2]
    )
    runs = ftcfa.ensemble(loop, 1, 1.0)
    path = ftcfa.simulate(loop, 1.0, signals=["u_command", "u_wanted"])
    beyond = np.abs(path.u_command.values) > np.abs(path.u_wanted.values)
    np.testing.assert_allclose(runs.joint_saturated[0], beyond.mean(axis=0), atol=EXACT)
    assert float(runs.saturated[0]) == pytest.approx(beyond.any(axis=1).mean(), abs=EXACT)
    late = (path.q - path.q_d).sel(time=slice(0.5 - 1e-9, None)).values
    np.testing.assert_allclose(runs.late_peak_joint_error[0], np.abs(late).max(axis=0), rtol=1e-9)
    rms = np.sqrt(np.mean(late**2, axis=0))
    np.testing.assert_allclose(runs.late_rms_joint_error[0], rms, rtol=1e-9)
