"""Parameters that differ from path to path: each path equals a loop built with its values."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    ClosedLoop,
    Gains,
    ImplicitFilter,
    PaperPendulum,
    PaperPendulumInput,
    ParameterError,
    RBFNetwork,
    ShapeError,
    Sinusoid,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
    number_fields,
    simulate,
    simulate_paths,
)
from ftcfa.loop.parameters import parameter

from ..engine.loops import PI, Spring, gantry, masses, shaken

TOLERANCE = 1e-10
"""Relative to the largest entry. A constant folds at compile time and an input does not, so the
two programs round differently; the loop carries that over 50 samples."""
DURATION = 0.05
PATHS = 5
ENGINES = ["compiled", "interpreted"]


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


@pytest.fixture(scope="module")
def arm():
    return load_arm("double_pendulum")


@pytest.fixture(scope="module")
def loop(arm):
    return shaken(arm, "xz", v0=[0.1, -0.2])


def around(value, spread=0.1, seed=0):
    """Values of some paths near a value, each entry drawn by itself."""
    value = np.asarray(value, dtype=float)
    return value * (1 + spread * np.random.default_rng(seed).uniform(-1, 1, (PATHS, *value.shape)))


def assert_each_path_is_its_own_loop(loop, vary, build, engine, duration=DURATION):
    """Compare with ``build(*values)`` of each path, run alone; and values must matter."""
    together = simulate_paths(loop, PATHS, duration, seed=2, vary=vary, engine=engine)
    assert together.attrs["engine"] == engine
    plain = simulate_paths(loop, PATHS, duration, seed=2, engine=engine)
    assert np.abs(together.v - plain.v).max() > 1e3 * TOLERANCE, "the values change nothing"
    for path in range(PATHS):
        own = build(*(values[path] for values in vary.values()))
        alone = simulate(own, duration, seed=2, path=path, engine="interpreted")
        for name in ("q", "v", "u"):
            scale = np.abs(alone[name]).max()
            error = np.abs(together[name][path] - alone[name]).max()
            assert error <= TOLERANCE * scale, (name, path)


def test_initial_states(loop, engine):
    rng = np.random.default_rng(0)
    vary = {"q0": rng.uniform(-1, 1, (PATHS, 2)), "v0": rng.uniform(-1, 1, (PATHS, 2))}
    assert_each_path_is_its_own_loop(loop, vary, lambda q0, v0: replace(loop, q0=q0, v0=v0), engine)
    result = simulate_paths(loop, PATHS, 0.0, vary=vary, engine=engine)
    np.testing.assert_array_equal(result.q[:, 0], vary["q0"])
    np.testing.assert_array_equal(result.v[:, 0], vary["v0"])


@pytest.mark.parametrize(
    ("robot", "lock"),
    [
        ("double_pendulum", {}),
        ("ur5", {"elbow_joint": 0.7, "wrist_1_joint": -0.4, "wrist_3_joint": 1.0}),
        ("gantry", {"swing": 0.5}),
    ],
)
def test_inertias_also_of_welded_bodies(robot, lock, engine, tmp_path):
    made = gantry(tmp_path) if robot == "gantry" else None
    arm = load_arm(str(tmp_path / "gantry.urdf") if made else robot, lock=lock)
    loop = shaken(arm, "xz", v0=np.full(arm.n, 0.2))
    drawn = [arm.perturbed(np.random.default_rng(i)) for i in range(PATHS)]
    vary = {"arm.inertias": np.array([other.inertias for other in drawn])}
    build = dict(zip((v.tobytes() for v in vary["arm.inertias"]), drawn, strict=True))
    assert_each_path_is_its_own_loop(
        loop, vary, lambda x: replace(loop, arm=build[x.tobytes()]), engine
    )


def test_inertias_of_the_nominal_arm(loop, arm, engine):
    vary = {
        "controller.nominal.inertias": np.array(
            [arm.perturbed(np.random.default_rng(i)).inertias for i in range(PATHS)]
        )
    }
    assert_each_path_is_its_own_loop(
        replace(loop, q0=[0.02, -0.01]),
        vary,
        lambda x: replace(loop, q0=[0.02, -0.01], controller=FTCF(arm.with_inertias(x))),
        engine,
    )


def test_effort_limits(loop, arm, engine):
    vary = {"arm.effort_limit": around(arm.effort_limit, 0.5)}
    assert_each_path_is_its_own_loop(
        loop, vary, lambda limit: replace(loop, arm=replace(arm, effort_limit=limit)), engine
    )
    result = simulate_paths(loop, PATHS, DURATION, vary=vary, engine=engine)
    assert np.all(np.abs(result.u) <= vary["arm.effort_limit"][:, None])


def test_friction(engine):
    arm = load_arm("xarm7")
    loop = shaken(arm)
    vary = {"arm.damping": around(arm.damping), "arm.friction": around(arm.friction)}
    assert_each_path_is_its_own_loop(
        loop,
        vary,
        lambda damping, friction: replace(
            loop, arm=replace(arm, damping=damping, friction=friction)
        ),
        engine,
        duration=0.02,
    )


def test_noise_intensity(loop, engine):
    sigma = np.random.default_rng(0).standard_normal((PATHS, 2, 2))

    def build(sigma):
        noise = WhiteNoise(sigma @ sigma.T)
        built = replace(loop, vibration=replace(loop.vibration, excitation=noise))
        np.testing.assert_allclose(built.process.sigma, sigma, atol=1e-12)
        return built

    symmetric = np.einsum("pij,pkj->pik", sigma, sigma) + 0.1 * np.eye(2)
    assert_each_path_is_its_own_loop(loop, {"process.sigma": symmetric}, build, engine)


@pytest.mark.parametrize("gain", ["c1", "c2", "k1", "k2", "kappa", "iota", "lambda_", "tau"])
def test_gains(loop, arm, gain, engine):
    start = replace(loop, q0=[0.02, -0.01], v0=[0.3, 0.3])  # within the effort limits
    noisy = Gains(iota=1.0, lambda_=50.0, tau=0.5)  # a network that matters
    start = replace(start, controller=FTCF(arm, noisy))
    assert_each_path_is_its_own_loop(
        start,
        {f"controller.gains.{gain}": around(getattr(noisy, gain), 0.3)},
        lambda value: replace(start, controller=FTCF(arm, replace(noisy, **{gain: float(value)}))),
        engine,
    )


def test_gains_of_the_filter_and_the_network(arm, engine):
    controller = FTCF(arm, Gains(lambda_=50.0), ImplicitFilter(50.0, 20.0))
    loop = shaken(arm, "xz", controller=controller, q0=[0.02, -0.01], v0=[0.3, 0.3])
    vary = {
        "controller.filter.r1": around(50.0),
        "controller.filter.r2": around(20.0),
        "controller.network.width": around(4.0),
    }

    def build(r1, r2, width):
        parts = ImplicitFilter(float(r1), float(r2)), "none", RBFNetwork(width=float(width))
        return replace(loop, controller=FTCF(arm, Gains(lambda_=50.0), *parts))

    assert_each_path_is_its_own_loop(loop, vary, build, engine)


def test_everything_at_once(loop, arm, engine):
    drawn = np.array([arm.perturbed(np.random.default_rng(i)).inertias for i in range(PATHS)])
    vary = {
        "process.sigma": around(loop.process.sigma),
        "arm.inertias": drawn,
        "q0": around([0.1, -0.1]),
        "arm.effort_limit": around(arm.effort_limit),
        "controller.gains.c2": around(25.0),
    }

    def build(sigma, inertias, q0, limit, c2):
        own = replace(arm.with_inertias(inertias), effort_limit=limit)
        vibration = replace(loop.vibration, excitation=WhiteNoise(sigma @ sigma))
        controller = FTCF(arm, Gains(c2=float(c2)))
        return replace(loop, arm=own, q0=q0, vibration=vibration, controller=controller)

    assert_each_path_is_its_own_loop(loop, vary, build, engine)


@pytest.mark.parametrize("order", [1, -1])
def test_a_given_amplitude_stays_when_the_noise_input_varies_too(order, engine):
    # A part forgets what it computed from what changes; a given Sigma is not computed.
    plant = PaperPendulum()
    loop = ClosedLoop(
        plant, FTCF(plant), Sinusoid([0.3, 0.2]), Vibration(PaperPendulumInput(), WhiteNoise(0.1))
    )
    vary = dict(
        [("process.sigma", around(np.eye(2))), ("vibration.input.m", around([0.6, 0.8]))][::order]
    )

    def build(*values):
        given = dict(zip(vary, values, strict=True))
        sigma, m = given["process.sigma"], given["vibration.input.m"]
        vibration = Vibration(PaperPendulumInput(m=tuple(m)), WhiteNoise(sigma @ sigma))
        return replace(loop, vibration=vibration)

    assert_each_path_is_its_own_loop(loop, vary, build, engine)


class Gain(NamedTuple):
    p: float
    d: float
    varies = number_fields("p", "d")


@dataclass(frozen=True, slots=True)
class Slotted:
    k: float
    varies: ClassVar = number_fields("k")


@dataclass(frozen=True)
class Mixed:
    """A user's law: gains in a NamedTuple, a slotted dataclass and an array, one of them cached."""

    gains: Gain
    inner: Slotted
    bias: tuple
    varies = number_fields("bias")

    @cached_property
    def stiffness(self):
        return self.gains.p + self.inner.k

    def init(self, measured, desired):
        return None

    def step(self, state, measured, desired, period):
        q, v = measured.q, measured.v
        u = -self.stiffness * q - self.gains.d * v + self.inner.k * desired.q + self.bias
        return {"u": u}, state


@dataclass(frozen=True)
class Designed(Spring):
    """A user's law that computes its gain when it is made."""

    def __post_init__(self):
        object.__setattr__(self, "design", 2.0 * np.sqrt(self.k))


def test_parameters_of_a_users_law(engine):
    law = Mixed(Gain(5.0, 1.0), Slotted(3.0), (0.1, 0.2))
    loop = masses(law=law, reference=Sinusoid([0.3, 0.2]), period=0.01)
    vary = {
        "controller.gains.p": around(5.0),
        "controller.inner.k": around(3.0),
        "controller.bias": around([0.1, 0.2]),
    }
    assert_each_path_is_its_own_loop(
        loop,
        vary,
        lambda p, k, bias: replace(
            loop, controller=Mixed(Gain(float(p), 1.0), Slotted(float(k)), bias)
        ),
        engine,
        duration=0.5,
    )


def test_what_a_law_computed_when_it_was_made_is_not_left_behind(engine):
    loop = masses(law=Designed(k=4.0))
    text = refused(loop, engine, ParameterError, controller__k=np.ones(3))
    assert "varied controller.k: Designed computed design when it was made" in text
    assert "make it a cached_property, or make a loop for each value" in text
    assert simulate(loop, 0.01, engine=engine).attrs["engine"] == engine


def test_what_compiled_code_cannot_vary_is_interpreted(loop, arm):
    for name, values in {
        "arm.g0": np.full((2, *arm.g0.shape), 0.1),
        "arm.G": np.array([arm.G, 1.1 * arm.G]),
        "vibration.excitation.intensity": [0.1, 0.2],
    }.items():
        with pytest.warns(UserWarning, match="running interpreted") as caught:
            result = simulate_paths(loop, 2, 0.01, vary={name: values})
        assert len(caught) == 1
        truth = simulate_paths(loop, 2, 0.01, vary={name: values}, engine="interpreted")
        np.testing.assert_array_equal(result.q, truth.q)


def test_a_loop_is_left_as_it_was(loop, arm, engine):
    before = simulate(loop, 0.01, engine=engine)
    vary = {
        "q0": np.ones((2, 2)),
        "arm.inertias": 2 * np.array([arm.inertias] * 2),
        "process.sigma": np.ones((2, 2, 2)),
        "controller.gains.c1": [1.0, 2.0],
    }
    simulate_paths(loop, 2, 0.01, vary=vary, engine=engine)
    after = simulate(loop, 0.01, engine=engine)
    for name in ("q", "v", "u"):
        np.testing.assert_array_equal(before[name], after[name])
    assert loop.controller.gains.c1 == 7.5


def refused(loop, engine, error, **vary):
    (name, values), *_ = [(k.replace("__", "."), v) for k, v in vary.items()]
    with pytest.raises(error) as caught:
        simulate_paths(loop, 3, 0.01, vary={name: values}, engine=engine)
    return str(caught.value)


def test_unknown_names_list_the_known_ones(loop, engine):
    text = refused(loop, engine, UnknownNameError, controller__gains__c3=np.ones(3))
    assert "parameter controller.gains.c3: gains 'c3': unknown name" in text
    assert "one of: c1, c2, iota, k1, k2, kappa, lambda_, tau" in text
    text = refused(loop, engine, UnknownNameError, robot=np.ones(3))
    assert "parameter robot: loop 'robot': unknown name, expected one of: arm, controller" in text
    assert "arm '_data'" in refused(loop, engine, UnknownNameError, arm___data=np.ones(3))


def test_what_is_no_number_is_refused(loop, engine):
    text = refused(loop, engine, ParameterError, controller__gains=np.ones(3))
    assert "parameter controller.gains: a Gains, expected numbers" in text
    assert "try controller.gains.c1, controller.gains.c2" in text
    quiet = replace(loop, vibration=None)
    assert "not given" in refused(quiet, engine, ParameterError, vibration=np.ones(3))


def test_what_is_computed_from_others_is_refused(loop, engine):
    for word in ("n", "moving_mass", "mass_matrix", "joint_names", "gravity"):
        text = refused(loop, engine, ParameterError, **{f"arm__{word}": np.ones(3)})
        assert f"parameter arm.{word}: fixed, or computed from others, expected one of: G, " in text
        assert "; Arm.varies declares what may differ from path to path" in text
    text = refused(loop, engine, ParameterError, vibration__process=np.ones(3))
    assert "computed from others, expected one of: excitation, level; Vibration.varies" in text


@dataclass(frozen=True)
class Undeclared(Spring):
    """A user's law that says nothing of its parameters."""

    varies: ClassVar = {}


def test_a_part_that_declares_nothing_says_how_to(engine):
    loop = masses(law=Undeclared(k=4.0))
    text = refused(loop, engine, ParameterError, controller__k=np.ones(3))
    assert "parameter controller.k: Undeclared declares no parameters, expected a frozen" in text
    assert '; write varies = number_fields("k") into it' in text


class Plain:
    """A user's law that is no dataclass."""

    varies: ClassVar = number_fields("k")

    def __init__(self, k=4.0):
        self.k = k

    init, step = Spring.init, lambda self, state, now, *_: ({"u": -self.k * now.q}, state)


def test_a_plain_class_runs_but_cannot_vary(engine):
    loop = masses(law=Plain())
    assert simulate(loop, 0.01, engine=engine).attrs["engine"] == engine
    text = refused(loop, engine, ParameterError, controller__k=np.ones(3))
    assert "varied controller.k: Plain has no fields, expected a frozen dataclass" in text
    assert "; write @dataclass(frozen=True) above it" in text


@pytest.mark.parametrize(
    "name", ["period", "substeps", "reference", "reference.amplitude", "integrator"]
)
def test_what_all_paths_share_is_refused(loop, engine, name):
    text = refused(loop, engine, ParameterError, **{name.replace(".", "__"): np.ones(3)})
    assert f"varied {name}: common to all paths" in text
    assert "make a loop for each" in text


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("controller__gains__c1", np.ones(2), r"shape (2,), expected shape (3,)"),
        ("controller__gains__c1", np.ones((3, 1)), r"shape (3, 1), expected shape (3,)"),
        ("controller__gains__c1", 1.0, r"shape (), expected shape (3,)"),
        ("q0", np.ones(3), r"shape (3,), expected shape (3, 2)"),
        ("arm__inertias", np.ones((3, 2)), "expected shape (3, "),
    ],
)
def test_wrong_shapes_are_refused(loop, engine, name, values, expected):
    text = refused(loop, engine, ShapeError, **{name: values})
    assert f"varied {name.replace('__', '.')}: " in text
    assert expected in text


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused(loop, engine, bad):
    text = refused(loop, engine, ParameterError, controller__gains__c1=[1.0, bad, 2.0])
    assert "varied controller.gains.c1: values that are not finite" in text


def test_values_that_are_no_numbers_are_refused(loop, engine):
    text = refused(loop, engine, ParameterError, controller__gains__c1=["a", "b", "c"])
    assert "varied controller.gains.c1: ['a', 'b', 'c'], expected numbers" in text


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("controller__gains__c1", [1.0, -0.5, 2.0], "expected numbers > 0"),
        ("controller__gains__c1", [1.0, 0.0, 2.0], "expected numbers > 0"),
        ("controller__gains__kappa", [0.5, 1.5, 0.7], "Gains kappa: 1.5, expected 0 < kappa <= 1"),
        ("controller__filter__r2", [1.0, -3.0, 2.0], "ImplicitFilter r2: -3.0"),
        ("arm__damping", -np.ones((3, 3)), "friction of double_pendulum: -1, expected numbers >="),
    ],
)
def test_values_that_their_part_refuses_are_refused(loop, engine, name, values, expected):
    assert expected in refused(loop, engine, ParameterError, **{name: values})


def test_limits_and_bodies_that_no_robot_can_have_are_refused(loop, arm, engine):
    text = refused(loop, engine, ParameterError, arm__effort_limit=[[1, 1], [1, -2], [3, 3]])
    assert "effort_limit of double_pendulum: -2, expected numbers > 0" in text
    negative = np.array([arm.inertias, -arm.inertias, arm.inertias])
    text = refused(loop, engine, ParameterError, arm__inertias=negative)
    assert "inertias of double_pendulum: a pseudo-inertia with the eigenvalue -" in text


def test_a_parameter_without_effect_is_refused(loop):
    text = refused(loop, "compiled", ParameterError, arm__home=np.ones((3, 2)))
    assert "varied arm.home: no effect on the motion" in text


def test_parameters_are_read_by_name(loop, arm):
    np.testing.assert_array_equal(parameter(loop, "q0"), [0.0, 0.0])
    np.testing.assert_array_equal(parameter(loop, "arm.inertias"), arm.inertias)
    assert parameter(loop, "controller.gains.c2") == 25.0
    assert parameter(masses(law=PI()), "controller.p") == 5.0
