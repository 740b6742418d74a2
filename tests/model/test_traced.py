"""The traced twin of an Arm against the Arm itself, which is Pinocchio's."""

import gc
import weakref
from dataclasses import fields

import casadi as ca
import numpy as np
import pytest

from ftcfa import FTCF, ClosedLoop, Sinusoid, TracingError, load_arm, simulate
from ftcfa.model.arm import Arm
from ftcfa.model.recursions import Chain
from ftcfa.model.rigid_body import ENTRIES
from ftcfa.model.symbols import symbols
from ftcfa.model.traced import TracedArm
from ftcfa.model.twins import traced
from ftcfa.model.urdf.catalogue import catalogue

AGREEMENT = 1e-12
"""Relative to the largest entry: two recursions over a dozen bodies, rounded differently."""
LINEAR = 1e-12
"""Relative: sums of products of the same numbers in another order."""
NOTHING = 1e-14
"""What rounding may leave where the truth is zero, such as gravity on a vertical axis [SI]."""
STATES = 5

BOX = '<inertia ixx="0.03" ixy="0.004" ixz="-0.002" iyy="0.05" iyz="0.003" izz="0.04"/>'


def link(name, mass=1.0, centre="0.1 -0.05 0.2"):
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}" rpy="0.3 -0.2 0.5"/>'
        f'<mass value="{mass}"/>{BOX}</inertial></link>'
    )


def joint(name, parent, child, kind="revolute", axis="0 0 1", more="", origin="0.2 0.1 0.4"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}" rpy="0.4 0.7 -0.3"/><axis xyz="{axis}"/>'
        f'<limit lower="-2" upper="2" effort="20" velocity="3"/>{more}</joint>'
    )


def robot(*parts):
    return f'<robot name="made"><link name="base"/>{"".join(parts)}</robot>'


GANTRY = robot(
    link("bridge", 20.0),
    link("trolley", 5.0),
    link("hoist", 2.0),
    link("load", 3.0),
    joint("x", "base", "bridge", "prismatic", "1 0 0"),
    joint("y", "bridge", "trolley", "prismatic", "0 -1 0", '<dynamics damping="2"/>'),
    joint("swing", "trolley", "hoist", "revolute", "0 1 0", '<dynamics friction="0.3"/>'),
    joint("hook", "hoist", "load", "prismatic", "0 0 -1"),
)
SKEW_AXES = robot(
    *(link(f"l{i}", 1.0 + i) for i in range(4)),
    joint("a", "base", "l0", axis="1 2 3"),
    joint("b", "l0", "l1", "prismatic", "-2 0.5 1"),
    joint("c", "l1", "l2", "continuous", "0.3 -1 0.2"),
    joint("d", "l2", "l3", axis="-1 0 0"),
)
MIMICS = robot(
    *(link(f"l{i}", 1.0 + i) for i in range(5)),
    joint("lead", "base", "l0", axis="0 1 0"),
    joint("half", "l0", "l1", more='<mimic joint="lead" multiplier="-0.5" offset="0.3"/>'),
    joint("quarter", "l1", "l2", "prismatic", "0 1 1", '<mimic joint="half" multiplier="2"/>'),
    joint("free", "l2", "l3", axis="0 1 0", more='<dynamics damping="0.4" friction="0.2"/>'),
    joint("back", "l3", "l4", more='<mimic joint="free" multiplier="3" offset="-1"/>'),
)
BRANCHED = robot(
    *(link(name, mass) for name, mass in zip("tlrwv", (9, 3, 2, 1, 1.5), strict=True)),
    joint("torso", "base", "t", axis="0 0 1"),
    joint("left", "t", "l", axis="1 0 0"),
    joint("right", "t", "r", "prismatic", "0 1 0"),
    joint("left_wrist", "l", "w", axis="0 1 1"),
    joint("left_thumb", "l", "v", axis="0 -1 0"),
)
MADE = {
    "gantry": (GANTRY, {}),
    "skew axes": (SKEW_AXES, {}),
    "mimics": (MIMICS, {}),
    "mimics, one leader locked": (MIMICS, {"lead": 0.7}),
    "branched": (BRANCHED, {}),
    "branched, torso locked": (BRANCHED, {"torso": -1.1}),
    "branched, forks locked": (BRANCHED, {"left": 0.9, "right": 0.4}),
    "gantry, inside locked": (GANTRY, {"y": 0.8, "swing": -0.6}),
    "skew axes, ends locked": (SKEW_AXES, {"a": 0.5, "d": 1.2}),
}


@pytest.fixture(scope="module", params=[*MADE, "panda with its gripper", *catalogue()])
def any_arm(request, tmp_path_factory):
    """Every arm of the catalogue, and made ones with all that the catalogue lacks."""
    if request.param in catalogue():
        return load_arm(request.param)
    if request.param == "panda with its gripper":
        return load_arm(str(catalogue()["panda"].path()))
    text, locks = MADE[request.param]
    file = tmp_path_factory.mktemp("urdf") / "made.urdf"
    file.write_text(text)
    return load_arm(str(file), lock=locks, gravity=[1.0, -2.0, -9.5])


@pytest.fixture
def gantry(tmp_path):
    file = tmp_path / "gantry.urdf"
    file.write_text(GANTRY)
    return load_arm(str(file), lock={"y": 0.8})


def numbers(expression, shape):
    return np.asarray(expression, dtype=float).reshape(shape)


def states(arm, count=STATES):
    rng = np.random.default_rng(7)
    return [(rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n)) for _ in range(count)]


def assert_same(name, expression, truth, tolerance=AGREEMENT):
    error = np.max(np.abs(numbers(expression, truth.shape) - truth))
    assert error <= tolerance * np.max(np.abs(truth)) + NOTHING, name


def assert_twins(twin, arm, tolerance=AGREEMENT):
    for q, v in states(arm):
        for name, arguments in {
            "mass_matrix": (q,),
            "coriolis_matrix": (q, v),
            "potential_force": (q,),
            "damping_matrix": (v,),
            "friction_force": (v,),
            "bias_force": (q, v),
            "base_coupling": (q,),
        }.items():
            got, truth = getattr(twin, name)(*arguments), getattr(arm, name)(*arguments)
            assert_same(name, got, truth, tolerance)


def test_every_quantity_equals_pinocchios(any_arm):
    twin = traced(any_arm)
    assert_twins(twin, any_arm)
    for name in ("n", "joint_names", "joint_types"):
        assert getattr(twin, name) == getattr(any_arm, name)
    for name in ("home", "lower", "upper", "velocity_limit", "effort_limit"):
        np.testing.assert_array_equal(getattr(twin, name), getattr(any_arm, name))


def test_forward_dynamics_equals_the_arms(any_arm):
    twin = traced(any_arm)
    # M^-1 amplifies the rounding of M and of the forces by the condition number of M.
    for q, v in states(any_arm, 3):
        tau = np.cos(np.arange(any_arm.n))
        tolerance = AGREEMENT * np.linalg.cond(any_arm.mass_matrix(q))
        got, truth = (x.forward_dynamics(q, v, tau) for x in (twin, any_arm))
        assert_same("forward dynamics", got, truth, tolerance)


def test_symbols_go_in_and_shapes_are_numpys():
    arm = load_arm("panda")
    q, v, n = symbols("q", 7), symbols("v", 7), 7
    twin = traced(arm)
    assert twin.mass_matrix(q).shape == (n, n)
    assert twin.coriolis_matrix(q, v).shape == (n, n)
    assert twin.damping_matrix(v).shape == (n, n)
    assert twin.base_coupling(q).shape == (n, 6)
    for force in (twin.potential_force(q), twin.bias_force(q, v), twin.friction_force(v)):
        assert force.shape == (n,)


def test_a_single_joint():
    arm = load_arm("panda", lock=[f"panda_joint{i}" for i in range(2, 8)])
    assert arm.n == 1
    assert_twins(traced(arm), arm)


def test_other_inertias_fold_in_like_another_arm(any_arm):
    other = any_arm.perturbed(np.random.default_rng(5))
    twin = traced(any_arm)
    assert_twins(twin.with_bodies(twin.regrouped(other.inertias[None])[0]), other)


def test_inertias_as_symbols_equal_constants(any_arm):
    twin = traced(any_arm)
    p = symbols("p", ENTRIES * len(twin.chain.parents))
    q, v = symbols("q", any_arm.n), symbols("v", any_arm.n)
    open_twin = twin.with_bodies(p)
    outputs = [open_twin.mass_matrix(q), open_twin.bias_force(q, v), open_twin.base_coupling(q)]
    arguments = [x.to_casadi() for x in (q, v, p)]
    evaluate = ca.Function("f", arguments, [x.to_casadi() for x in outputs])
    other = any_arm.perturbed(np.random.default_rng(6))
    for arm in (any_arm, other):
        bodies = twin.regrouped(arm.inertias[None])[0]
        for q_now, v_now in states(arm, 2):
            M, bias, coupling = evaluate(q_now, v_now, bodies)
            assert_same("M", M, arm.mass_matrix(q_now))
            assert_same("bias", bias, arm.bias_force(q_now, v_now))
            assert_same("coupling", coupling, arm.base_coupling(q_now))


def test_regrouping_is_linear(any_arm):
    prepare = traced(any_arm).regrouped
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((2, 1, *any_arm.inertias.shape))
    scale = np.max(np.abs(prepare(x))) + np.max(np.abs(prepare(y)))
    error = prepare(2.0 * x - 3.0 * y) - (2.0 * prepare(x) - 3.0 * prepare(y))
    assert np.max(np.abs(error)) <= LINEAR * scale
    many = prepare(np.concatenate([x, y, x]))
    np.testing.assert_allclose(many[[0, 2]], np.repeat(prepare(x), 2, axis=0), atol=LINEAR * scale)
    assert prepare(np.zeros((0, *any_arm.inertias.shape))).shape == (0, many.shape[1])


def test_regrouping_leaves_out_what_no_joint_feels():
    # The first joint of a fixed-base arm about z feels of its body no more than m c_x, m c_y and
    # the differences of its rotational inertias: of 10 parameters none is mass or height.
    arm = load_arm("panda", lock=[f"panda_joint{i}" for i in range(2, 8)])
    felt = traced(arm).chain.regrouping.any(axis=1)
    mass_and_height = [0, 3]
    assert not felt[mass_and_height].any()


@pytest.mark.parametrize(
    ("method", "quantity"),
    [
        ("mass_matrix", "mass matrix"),
        ("bias_force", "bias force"),
        ("potential_force", "potential force"),
        ("base_coupling", "base coupling"),
    ],
)
def test_a_twin_that_disagrees_is_refused(monkeypatch, method, quantity):
    truth = getattr(Arm, method)
    monkeypatch.setattr(Arm, method, lambda *args: truth(*args) * (1 + 1e-8))
    arm = load_arm("ur5")
    with pytest.raises(TracingError) as caught:
        traced(arm)
    text = str(caught.value)
    assert f"ur5: traced {quantity}: differs from Pinocchio's by 1.0e-08 relative" in text
    assert "expected agreement to 1e-09" in text
    assert 'engine="interpreted"' in text


def test_a_wrong_recursion_is_refused(monkeypatch):
    truth = Chain.inverse_dynamics
    monkeypatch.setattr(
        Chain, "inverse_dynamics", lambda self, q, v, *a, **k: truth(self, q, 1.001 * v, *a, **k)
    )
    with pytest.raises(TracingError, match="traced bias force: differs"):
        traced(load_arm("double_pendulum"))


def test_nan_is_refused(monkeypatch):
    truth = Arm.base_coupling
    monkeypatch.setattr(Arm, "base_coupling", lambda self, q: truth(self, q) * np.nan)
    with pytest.raises(TracingError, match="traced base coupling: differs"):
        traced(load_arm("double_pendulum"))


def test_a_refused_arm_runs_interpreted(monkeypatch):
    truth = Arm.mass_matrix
    monkeypatch.setattr(Arm, "mass_matrix", lambda self, q: truth(self, q) * 1.001)
    arm = load_arm("double_pendulum")
    loop = ClosedLoop(arm, FTCF(arm), Sinusoid([0.3, 0.2]))
    with pytest.warns(UserWarning, match="running interpreted.*traced mass matrix"):
        assert simulate(loop, 0.01).attrs["engine"] == "interpreted"


def test_a_subclass_that_overrides_is_refused():
    class Heavier(Arm):
        def mass_matrix(self, q):
            return super().mass_matrix(q) + np.eye(self.n)

    arm = load_arm("double_pendulum")
    heavier = Heavier(**{field.name: getattr(arm, field.name) for field in fields(arm)})
    with pytest.raises(TracingError, match="traced mass matrix"):
        traced(heavier)


def test_a_twin_is_built_once_and_does_not_keep_its_arm():
    arm = load_arm("double_pendulum")
    twin, reference = traced(arm), weakref.ref(arm)
    assert traced(arm) is twin
    del arm
    gc.collect()
    assert reference() is None
    gone = weakref.ref(twin)
    del twin
    gc.collect()
    assert gone() is None


def test_unchecked_twin_of_welded_bodies_keeps_their_weight(gantry):
    # The locked trolley rides on the bridge: pushing the bridge moves all 30 kg.
    M = numbers(TracedArm.of(gantry).mass_matrix(np.zeros(3)), (3, 3))
    assert M[0, 0] == pytest.approx(30.0, rel=LINEAR)
