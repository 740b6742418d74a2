"""Locked, mimic, prismatic, continuous and branching joints: the linear map q_model = G q + g0."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from ftcfa import Arm, load_arm
from ftcfa.arrays import Array
from ftcfa.model.urdf.catalogue import catalogue

from ..texts import AXIS_Y, BASE, LIMIT, LINKS, SHOULDER, joint, link, robot, with_elbow

ROUNDING = 1e-12
"""Relative to the largest entry; the algorithms differ only in the order of their sums."""
STATES = 20


def assert_close(actual: Array, expected: Array) -> None:
    scale = max(1.0, np.max(np.abs(expected)))
    np.testing.assert_allclose(actual, expected, rtol=0, atol=ROUNDING * scale)


def assert_same_robot(actual: Arm, expected: Arm) -> None:
    """M, bias and base coupling of two arms are equal at random states."""
    assert actual.n == expected.n
    for q, v in np.random.default_rng(3).uniform(-2, 2, (STATES, 2, actual.n)):
        assert_close(actual.mass_matrix(q), expected.mass_matrix(q))
        assert_close(actual.bias_force(q, v), expected.bias_force(q, v))
        assert_close(actual.base_coupling(q), expected.base_coupling(q))


def assert_equals_model(arm: Arm, model: pin.Model) -> None:
    """M and C v + h are those of a Pinocchio model with the arm's own coordinates."""
    assert model.nv == arm.n
    for q, v in np.random.default_rng(4).uniform(-2, 2, (STATES, 2, arm.n)):
        M = np.triu(pin.crba(model, model.createData(), q))  # reused Data err with mimic joints
        assert_close(arm.mass_matrix(q), M + np.triu(M, 1).T)
        bias = pin.rnea(model, model.createData(), q, v, np.zeros(arm.n))
        assert_close(arm.coriolis_matrix(q, v) @ v + arm.potential_force(q), bias)


def full_model(file: Path, **options: bool) -> pin.Model:
    return pin.buildModelFromUrdf(str(file), **options)


@pytest.mark.parametrize(
    ("name", "held"),
    [
        ("panda", {"panda_finger_joint1": 0.001, "panda_finger_joint2": 0.001}),
        ("baxter", {}),
        ("baxter_left_arm", {}),
        ("z1", {}),
        ("so101", {}),
    ],
)
def test_locked_joints_equal_pinocchios_reduced_model(name: str, held: dict[str, float]) -> None:
    arm, full = load_arm(name), full_model(catalogue()[name].path())
    posture = np.zeros(full.nq)
    for joint_name, value in held.items():
        posture[full.joints[full.getJointId(joint_name)].idx_q] = value
    locked = [full.getJointId(other) for other in full.names[1:] if other not in arm.joint_names]
    reduced = pin.buildReducedModel(full, locked, posture)
    assert tuple(reduced.names[1:]) == arm.joint_names
    assert_equals_model(arm, reduced)


def test_a_joint_locked_away_from_zero_equals_pinocchios_reduced_model() -> None:
    file = catalogue()["panda"].path()
    held = {"panda_joint3": 0.4, "panda_joint6": 1.9, "panda_finger_joint1": 0.02}
    arm, full = load_arm("panda", lock=held), full_model(file)
    posture = np.zeros(full.nq)
    for name, value in {**held, "panda_finger_joint2": 0.02}.items():
        posture[full.joints[full.getJointId(name)].idx_q] = value
    locked = [full.getJointId(name) for name in (*held, "panda_finger_joint2")]
    assert arm.n == 5
    assert_equals_model(arm, pin.buildReducedModel(full, locked, posture))


def test_a_mimic_gripper_equals_pinocchios_mimic_model() -> None:
    file = catalogue()["panda"].path()
    arm = load_arm(file)
    assert arm.joint_names == (*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1")
    assert_equals_model(arm, full_model(file, mimic=True))


def test_both_mimic_grippers_of_a_branched_robot_equal_pinocchios_mimic_model() -> None:
    file = catalogue()["baxter"].path()
    model = full_model(file, mimic=True)
    arm = load_arm(file, effort_limit=dict.fromkeys(["head_pan"], 10.0))
    assert arm.n == model.nv == 17
    assert_equals_model(arm, model)


def test_the_arms_of_a_branched_robot_do_not_couple() -> None:
    arm = load_arm("baxter")
    left = [i for i, name in enumerate(arm.joint_names) if name.startswith("left")]
    right = [i for i, name in enumerate(arm.joint_names) if name.startswith("right")]
    assert len(left) == len(right) == 7
    M = arm.mass_matrix(arm.home)
    np.testing.assert_array_equal(M[np.ix_(left, right)], np.zeros((7, 7)))
    alone = load_arm("baxter_left_arm")
    assert_close(M[np.ix_(left, left)], alone.mass_matrix(alone.home))


def test_continuous_joints_have_one_unlimited_coordinate_each() -> None:
    arm, turn = load_arm("kinova"), 2 * np.pi
    assert arm.n == arm.model.nq == 6
    continuous = [i for i, kind in enumerate(arm.joint_types) if kind == "continuous"]
    assert continuous == [0, 3, 5]
    assert np.all(np.isinf(arm.lower[continuous]))
    assert np.all(np.isinf(arm.upper[continuous]))
    for i in continuous:
        turned = arm.home + turn * np.eye(6)[i]
        assert_close(arm.mass_matrix(turned), arm.mass_matrix(arm.home))


def test_a_single_joint_equals_the_physical_pendulum(urdf: Callable[..., Path]) -> None:
    mass, length, inertia, g = 0.7, 0.4, 0.05, 9.81
    rod = link("rod", mass, f"0 0 {-length}", iyy=inertia, ixx=inertia, izz=inertia)
    arm = load_arm(urdf(robot(BASE, rod, joint("pivot", "base", "rod"))))
    about_pivot = inertia + mass * length**2
    for angle in np.linspace(-3, 3, STATES):
        q, c, s = np.array([angle]), np.cos(angle), np.sin(angle)
        turning = inertia + mass * (length**2 - 0.5 * length * c)  # about the base origin
        assert_close(arm.mass_matrix(q), np.array([[about_pivot]]))
        assert_close(arm.coriolis_matrix(q, np.ones(1)), np.zeros((1, 1)))
        assert_close(arm.bias_force(q, np.ones(1)), np.array([mass * g * length * s]))
        coupling = [[-mass * length * c, 0, mass * length * s, 0, turning, 0]]
        assert_close(arm.base_coupling(q), np.array(coupling))


def test_a_cart_and_pendulum_equal_their_closed_form(urdf: Callable[..., Path]) -> None:
    mc, mp, centre, inertia, g = 1.5, 0.7, 0.4, 0.05, 9.81
    cart = joint("rail", "base", "cart", "prismatic", f'<axis xyz="1 0 0"/>{LIMIT}')
    pivot = joint("pivot", "cart", "rod", "continuous", AXIS_Y + LIMIT)
    rod = link("rod", mp, f"0 0 {-centre}", iyy=inertia, ixx=inertia, izz=inertia)
    arm = load_arm(urdf(robot(BASE, link("cart", mc), rod, cart, pivot)))
    assert arm.joint_types == ("prismatic", "continuous")
    for q, v in np.random.default_rng(5).uniform(-2, 2, (STATES, 2, 2)):
        c, s = np.cos(q[1]), np.sin(q[1])  # the rod's centre is at x - l sin, -l cos
        M = [[mc + mp, -mp * centre * c], [-mp * centre * c, inertia + mp * centre**2]]
        bias = [mp * centre * s * v[1] ** 2, mp * g * centre * s]
        assert_close(arm.mass_matrix(q), np.array(M))
        assert_close(arm.bias_force(q, v), np.array(bias))


def test_rack_and_pinion_adds_the_moving_mass_to_the_inertia(urdf: Callable[..., Path]) -> None:
    radius, mass, wheel = 0.05, 3.0, 0.02
    pinion = joint("pinion", "base", "wheel", "continuous", AXIS_Y + LIMIT)
    mimic = f'<mimic joint="pinion" multiplier="{radius}" offset="0.1"/>'
    rack = joint("rack", "base", "bar", "prismatic", f'<axis xyz="0 0 1"/>{LIMIT}{mimic}')
    bodies = link("wheel", 1, "0 0 0", iyy=wheel, ixx=wheel, izz=wheel) + link("bar", mass)
    arm = load_arm(urdf(robot(BASE, bodies, pinion, rack)))
    assert arm.joint_names == ("pinion",)
    assert_close(arm.mass_matrix(np.zeros(1)), np.array([[wheel + mass * radius**2]]))
    assert_close(arm.potential_force(np.zeros(1)), np.array([mass * 9.81 * radius]))


def test_mimics_of_mimics_compose_whatever_their_order(urdf: Callable[..., Path]) -> None:
    def chain(name: str, parent: str, child: str, mimic: str) -> str:
        return joint(name, parent, child, "revolute", AXIS_Y + LIMIT + mimic)

    last = chain("c", "l2", "l3", '<mimic joint="b" multiplier="3" offset="0.5"/>')
    middle = chain("b", "l1", "l2", '<mimic joint="a" multiplier="-2" offset="0.25"/>')
    first = chain("a", "base", "l1", "")
    arm = load_arm(urdf(robot(BASE, link("l1"), link("l2"), link("l3"), last, middle, first)))
    assert arm.joint_names == ("a",)
    np.testing.assert_array_equal(arm.G, [[1.0], [-2.0], [-6.0]])
    np.testing.assert_array_equal(arm.g0, [0.0, 0.25, 1.25])


def test_a_mimic_of_a_locked_or_fixed_joint_stands_still(urdf: Callable[..., Path]) -> None:
    inside = f'{AXIS_Y}{LIMIT}<mimic joint="leader" multiplier="2" offset="0.25"/>'
    tip = joint("tip", "lower", "hand", "revolute", inside)
    bodies = LINKS + link("hand")
    locked = joint("leader", "upper", "lower")
    arm = load_arm(urdf(robot(bodies, SHOULDER, locked, tip)), lock={"leader": 0.5})
    assert arm.joint_names == ("shoulder",)
    np.testing.assert_array_equal(arm.g0, [0.0, 0.5, 1.25])
    np.testing.assert_array_equal(arm.G, [[1.0], [0.0], [0.0]])
    fixed = joint("leader", "upper", "lower", "fixed")
    arm = load_arm(urdf(robot(bodies, SHOULDER, fixed, tip)))
    np.testing.assert_array_equal(arm.g0, [0.0, 0.25])


@pytest.mark.parametrize(
    "lock",
    ["elbow", ["elbow"], ("elbow",), {"elbow"}, iter(["elbow"]), {"elbow": 0.0}],
    ids=["name", "list", "tuple", "set", "iterator", "mapping"],
)
def test_joints_to_lock_may_be_given_in_any_way(urdf: Callable[..., Path], lock: object) -> None:
    arm = load_arm(urdf(with_elbow(AXIS_Y + LIMIT)), lock=lock)  # type: ignore[arg-type]
    rigid = load_arm(urdf(with_elbow("", "fixed")))
    assert arm.joint_names == ("shoulder",)
    assert_same_robot(arm, rigid)


def test_a_joint_locked_by_name_is_held_where_its_home_is() -> None:
    file = catalogue()["panda"].path()
    free = load_arm(file)
    elbow = free.joint_names.index("panda_joint4")  # its range, -3.07 to -0.07, excludes zero
    arm = load_arm(file, lock="panda_joint4")
    assert free.lower[elbow] < arm.g0[elbow] < free.upper[elbow]
    assert arm.g0[elbow] == free.home[elbow]
    listed = load_arm("panda", lock="panda_joint4")
    assert listed.g0[elbow] == catalogue()["panda"].home["panda_joint4"]
    assert load_arm("panda", lock={"panda_joint4": np.float32(-1.5)}).g0[elbow] == -1.5
