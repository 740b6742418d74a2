"""Loops of uncertain robots: every path has its own, on both engines, without recompiling."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    ClosedLoop,
    PaperPendulum,
    ParameterError,
    Sinusoid,
    Uncertainty,
    UnknownNameError,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.engine.compiler import program, trace

from .loops import masses, shaken

TOLERANCE = 1e-9
"""Of the engines, relative to the largest value: rounding of another order of operations."""
DURATION = 0.05
PATHS = 11
UNCERTAINTY = Uncertainty(mass=0.2, centre=0.02, shape=0.1, friction=0.3, payload=(0.0, 1.0))
SIGNALS = ("q", "v", "u")


@pytest.fixture(params=["interpreted", "compiled"])
def engine(request):
    return request.param


@pytest.fixture(scope="module")
def arm():
    return load_arm("xarm7")


@pytest.fixture(scope="module")
def loop(arm):
    return shaken(arm, uncertainty=UNCERTAINTY)


def assert_equal(a, b):
    for name in (*SIGNALS, "ote", "arm.inertias", "arm.damping", "arm.friction"):
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_every_path_runs_with_its_own_robot(loop, arm, engine):
    together = simulate_paths(loop, PATHS, DURATION, seed=2, engine=engine)
    assert together.attrs["engine"] == engine
    for path in range(PATHS):
        robot = UNCERTAINTY.robot(arm, 2, path)
        own = replace(loop, arm=robot, uncertainty=None)
        alone = simulate(own, DURATION, seed=2, path=path, engine="interpreted")
        for name in SIGNALS:
            error = np.abs(together[name][path] - alone[name]).max()
            assert error <= TOLERANCE * np.abs(alone[name]).max(), (name, path)


def test_the_controller_keeps_its_nominal_robot(loop, arm):
    """At the first sample all paths are in one state, so one law asks for one torque."""
    first = simulate_paths(loop, PATHS, 0.0, signals=["u_command"]).u_command.values[:, 0]
    np.testing.assert_array_equal(first, np.broadcast_to(first[0], first.shape))
    later = simulate_paths(replace(loop, vibration=None), PATHS, DURATION)
    assert np.all(np.std(later.v[:, -1], axis=0) > 1e-6)
    assert loop.controller.nominal is arm


@pytest.mark.parametrize("distribution", ["log-normal", "bounded"])
def test_the_engines_agree(loop, distribution):
    wide = replace(UNCERTAINTY, mass=0.5, shape=0.3, distribution=distribution)
    wide = replace(loop, uncertainty=wide)
    runs = [simulate_paths(wide, 4, 0.1, engine=e) for e in ("compiled", "interpreted")]
    for name in SIGNALS:
        scale = np.abs(runs[1][name]).max()
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=0, atol=TOLERANCE * scale)
    np.testing.assert_array_equal(runs[0]["arm.inertias"], runs[1]["arm.inertias"])


def test_a_path_is_the_same_alone_and_in_a_batch(loop, engine):
    batch = simulate_paths(loop, 21, DURATION, seed=3, threads=2, engine=engine)
    for path in (0, 7, 20):
        alone = simulate(loop, DURATION, seed=3, path=path, engine=engine)
        assert_equal(alone, batch.sel(path=path))
    few = simulate_paths(loop, [20, 3], DURATION, seed=3, engine=engine)
    assert_equal(few, batch.sel(path=[20, 3]))


def test_other_seeds_paths_and_spreads_take_the_same_program(loop):
    loop = replace(loop)  # which no other test has traced
    simulate_paths(loop, 3, 0.01)
    (code,) = [c for (names, varied), c in trace._traced[loop].items() if "arm.inertias" in varied
               and tuple(names) == SIGNALS]  # fmt: skip
    programs = dict(program._cache)
    for seed in range(1, 4):
        simulate_paths(loop, [5, 9], 0.01, seed=seed)
        simulate(loop, 0.01, seed=seed, path=8)
    wider = replace(loop, uncertainty=replace(UNCERTAINTY, mass=0.4, payload=None))
    simulate(wider, 0.01)
    assert dict(program._cache) == programs
    assert code in trace._traced[loop].values()


def test_seeds_and_paths_have_other_robots(loop):
    run = simulate_paths(loop, 3, 0.0, seed=1)
    other = simulate_paths(loop, 3, 0.0, seed=2)
    first = np.concatenate([run["arm.inertias"][:, 0, 0], other["arm.inertias"][:, 0, 0]])
    assert len(np.unique(first)) == 6


def test_the_drawn_robots_are_coordinates(loop, arm):
    run = simulate_paths(loop, 3, 0.0, seed=1)
    for name, values in UNCERTAINTY.draw(arm, 1, range(3)).items():
        np.testing.assert_array_equal(run[f"arm.{name}"], values)
        assert f"arm.{name}" in run.coords


def test_other_parameters_can_vary_too(loop, engine):
    vary = {"controller.gains.c1": [2.0, 20.0]}
    both = simulate_paths(loop, 2, DURATION, vary=vary, engine=engine)
    for i, c1 in enumerate(vary["controller.gains.c1"]):
        gains = replace(loop.controller.gains, c1=c1)
        own = replace(loop, controller=FTCF(loop.controller.nominal, gains))
        alone = simulate(own, DURATION, path=i, engine="interpreted")
        np.testing.assert_allclose(both.q[i], alone.q, rtol=0, atol=TOLERANCE)


def test_results_say_what_was_uncertain(loop):
    document = json.loads(simulate(loop, 0.0).attrs["experiment"])["uncertainty"]
    document.pop("type", None)  # only where there are several to choose from
    assert Uncertainty(**document) == UNCERTAINTY
    certain = simulate(replace(loop, uncertainty=None), 0.0)
    assert json.loads(certain.attrs["experiment"]).get("uncertainty") is None
    assert "arm.inertias" not in certain.coords


@pytest.mark.parametrize("name", ["arm.inertias", "arm.damping", "arm.friction"])
def test_what_the_uncertainty_draws_cannot_vary_besides(loop, arm, engine, name):
    values = np.array([getattr(arm, name.removeprefix("arm."))] * 2)
    with pytest.raises(ParameterError) as caught:
        simulate_paths(loop, 2, 0.01, vary={name: values}, engine=engine)
    assert str(caught.value) == (
        f"varied {name}: drawn for every path, expected one source of each path's "
        "value; leave it out, or take a loop without uncertainty or spread"
    )
    without = replace(loop, uncertainty=replace(UNCERTAINTY, friction=0.0))
    if name != "arm.inertias":
        assert name in simulate_paths(without, 2, 0.0, vary={name: values}, engine=engine).coords


@pytest.mark.parametrize("name", ["uncertainty", "uncertainty.mass"])
def test_a_spread_is_common_to_all_paths(loop, engine, name):
    with pytest.raises(ParameterError, match=f"varied {name}: common to all paths"):
        simulate_paths(loop, 2, 0.01, vary={name: [0.1, 0.2]}, engine=engine)


def test_what_a_loop_cannot_have_is_refused_when_it_is_made(loop):
    plant = PaperPendulum()
    with pytest.raises(ParameterError, match="uncertain robot: a PaperPendulum, expected an Arm"):
        ClosedLoop(plant, FTCF(plant), Sinusoid([0.3, 0.2]), uncertainty=UNCERTAINTY)
    with pytest.raises(ParameterError, match="uncertain robot: a Masses, expected an Arm"):
        masses(uncertainty=UNCERTAINTY)
    with pytest.raises(ParameterError, match="ClosedLoop uncertainty: a float, expected an Unc"):
        replace(loop, uncertainty=0.1)
    with pytest.raises(UnknownNameError, match="payload_frame of xarm7 'hand'"):
        replace(loop, uncertainty=replace(UNCERTAINTY, payload_frame="hand"))
    with pytest.raises(ParameterError, match="uncertain friction of ur10: no friction"):
        shaken(load_arm("ur10"), uncertainty=UNCERTAINTY)


def test_a_branched_arm_with_mimic_joints(engine):
    arm = load_arm("baxter")
    loop = shaken(arm, uncertainty=Uncertainty(mass=0.1, centre=0.01, shape=0.05))
    run = simulate_paths(loop, 2, 0.01, engine=engine)
    for path in range(2):
        own = replace(loop, arm=loop.uncertainty.robot(arm, 0, path), uncertainty=None)
        alone = simulate(own, 0.01, path=path, engine="interpreted")
        scale = np.abs(alone.v).max()
        np.testing.assert_allclose(run.v[path], alone.v, rtol=0, atol=TOLERANCE * scale)
