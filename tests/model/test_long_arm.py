"""The twin of a long arm against Pinocchio, and how its code grows with the number of joints."""

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate_paths,
)
from ftcfa.engine.compiler.trace import trace
from ftcfa.errors import TracingError
from ftcfa.model.arm import Arm
from ftcfa.model.long_arm import LongArm
from ftcfa.model.symbols import symbols
from ftcfa.model.turned_tree import CHEAP, TurnedTree
from ftcfa.model.twins import LONG, traced

AGREEMENT = 1e-12
"""Relative: two recursions over some twenty bodies, rounded differently."""
LINEAR_GROWTH = 2.2
"""Growth of the code when the number of joints doubles; the square would give 4."""
STEP = 0.3


def row(numbers):
    return " ".join(f"{x:.6f}" for x in numbers)


def chain(n, kinds=("revolute",), branches=(), mimic=False):
    """A chain of random joints; the links in `branches` carry a second joint each."""
    rng = np.random.default_rng(n)
    parents = [*range(n), *branches]
    parts = ['<link name="link0"/>']
    for i, parent in enumerate(parents, 1):
        axis, xyz, rpy, centre = (row(rng.uniform(-s, s, 3)) for s in (1, 0.2, 3, 0.1))
        mass, kind = 5.0 * 0.9**i, kinds[i % len(kinds)]
        follow = f'<mimic joint="joint{i - 1}" multiplier="0.5"/>' if mimic and i == n else ""
        parts.append(
            f'<joint name="joint{i}" type="{kind}"><parent link="link{parent}"/>'
            f'<child link="link{i}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" velocity="9" effort="{300 * 0.85**i + 5}"/>'
            f'<dynamics damping="0.3" friction="0.2"/>{follow}</joint>'
            f'<link name="link{i}"><inertial><origin xyz="{centre}" rpy="{rpy}"/>'
            f'<mass value="{mass}"/><inertia ixx="{mass * 0.02}" iyy="{mass * 0.015}"'
            f' izz="{mass * 0.012}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    return f'<robot name="chain">{"".join(parts)}</robot>'


@pytest.fixture
def load(tmp_path):
    def load(*args, lock=None, **kwargs):
        file = tmp_path / "chain.urdf"
        file.write_text(chain(*args, **kwargs))
        return load_arm(str(file), lock=lock or {}, gravity=[1.0, -2.0, -9.5])

    return load


@pytest.fixture(params=["turning", "with rotors", "sliding too", "branched", "locked inside"])
def long_arm(request, load):
    if request.param == "turning":
        return load(LONG)
    if request.param == "with rotors":
        return load(LONG).with_armature(np.linspace(0.0, 0.5, LONG))
    if request.param == "sliding too":
        return load(LONG + 2, ("revolute", "continuous", "prismatic"))
    if request.param == "branched":
        return load(LONG, branches=(5, 5, 9))
    return load(LONG + 2, ("revolute", "prismatic"), lock={"joint4": 0.4, "joint5": 0.1})


def states(arm, count=3):
    rng = np.random.default_rng(3)
    return [(rng.uniform(-3, 3, arm.n), *rng.standard_normal((2, arm.n))) for _ in range(count)]


def assert_same(value, truth, amplification=1.0):
    error = np.max(np.abs(np.asarray(value, dtype=float) - truth))
    assert error <= AGREEMENT * amplification * np.max(np.abs(truth))


def test_forces_and_velocities_equal_pinocchios(long_arm):
    twin = traced(long_arm)
    assert isinstance(twin, LongArm)
    for q, v, x in states(long_arm):
        M, D = long_arm.mass_matrix(q), long_arm.damping_matrix(v)
        assert_same(twin.inertial_force(q, x), M @ x)
        assert_same(twin.base_coupling(q), long_arm.base_coupling(q))
        assert_same(twin.mass_matrix(q), M)
        for step in (0.0, STEP):
            truth = np.linalg.solve(M + step * D, x)
            assert_same(twin.impulse_response(q, v, x, step), truth, np.linalg.cond(M))


def test_forward_dynamics_is_that_of_pinocchios_articulated_bodies(load):
    arm = load(LONG)
    data = arm.model.createData()
    for q, v, tau in states(arm):
        truth = pin.aba(arm.model, data, q, v, tau - arm.friction_force(v))
        assert_same(traced(arm).forward_dynamics(q, v, tau), truth, np.linalg.cond(data.M))


def test_inertias_as_symbols_equal_constants(long_arm):
    twin = traced(long_arm)
    other = long_arm.perturbed(np.random.default_rng(6))
    bodies = twin.regrouped(other.inertias[None])[0]
    p, q, x = symbols("p", len(bodies)), symbols("q", long_arm.n), symbols("x", long_arm.n)
    open_twin = twin.with_bodies(p)
    outputs = [
        open_twin.inertial_force(q, x),
        open_twin.impulse_response(q, x, x, STEP),
        open_twin.base_coupling(q),
    ]
    code = ca.Function("f", [a.to_casadi() for a in (p, q, x)], [a.to_casadi() for a in outputs])
    for now, velocity, _ in states(other):
        force, change, coupling = map(np.asarray, code(bodies, now, velocity))
        M, D = other.mass_matrix(now), other.damping_matrix(velocity)
        assert_same(force.ravel(), M @ velocity)
        truth = np.linalg.solve(M + STEP * D, velocity)
        assert_same(change.ravel(), truth, np.linalg.cond(M))
        assert_same(coupling, other.base_coupling(now))


def loop_of(arm):
    return ClosedLoop(
        arm.perturbed(np.random.default_rng(1)),
        FTCF(arm, compensation="bias"),
        Sinusoid(amplitude=0.2, offset=arm.home),
        vibration=Vibration(BaseAcceleration(), WhiteNoise(0.01)),
    )


def test_the_code_of_a_loop_grows_with_the_number_of_joints(load):
    counts = [trace(loop_of(load(n)), ("q",)).first.n_instructions() for n in (LONG, 2 * LONG)]
    assert counts[1] <= LINEAR_GROWTH * counts[0]


def test_a_loop_compiled_is_the_loop_interpreted(load):
    loop = loop_of(load(LONG, ("revolute", "prismatic"), branches=(3,)))
    found = [simulate_paths(loop, 2, 0.05, engine=engine) for engine in ("compiled", "interpreted")]
    for name in ("q", "v", "u"):
        np.testing.assert_allclose(found[0][name], found[1][name], rtol=1e-9, atol=1e-9)


def test_coordinates_that_move_several_joints_keep_the_matrix(load):
    assert not isinstance(traced(load(LONG + 3, mimic=True)), LongArm)


def test_many_short_limbs_keep_the_matrix(load):
    assert not isinstance(traced(load(6, branches=[0, *range(7, 11), 0, *range(12, 16)])), LongArm)


@pytest.mark.parametrize(
    ("method", "quantity"),
    [("mass_matrix", "inertial force"), ("damping_matrix", "impulse response")],
)
def test_a_twin_that_disagrees_is_refused(monkeypatch, load, method, quantity):
    truth = getattr(Arm, method)
    monkeypatch.setattr(Arm, method, lambda *args: truth(*args) * (1 + 1e-6))
    with pytest.raises(TracingError, match=f"chain: traced {quantity}: differs from Pinocchio's"):
        traced(load(LONG))


def test_rotations_to_first_children_are_cheap(load):
    tree = load(LONG, branches=(4,)).tree()
    frames = TurnedTree(tree, list(range(LONG + 1)), np.zeros(LONG + 1))
    q = ca.SX.sym("q")
    dear = [i for i in range(LONG + 1) if np.count_nonzero(frames.joint_frame(i, q).R) > CHEAP]
    first = {tree.parents.index(p) for p in set(tree.parents) if p >= 0}
    assert not first.intersection(dear)
    assert len(dear) == 2  # the joint in the base, and a second child
