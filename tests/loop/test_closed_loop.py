"""The closed loop: what it refuses, and how controller, saturation, noise and plant interlock."""

from dataclasses import dataclass

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    MinimumJerk,
    PaperPendulum,
    ParameterError,
    ShapeError,
    Sinusoid,
    Table,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
)
from ftcfa.control.protocol import Desired, Measured
from ftcfa.description.write import NOT_REBUILDABLE, provenance
from ftcfa.loop.plant import INTEGRATORS
from ftcfa.loop.state import DIVERGED, LoopState, Motion, bounded

STILL = Desired(np.zeros(2), np.zeros(2), np.zeros(2))
HELD = Constant([0.0, 0.0])


@dataclass(frozen=True)
class Push:
    """A user's law: one and the same torque, and a count of its samples as its state."""

    torque: tuple[float, float]

    def init(self, measured, desired):
        return 0

    def step(self, state, measured, desired, period):
        return {"u": np.array(self.torque), "count": np.array(state)}, state + 1


def pendulum_loop(**changes):
    settings = {"arm": PaperPendulum(), "controller": Push((1.0, -2.0)), "reference": HELD}
    return ClosedLoop(**{**settings, **changes})


@pytest.mark.parametrize("period", [0.0, -1e-3, np.nan, np.inf, "1 ms", None])
def test_bad_periods_are_refused(period):
    with pytest.raises(ParameterError, match=r"period: .*, expected a number > 0 \[s\]"):
        pendulum_loop(period=period)


@pytest.mark.parametrize("substeps", [0, -1, 2.0, 1.5, True, "two", None, np.nan])
def test_bad_substeps_are_refused(substeps):
    with pytest.raises(ParameterError, match=r"substeps: .*, expected an integer >= 1"):
        pendulum_loop(substeps=substeps)


def test_an_unknown_integrator_lists_the_known_ones():
    with pytest.raises(UnknownNameError, match=r"integrator 'rk4'.*euler-maruyama, semi-implicit"):
        pendulum_loop(integrator="rk4")


@pytest.mark.parametrize(
    "reference",
    [
        Constant(np.zeros(3)),
        Sinusoid([0.1, 0.2, 0.3]),
        MinimumJerk([0, 1], np.zeros((2, 3))),
        Table([0, 1], np.zeros((2, 3))),
    ],
)
def test_a_reference_of_other_joints_is_refused_by_their_names(reference):
    with pytest.raises(ShapeError, match="reference: 3 joints, expected 2: shoulder, elbow"):
        pendulum_loop(reference=reference)


@pytest.mark.parametrize("name", ["q0", "v0"])
@pytest.mark.parametrize("value", [[0.0] * 3, [[0.0, 0.0]], [0.0, np.nan], "here", [0.0, "x"]])
def test_bad_initial_states_are_refused(name, value):
    with pytest.raises(ShapeError, match=name):
        pendulum_loop(**{name: value})


def test_it_starts_at_home_at_rest_by_default():
    arm = load_arm("panda")
    loop = ClosedLoop(arm, FTCF(arm), Constant(arm.home))
    state = loop.init(Desired(arm.home, np.zeros(7), np.zeros(7)))
    np.testing.assert_array_equal(state.q, arm.home)
    np.testing.assert_array_equal(state.v, 0.0)
    state = pendulum_loop(q0=0.3, v0=[0.1, 0.2]).init(STILL)
    np.testing.assert_array_equal(state.q, [0.3, 0.3])
    np.testing.assert_array_equal(state.v, [0.1, 0.2])


def test_a_copy_of_the_initial_state_is_kept():
    q0 = np.array([0.1, 0.2])
    loop = pendulum_loop(q0=q0)
    q0[:] = 9.0
    np.testing.assert_array_equal(loop.q0, [0.1, 0.2])


def test_the_torque_is_clipped_at_the_limits_of_the_true_arm():
    weak = PaperPendulum(effort_limit=np.array([0.5, 1.5]))
    loop = pendulum_loop(arm=weak)
    signals, _ = loop.step(loop.init(STILL), STILL, np.zeros((1, 0)))
    np.testing.assert_array_equal(signals["u_command"], [1.0, -2.0])
    np.testing.assert_array_equal(signals["u"], [0.5, -1.5])


@pytest.mark.parametrize("integrator", list(INTEGRATORS))
def test_one_sample_is_the_integrator_with_the_clipped_torque(integrator):
    arm = PaperPendulum()
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(0.1))
    loop = pendulum_loop(
        vibration=vibration, integrator=integrator, controller=Push((99.0, -2.0)), q0=0.4, v0=0.1
    )
    normals = np.array([[0.7, -1.3]])
    _, after = loop.step(loop.init(STILL), STILL, normals)
    q, v = np.array([0.4, 0.4]), np.array([0.1, 0.1])
    tau = np.array([15.0, -2.0])
    impulse = np.sqrt(0.1) * -arm.base_coupling(q)[:, [0, 2]] @ normals[0] * np.sqrt(1e-3)
    dv = np.linalg.solve(arm.mass_matrix(q), 1e-3 * (tau - arm.bias_force(q, v)) + impulse)
    np.testing.assert_allclose(after.v, v + dv, rtol=1e-13)
    moved_with = v if integrator == "euler-maruyama" else v + dv
    np.testing.assert_allclose(after.q, q + 1e-3 * moved_with, rtol=1e-13)


@pytest.mark.parametrize("integrator", list(INTEGRATORS))
def test_substeps_are_steps_of_the_plant_under_one_torque(integrator):
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(0.1))
    normals = np.random.default_rng(0).standard_normal((4, 2))
    coarse = pendulum_loop(
        vibration=vibration, integrator=integrator, period=4e-3, substeps=4, q0=0.4
    )
    _, state = coarse.step(coarse.init(STILL), STILL, normals)
    assert state.controller == 1
    fine = pendulum_loop(vibration=vibration, integrator=integrator, period=1e-3, q0=0.4)
    expected = fine.init(STILL)
    for row in normals:
        _, expected = fine.step(expected, STILL, row[None, :])
    np.testing.assert_array_equal(state.q, expected.q)
    np.testing.assert_array_equal(state.v, expected.v)


def test_a_sample_gives_what_was_measured_at_its_start():
    loop = pendulum_loop(q0=0.4, v0=0.1)
    desired = Desired(np.array([0.3, 0.2]), np.zeros(2), np.zeros(2))
    signals, _ = loop.step(loop.init(desired), desired, np.zeros((1, 0)))
    np.testing.assert_array_equal(signals["q"], [0.4, 0.4])
    np.testing.assert_array_equal(signals["v"], [0.1, 0.1])
    np.testing.assert_array_equal(signals["q_d"], [0.3, 0.2])


def test_the_controller_gets_measurement_reference_and_period_and_nothing_of_the_true_arm():
    seen = []

    class Spy(Push):
        def step(self, state, *arguments):
            seen.append(arguments)
            return super().step(state, *arguments)

    desired = Desired(np.array([0.3, 0.2]), np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    heavy = PaperPendulum(m=(6.0, 8.0))
    loop = pendulum_loop(arm=heavy, controller=Spy((0.0, 0.0)), q0=0.4, period=2e-3)
    loop.step(loop.init(desired), desired, np.zeros((1, 0)))
    ((q, v, _), given, period) = seen[0]
    np.testing.assert_array_equal(q, [0.4, 0.4])
    np.testing.assert_array_equal(v, 0.0)
    assert given is desired
    assert period == 2e-3


def test_the_torque_depends_on_the_nominal_arm_and_not_on_the_true_one():
    nominal, true = PaperPendulum(), PaperPendulum(m=(0.9, 1.2))
    law = FTCF(nominal)
    torques = [
        ClosedLoop(arm, law, HELD, q0=0.1).step(
            LoopState(
                Motion(np.full(2, 0.1), np.zeros(2)),
                law.init(Measured(np.full(2, 0.1), np.zeros(2)), STILL),
            ),
            STILL,
            np.zeros((1, 0)),
        )[0]["u"]
        for arm in (nominal, true)
    ]
    np.testing.assert_array_equal(*torques)


def test_signal_shapes_are_those_of_a_sample():
    shapes = pendulum_loop().signal_shapes()
    assert shapes["count"] == ()
    assert {shapes[name] for name in ("q", "q_d", "v", "u", "u_command")} == {(2,)}


@pytest.mark.parametrize(
    ("q", "v", "expected"),
    [
        ([0.0, 0.0], [0.0, 0.0], True),
        ([0.999 * DIVERGED, 0.0], [0.0, -0.999 * DIVERGED], True),
        ([1.001 * DIVERGED, 0.0], [0.0, 0.0], False),
        ([0.0, 0.0], [0.0, -1.001 * DIVERGED], False),
        ([np.nan, 0.0], [0.0, 0.0], False),
        ([0.0, 0.0], [0.0, np.nan], False),
        ([0.0, np.inf], [0.0, 0.0], False),
        ([0.0, 0.0], [-np.inf, 0.0], False),
    ],
)
def test_a_state_is_bounded_while_it_is_finite_and_within_bounds(q, v, expected):
    assert bounded(LoopState(Motion(np.array(q), np.array(v)), None)) == expected


def test_a_description_is_plain_data():
    arm = load_arm("double_pendulum", gravity=9.8)
    loop = ClosedLoop(
        arm,
        FTCF(PaperPendulum()),
        Sinusoid([1.5, 1.0], [1.0, 2.0]),
        Vibration(BaseAcceleration("xz"), WhiteNoise([[0.1, 0.0], [0.0, 0.2]], "amplitude")),
        q0=[-0.1, 0.25],
    )
    document = provenance(loop)
    assert document["arm"]["type"] == "Arm"
    assert document["arm"]["robot"] == "double_pendulum"
    assert document["arm"]["gravity"] == [0.0, 0.0, -9.8]
    assert document["q0"] == [-0.1, 0.25]
    assert document["controller"]["gains"]["c2"] == 25.0
    assert document["controller"]["filter"] == {"type": "ImplicitFilter", "r1": 750.0, "r2": 180.0}
    assert document["controller"]["nominal"]["m"] == [0.6, 0.8]
    assert document["reference"]["angular_frequency"] == [1.0, 2.0]
    assert document["vibration"]["input"] == {"type": "BaseAcceleration", "axes": "xz"}
    assert document["vibration"]["excitation"]["intensity"] == [[0.1, 0.0], [0.0, 0.2]]


def test_descriptions_of_two_perturbed_arms_differ():
    arm = load_arm("ur5")
    rng = np.random.default_rng(0)
    law, held = FTCF(arm), Constant(arm.home)
    robots = [arm, arm.perturbed(rng), arm.perturbed(rng)]
    plain, first, second = (provenance(ClosedLoop(robot, law, held)) for robot in robots)
    assert first != second != plain


def test_what_a_description_cannot_show_goes_by_its_type():
    document = provenance(pendulum_loop())
    assert document["controller"] == {"type": "Push", "torque": [1.0, -2.0]}
    assert "controller of the experiment: a Push" in document[NOT_REBUILDABLE]
