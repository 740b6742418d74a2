"""Arms on a moving base against MuJoCo: the same URDF, its base driven along a prescribed motion.

MuJoCo's mass matrix and bias force of the arm with a base that is free to move give the joint
accelerations under a prescribed acceleration of the base,

    q'' = M_qq^-1 (tau - bias_q - M_qb a_base),

in which the base's own inertia does not occur. MuJoCo's free joint takes linear velocities in
world axes and angular ones in the base's.
"""

import mujoco
import numpy as np
import pytest
from lxml import etree
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ftcfa import (
    BaseAcceleration,
    BaseMotion,
    ClosedLoop,
    Constant,
    Harmonic,
    Record,
    RecordedAcceleration,
    Vibration,
    load_arm,
    simulate,
)
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.vibration.inputs.noise_input import StepIntegrals

MASSLESS = 1e-12
"""MuJoCo's stand-in for no mass and no rotational inertia [kg, kg m^2]."""
ACCELERATION = 1e-8
"""Of joint accelerations, relative to the largest."""
STATES = 50
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
PENDULUM_MAP = {"shoulder": (1.0, 0.0), "carrier_joint": (-1.0, 0.0), "elbow": (0.0, 1.0)}


def mujoco_model(robot, base):
    """The URDF of a named arm in MuJoCo, on a base joint of its own: floating, or three slides."""
    root = etree.parse(catalogue()[robot].path()).getroot()
    for tag in ("visual", "collision", "transmission", "gazebo", "mimic", "material"):
        for element in list(root.iter(tag)):
            element.getparent().remove(element)
    for joint in root.findall("joint"):
        if joint.get("name") in FINGERS:  # locked at zero
            joint.set("type", "fixed")
    children = {joint.find("child").get("link") for joint in root.findall("joint")}
    (bottom,) = [x.get("name") for x in root.findall("link") if x.get("name") not in children]
    above = "world"
    etree.SubElement(root, "link", name=above)
    stages = [("floating", None)] if base == "floating" else [("prismatic", a) for a in np.eye(3)]
    for k, (kind, axis) in enumerate(stages):
        below = bottom if k == len(stages) - 1 else f"slide_{k}"
        if below != bottom:
            etree.SubElement(root, "link", name=below)
        joint = etree.SubElement(root, "joint", name=f"base_{k}", type=kind)
        etree.SubElement(joint, "parent", link=above)
        etree.SubElement(joint, "child", link=below)
        if axis is not None:
            etree.SubElement(joint, "axis", xyz=" ".join(map(str, axis)))
            etree.SubElement(joint, "limit", lower="-9", upper="9", effort="1", velocity="1")
        above = below
    _give_mass(root)
    settings = etree.SubElement(etree.SubElement(root, "mujoco"), "compiler")
    settings.set("fusestatic", "false")
    settings.set("balanceinertia", "false")
    return mujoco.MjModel.from_xml_string(etree.tostring(root).decode())


def _give_mass(root):
    for link in root.findall("link"):
        if link.get("name") == "world":
            continue
        body = link.find("inertial")
        if body is None:
            body = etree.SubElement(link, "inertial")
            etree.SubElement(body, "mass", value="0")
            etree.SubElement(body, "inertia")
        mass, inertia = body.find("mass"), body.find("inertia")
        mass.set("value", repr(float(mass.get("value")) + MASSLESS))
        for entry in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
            share = MASSLESS if entry[1] == entry[2] else 0.0
            inertia.set(entry, repr(float(inertia.get(entry, "0")) + share))


class Oracle:
    """Joint accelerations of an arm by MuJoCo on a base of prescribed motion."""

    def __init__(self, robot, base):
        self.model = mujoco_model(robot, base)
        self.data = mujoco.MjData(self.model)
        self.base = 6 if base == "floating" else 3
        names = [self.model.joint(i).name for i in range(self.model.njnt)]
        joints = names[1 if base == "floating" else 3 :]
        if robot == "double_pendulum":
            self.G = np.array([PENDULUM_MAP[name] for name in joints])
        else:
            self.G = np.eye(len(joints))

    def acceleration(self, q, v, position, velocity, base_acceleration, gravity, tau=0.0):
        """q'' for base position (xyz, or xyz and quaternion), velocity and acceleration."""
        model, data, b = self.model, self.data, self.base
        model.opt.gravity[:] = gravity
        data.qpos[:] = np.concatenate([position, self.G @ q])
        data.qvel[:] = np.concatenate([velocity, self.G @ v])
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        M = self.G.T @ full[b:, b:] @ self.G
        load = data.qfrc_bias[b:] - data.qfrc_passive[b:] + full[b:, :b] @ base_acceleration
        return np.linalg.solve(M, tau - self.G.T @ load)


class Held:
    """No controller: a constant torque, that of gravity at home, lest a second be a free fall."""

    def __init__(self, arm):
        self.torque = arm.potential_force(arm.home)

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        return {"u": self.torque}, state


def arm_of(robot, **options):
    lock = {FINGERS[0]: 0.0} if robot == "panda" else None
    return load_arm(robot, lock=lock, **options)


def relative(ours, theirs):
    return np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs))


def final_state(loop):
    path = simulate(loop, 1.0)
    return np.concatenate([path.q.values[-1], path.v.values[-1]])


def assert_integration_error_only(run, truth):
    """The error of Euler's method halves with the step, and extrapolation takes it away."""
    coarse, fine = run(2.5e-4), run(1.25e-4)
    assert relative(coarse, truth) < 0.05
    assert np.linalg.norm(coarse - truth) / np.linalg.norm(fine - truth) == pytest.approx(
        2, abs=0.1
    )
    assert relative(2 * fine - coarse, truth) < 2e-3


@pytest.mark.parametrize("robot", ["panda", "double_pendulum"])
def test_accelerations_on_a_base_that_slides(robot):
    arm, oracle, rng = arm_of(robot), Oracle(robot, "slides"), np.random.default_rng(0)
    for _ in range(STATES):
        q, v = rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n)
        a, position, velocity = 5.0 * rng.standard_normal((3, 3))
        ours = arm.forward_dynamics(q, v, BaseAcceleration().matrix(arm, q) @ a)
        theirs = oracle.acceleration(q, v, position, velocity, a, arm.gravity)
        assert relative(ours, theirs) < ACCELERATION


@pytest.mark.parametrize("robot", ["panda", "double_pendulum"])
def test_accelerations_on_a_base_that_turns(robot):
    arm, oracle, rng = arm_of(robot), Oracle(robot, "floating"), np.random.default_rng(1)
    for _ in range(STATES):
        q, v = rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n)
        a, turning, omega, at, velocity = 3.0 * rng.standard_normal((5, 3))
        R = Rotation.random(rng=rng)
        quaternion = R.as_quat(scalar_first=True)
        h, still = 1e-3, np.zeros(3)
        integrals = StepIntegrals(
            h * np.concatenate([a, turning]),
            np.concatenate([still, omega]),
            np.concatenate([still, R.as_rotvec()]),
        )
        impulse, _ = BaseMotion().impulse(arm, q, v, BaseMotion().init(), integrals, h)
        theirs = oracle.acceleration(
            q, v, np.concatenate([at, quaternion]), np.concatenate([velocity, omega]),
            np.concatenate([R.apply(a), turning]), arm.gravity,
        )  # fmt: skip
        assert relative(arm.forward_dynamics(q, v, impulse / h), theirs) < ACCELERATION


@pytest.mark.parametrize("mounting", ["wall", "ceiling"])
def test_accelerations_of_an_arm_on_a_wall_and_at_the_ceiling(mounting):
    """The base of MuJoCo's model stands turned; gravity and shaking are in world axes."""
    arm, oracle, rng = arm_of("panda", mounting=mounting), Oracle("panda", "floating"), np.random
    turned = {"wall": [0.0, np.pi / 2, 0.0], "ceiling": [np.pi, 0.0, 0.0]}[mounting]
    quaternion = Rotation.from_rotvec(turned).as_quat(scalar_first=True)
    rng = rng.default_rng(2)
    still = np.zeros(6)
    for _ in range(STATES):
        q, v = rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n)
        a = 5.0 * rng.standard_normal(3)
        ours = arm.forward_dynamics(q, v, BaseAcceleration().matrix(arm, q) @ a)
        theirs = oracle.acceleration(
            q, v, np.concatenate([still[:3], quaternion]), still,
            np.concatenate([a, still[:3]]), arm.gravity,
        )  # fmt: skip
        assert relative(ours, theirs) < ACCELERATION


@pytest.mark.parametrize("robot", ["panda", "double_pendulum"])
def test_a_second_on_a_base_driven_along_a_record(robot):
    arm, oracle = arm_of(robot), Oracle(robot, "slides")
    tau = Held(arm).torque

    def record(step):
        t = step * np.arange(round(1 / step) + 1)
        waves = [3 * np.sin(40 * t), 4 * np.cos(25 * t), 5 * np.sin(60 * t + 1)]
        return Record(step, np.stack(waves, axis=1))

    exact = record(1e-5).detrended().values

    def acceleration(now):
        return np.array([np.interp(now, np.linspace(0, 1, len(exact)), x) for x in exact.T])

    def motion(now, y):
        (q, v), (at, velocity) = np.split(y[: 2 * arm.n], 2), np.split(y[2 * arm.n :], 2)
        a = acceleration(now)  # straight lines between samples, as the record is read
        vdot = oracle.acceleration(q, v, at, velocity, a, arm.gravity, tau)
        return np.concatenate([v, vdot, velocity, a])

    start = np.concatenate([arm.home, np.zeros(arm.n + 6)])
    truth = solve_ivp(motion, (0, 1), start, rtol=1e-7, atol=1e-9, max_step=5e-3).y[: 2 * arm.n, -1]

    def run(step):
        vibration = Vibration(BaseAcceleration(), RecordedAcceleration(record(step), False))
        return final_state(ClosedLoop(arm, Held(arm), Constant(arm.home), vibration, period=step))

    assert_integration_error_only(run, truth)


@pytest.mark.parametrize("robot", ["panda", "double_pendulum"])
def test_a_second_on_a_base_that_slides_and_turns(robot):
    arm, oracle = arm_of(robot), Oracle(robot, "floating")
    tau = Held(arm).torque
    amplitude = np.array([3.0, 4.0, 5.0, 3.0, 2.0, 2.0])
    frequency, phase = np.array([5.0, 4.0, 7.0, 2.0, 1.5, 1.0]), np.arange(6.0)
    w = 2 * np.pi * frequency

    def motion(now, y):
        q, v, quaternion, velocity = np.split(y, [arm.n, 2 * arm.n, 2 * arm.n + 4])
        xi = amplitude * np.cos(w * now + phase)
        omega = (amplitude / w * np.sin(w * now + phase))[3:]
        R = Rotation.from_quat(quaternion, scalar_first=True)
        base = np.concatenate([R.apply(xi[:3]), xi[3:]])
        at = np.concatenate([np.zeros(3), R.as_quat(scalar_first=True)])
        vdot = oracle.acceleration(
            q, v, at, np.concatenate([velocity, omega]), base, arm.gravity, tau
        )  # fmt: skip
        real, vector = quaternion[0], quaternion[1:]
        turning = 0.5 * np.concatenate(
            [[-vector @ omega], real * omega + np.cross(vector, omega)]
        )  # fmt: skip
        return np.concatenate([v, vdot, turning, base[:3]])

    U = -(amplitude / w**2 * np.cos(phase))[3:]
    turned = Rotation.from_rotvec(U).as_quat(scalar_first=True)
    start = np.concatenate([arm.home, np.zeros(arm.n), turned, np.zeros(3)])
    truth = solve_ivp(motion, (0, 1), start, rtol=1e-8, atol=1e-9).y[: 2 * arm.n, -1]

    def run(step):
        vibration = Vibration(BaseMotion(), Harmonic(amplitude, frequency, phase))
        return final_state(ClosedLoop(arm, Held(arm), Constant(arm.home), vibration, period=step))

    assert_integration_error_only(run, truth)
