"""Noise inputs against gravity, the pendulum's closed form and the paper's own print."""

from math import cos, sin

import numpy as np
import pinocchio as pin
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    FrameWrench,
    Harmonic,
    JointTorque,
    NoiseInput,
    PaperPendulum,
    PaperPendulumInput,
    ParameterError,
    ShapeError,
    Sinusoid,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
)

ROUNDING = 1e-12
"""Sums of some ten products of numbers near one, done in two orders."""
GRID = 32
"""Angles a turn: the trapezoid rule on periodic analytic functions, right to five digits."""
AS_STATED = 0.006
"""EQUATIONS states the three figures with two decimals."""
LOWER = (np.array([0, 0, 1, 0, 1, 2]), np.array([0, 1, 1, 2, 2, 2]))
"""xx, xy, yy, xz, yz, zz."""
M1, M2, L1, L2 = 0.6, 0.8, 0.8, 1.2


def random_postures(n, count, seed=0):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, n))


def physical(q1, q2):
    """Base accelerations (x, z) on two point masses on massless rods: minus sum of m dr/dq."""
    return -np.array(
        [
            [(M1 + M2) * L1 * cos(q1), (M1 + M2) * L1 * sin(q1)],
            [M2 * L2 * cos(q2), M2 * L2 * sin(q2)],
        ]
    )


def printed(q1, q2):
    """Lambda as the text of Section V prints it, entry by entry."""
    return np.array(
        [
            [
                -M1 * L1 * cos(q1) + 0.5 * M2 * L1 * sin(q1) * sin(2 * (q2 - q1)),
                -M1 * L1 * sin(q1) - 0.5 * M2 * L1 * cos(q1) * sin(2 * (q2 - q1)),
            ],
            [M2 * L2 * sin(q1) * sin(2 * (q2 - q1)), -M2 * L2 * cos(q1) * sin(2 * (q2 - q1))],
        ]
    )


@pytest.fixture(scope="module")
def pendulum():
    return load_arm("double_pendulum", gravity=9.8)


def test_base_acceleration_of_the_pendulum_is_its_closed_form(pendulum):
    for q in random_postures(2, 20):
        for arm in (pendulum, PaperPendulum()):
            got = BaseAcceleration("xz").matrix(arm, q)
            np.testing.assert_allclose(got, physical(*q), rtol=0, atol=ROUNDING)


def test_the_plane_of_the_pendulum_does_not_feel_the_third_axis(pendulum):
    for q in random_postures(2, 5):
        column = BaseAcceleration("y").matrix(pendulum, q)
        np.testing.assert_allclose(column, 0.0, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("robot", ["panda", "ur5"])
def test_an_accelerated_base_is_a_changed_gravity(robot):
    gravity, acceleration = np.array([0.3, -0.5, -9.81]), np.array([1.1, -0.7, 2.3])
    arm, shaken = (load_arm(robot, gravity=g) for g in (gravity, gravity - acceleration))
    for q in random_postures(arm.n, 5):
        change = shaken.potential_force(q) - arm.potential_force(q)
        got = -BaseAcceleration().matrix(arm, q) @ acceleration
        np.testing.assert_allclose(got, change, rtol=0, atol=100 * ROUNDING)  # tens of N m


@pytest.mark.parametrize("axes", ["x", "zx", "yzx"])
def test_channels_follow_the_order_of_the_axes(axes):
    arm = load_arm("ur5")
    all_axes = BaseAcceleration("xyz").matrix(arm, arm.home)
    expected = np.column_stack([all_axes[:, "xyz".index(axis)] for axis in axes])
    np.testing.assert_array_equal(BaseAcceleration(axes).matrix(arm, arm.home), expected)


@pytest.mark.parametrize("axes", ["", "xx", "xw", "XZ", None, 3, ["x", "w"], ["x", "x"], [0, 2]])
def test_bad_axes_are_refused(axes):
    with pytest.raises(ParameterError, match=r'BaseAcceleration axes: .*such as "xyz" or "xz"'):
        BaseAcceleration(axes)


def test_the_paper_input_is_the_printed_formula():
    for q in random_postures(2, 50):
        got = PaperPendulumInput().matrix(PaperPendulum(), q)
        np.testing.assert_allclose(got, printed(*q), rtol=0, atol=ROUNDING)


def test_the_paper_input_is_not_the_physical_one_but_nearly_as_strong(pendulum):
    """Means over all postures, the noise power being tr(M^-1 Lambda Lambda^T M^-1)."""
    differences, powers = [], []
    angles = np.arange(GRID) * 2.0 * np.pi / GRID
    for q in np.array(np.meshgrid(angles, angles)).reshape(2, -1).T:
        ours = BaseAcceleration("xz").matrix(pendulum, q)
        theirs = PaperPendulumInput().matrix(pendulum, q)
        differences.append(np.linalg.norm(theirs - ours) / np.linalg.norm(ours))
        M = pendulum.mass_matrix(q)
        accelerations = np.linalg.solve(M, np.hstack([theirs, ours]))
        powers.append([np.sum(accelerations[:, :2] ** 2), np.sum(accelerations[:, 2:] ** 2)])
    assert np.mean(differences) == pytest.approx(0.89, abs=AS_STATED)
    assert np.mean(powers, axis=0) == pytest.approx([2.26, 2.23], abs=AS_STATED)


def test_the_paper_input_is_for_two_joints_only():
    with pytest.raises(ShapeError, match="an arm of 6 joints, expected 2 joints"):
        PaperPendulumInput().matrix(load_arm("ur5"), np.zeros(6))


def wind(arm, q):
    """A user's own Lambda: a gust along x on the last link, felt less the more it lies along x."""
    J = arm.frame_jacobian("wrist_3_link", q)
    return (J[:1] * np.cos(q[0])).T


def loop_with(noise_input, arm):
    vibration = Vibration(noise_input, WhiteNoise(0.1))
    reference = Sinusoid(offset=arm.home)
    return ClosedLoop(arm, FTCF(arm, compensation="bias"), reference, vibration)


@pytest.mark.parametrize("robot", ["ur5", "double_pendulum", "xarm7", "asr_twodof"])
def test_a_frame_moves_as_its_jacobian_says(robot):
    """Central differences of Pinocchio's own forward kinematics, through the coordinate map."""
    arm = load_arm(robot)
    model, eps = arm.model, 1e-6
    data = model.createData()
    rng = np.random.default_rng(0)
    q, v = rng.uniform(-1, 1, arm.n), rng.standard_normal(arm.n)
    for name in arm.frame_names:
        number = model.getFrameId(name)
        placements = []
        for sign in (-1, 1):
            pin.framesForwardKinematics(model, data, arm.G @ (q + sign * eps * v) + arm.g0)
            placements.append(data.oMf[number].copy())
        before, after = placements
        linear = (after.translation - before.translation) / (2 * eps)
        angular = pin.log3(after.rotation @ before.rotation.T) / (2 * eps)
        expected = np.concatenate([linear, angular])
        np.testing.assert_allclose(arm.frame_jacobian(name, q) @ v, expected, atol=1e-8)


def test_a_wrench_loads_the_joints_by_the_transposed_jacobian():
    arm = load_arm("ur5")
    J = arm.frame_jacobian("tool0", arm.home)
    got = FrameWrench("tool0", force="zx", moment="y").matrix(arm, arm.home)
    np.testing.assert_array_equal(got, J[[2, 0, 4]].T)


def test_a_weight_on_the_tool_is_a_force_along_gravity():
    """A point mass m at the frame changes h by -J^T m g."""
    arm = load_arm("ur5")
    heavy = arm.inertias
    frame = arm.tree().frames["tool0"]
    m, r = 2.0, frame.translation
    heavy[frame.joint, 0] += m
    heavy[frame.joint, 1:4] += m * r
    heavy[frame.joint, 4:] += m * (r @ r * np.eye(3) - np.outer(r, r))[*LOWER]
    change = arm.with_inertias(heavy).potential_force(arm.home) - arm.potential_force(arm.home)
    force = FrameWrench("tool0").matrix(arm, arm.home) @ (m * arm.gravity)
    np.testing.assert_allclose(change, -force, atol=1e-12)


def test_motor_noise_acts_on_the_named_joints():
    arm = load_arm("ur5")
    np.testing.assert_array_equal(JointTorque().matrix(arm, arm.home), np.eye(6))
    names = ["wrist_1_joint", "elbow_joint"]
    np.testing.assert_array_equal(JointTorque(names).matrix(arm, arm.home), np.eye(6)[:, [3, 2]])


@pytest.mark.parametrize(
    "noise_input",
    [
        JointTorque(),
        JointTorque(["elbow_joint"]),
        FrameWrench("forearm_link"),
        FrameWrench("tool0", "", "xyz"),
        FrameWrench("world"),  # of the base: no joint feels it
        wind,
    ],
)
def test_the_engines_agree(noise_input):
    loop = loop_with(noise_input, load_arm("ur5"))
    runs = [simulate(loop, 0.1, seed=3, engine=e) for e in ("compiled", "interpreted")]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-10)


@pytest.mark.parametrize("mounting", ["wall", "ceiling"])
def test_axes_are_the_worlds_however_the_base_is_mounted(mounting):
    """Pure z shaking is a change of gravity, which the mounted arm has in world axes too."""
    arm, shaken = (load_arm("ur5", mounting=mounting, gravity=g) for g in (9.81, 12.81))
    for q in random_postures(6, 5):
        change = shaken.potential_force(q) - arm.potential_force(q)
        got = -BaseAcceleration("z").matrix(arm, q)[:, 0] * 3.0
        np.testing.assert_allclose(got, change, rtol=0, atol=100 * ROUNDING)


def test_an_arm_at_the_ceiling_hangs():
    """The pendulum's angle is measured from where its rods point on the floor."""
    on_floor, hanging = (load_arm("double_pendulum", mounting=m) for m in ("floor", "ceiling"))
    q = np.array([0.3, -0.2])
    np.testing.assert_allclose(
        hanging.potential_force(q), -on_floor.potential_force(q), rtol=0, atol=ROUNDING
    )


def test_a_mounting_is_a_rotation_too():
    turn = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    by_name, by_matrix = (load_arm("ur5", mounting=m) for m in ("wall", turn))
    np.testing.assert_array_equal(
        by_name.base_coupling(by_name.home), by_matrix.base_coupling(by_name.home)
    )
    # base z along world x: the load of the base's own z acceleration
    on_floor = load_arm("ur5")
    np.testing.assert_allclose(
        BaseAcceleration("x").matrix(by_name, by_name.home),
        BaseAcceleration("z").matrix(on_floor, on_floor.home),
        atol=ROUNDING,
    )


@pytest.mark.parametrize("mounting", ["sideways", [1, 2, 3], np.diag([1, 1, -1.0]), None, "x"])
def test_bad_mountings_are_refused(mounting):
    with pytest.raises((ParameterError, UnknownNameError), match=r'mounting.*floor"?, "?wall'):
        load_arm("ur5", mounting=mounting)


def test_unknown_names_list_the_known():
    arm = load_arm("ur5")
    with pytest.raises(UnknownNameError, match=r"frame of ur5 'tip'.*one of:.*tool0"):
        loop_with(FrameWrench("tip"), arm)
    with pytest.raises(UnknownNameError, match=r"JointTorque joint 'knee'.*shoulder_pan_joint"):
        loop_with(JointTorque(["knee"]), arm)
    with pytest.raises(ParameterError, match="PaperPendulum without frame_jacobian"):
        loop_with(FrameWrench("tip"), PaperPendulum())


def test_a_function_must_give_a_matrix_of_a_row_a_joint():
    arm = load_arm("ur5")
    with pytest.raises(ShapeError, match=r"shape \(6,\), expected \(6, channels\)"):
        loop_with(lambda arm, q: q, arm)  # noqa: ARG005
    with pytest.raises(
        ParameterError, match="Vibration input: 3, expected a noise input, or a fun"
    ):
        loop_with(3, arm)
    with pytest.raises(ParameterError, match="FrameWrench force and moment: '', ''"):
        FrameWrench("tool0", "", "")


class Plain:
    """A user's own, with a matrix only."""

    def matrix(self, arm, q):
        return wind(arm, q)


def test_an_object_with_a_matrix_is_an_input_as_it_is():
    arm, plain = load_arm("ur5"), Plain()
    assert Vibration(plain, WhiteNoise(0.1)).input is plain
    runs = [simulate(loop_with(own, arm), 0.05).q for own in (plain, wind)]
    np.testing.assert_array_equal(*runs)


class Trolley(NoiseInput):
    """A user's own that moves: a cart that the excitation drives against a spring, (x, v)."""

    def __init__(self, checked):
        self.checked = checked

    def matrix(self, arm, q):
        return BaseAcceleration("x").matrix(arm, q)

    def check(self, process):
        self.checked.append(process)

    def init(self):
        return np.zeros(2)

    def impulse(self, arm, q, v, state, integrals, step):
        x, dx = state[0], state[1]
        change = integrals.increment[0] - 400.0 * step * x
        after = np.stack([x + step * (dx + change), dx + change])
        return self.matrix(arm, q)[:, 0] * change, after


def test_a_moving_input_of_ones_own():
    """Pushed by a tone, it loads the joints by the cart's acceleration: that of an oscillator."""
    arm, checked = load_arm("double_pendulum"), []
    vibration = Vibration(Trolley(checked), Harmonic(3.0, 2.0, 0.4), level=2.0)
    loop = ClosedLoop(arm, FTCF(arm, compensation="bias"), Sinusoid(offset=arm.home), vibration)
    assert checked == [loop.process]
    runs = [simulate(loop, 0.1, engine=engine) for engine in ("compiled", "interpreted")]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-10)
    state, h = vibration.init(loop.process, np.zeros(0)), 1e-3
    for _ in range(500):
        _, state = vibration.impulse(
            loop.process, arm, arm.home, np.zeros(2), state, np.zeros(0), np.zeros(0), h
        )
    w, W = 20.0, 4 * np.pi
    size = 6.0 / (w**2 - W**2)
    exact = size * (
        np.cos(W * 0.5 + 0.4) - np.cos(0.4) * np.cos(w * 0.5)
        + W / w * np.sin(0.4) * np.sin(w * 0.5)
    )  # fmt: skip
    assert state.input[0] == pytest.approx(exact, abs=0.01 * size)  # semi-implicit, w h = 0.02
