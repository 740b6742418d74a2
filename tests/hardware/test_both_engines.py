"""Hardware on both engines: the same numbers, the same bits in any company, nothing when off."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import stats

from ftcfa import (
    CONTROLLERS,
    Accelerometer,
    BackwardDifference,
    Constant,
    Hardware,
    Kalman,
    Levant,
    ModelObserver,
    ParameterError,
    Sensors,
    ensemble,
    load_arm,
    replay,
    simulate,
    simulate_paths,
)

from .loops import ARM, EVERYTHING, loop

AGREEMENT = 1e-9
ESTIMATORS = {
    "difference": BackwardDifference(50.0),
    "Levant": Levant(),
    "model": ModelObserver(ARM),
    "Kalman": Kalman(ARM),
}


def agree(one, other):
    for name in one.data_vars:
        np.testing.assert_allclose(one[name], other[name], rtol=0, atol=AGREEMENT, err_msg=name)


@pytest.mark.parametrize("law", CONTROLLERS)
def test_everything_on(law):
    it = loop(EVERYTHING, substeps=2, controller=CONTROLLERS[law](ARM))
    compiled = simulate(it, 0.2, signals="all")
    assert compiled.attrs["engine"] == "compiled"
    agree(compiled, simulate(it, 0.2, signals="all", engine="interpreted"))


@pytest.mark.parametrize("name", ESTIMATORS)
def test_estimators(name):
    sensors = Sensors(resolution=1e-4, noise=1e-4, velocity=ESTIMATORS[name])
    it = loop(Hardware(sensors, EVERYTHING.actuators), substeps=2)
    compiled = simulate(it, 0.2, signals="all")
    agree(compiled, simulate(it, 0.2, signals="all", engine="interpreted"))


@pytest.mark.parametrize("substeps", [1, 2])
def test_ideal_hardware_changes_no_bit(substeps):
    without, with_it = (
        simulate(loop(hardware, substeps=substeps), 0.3) for hardware in (None, "ideal")
    )
    for name in without.data_vars:
        np.testing.assert_array_equal(without[name], with_it[name])


def test_a_path_has_the_same_bits_in_any_company():
    it = loop(EVERYTHING, substeps=2)
    many = simulate_paths(it, 20, 0.1, signals="all", threads=2)
    alone = simulate(it, 0.1, path=13, signals="all")
    for name in alone.data_vars:
        np.testing.assert_array_equal(alone[name], many.isel(path=13)[name])
    other = simulate(it, 0.1, path=14, signals="all")
    assert not np.array_equal(other.q_measured, alone.q_measured)


def test_blocks_have_streams_of_their_own():
    noisy = Hardware(Sensors(noise=1e-3))
    more = Hardware(Sensors(noise=1e-3), accelerometer=EVERYTHING.accelerometer)
    one, other = (simulate(loop(it, substeps=2), 0.1, signals="all") for it in (noisy, more))
    np.testing.assert_array_equal(one.q_measured, other.q_measured)


def test_parameters_that_vary():
    paths = 4
    vary = {
        "hardware.sensors.noise": np.linspace(0, 1e-3, paths),
        "hardware.sensors.dropped": np.linspace(0, 0.3, paths),
        "hardware.sensors.resolution": np.linspace(0, 1e-3, paths),
        "hardware.actuators.rate_limit": np.linspace(100, 1e4, 2 * paths).reshape(paths, 2),
        "hardware.actuators.delay": np.array([0, 5e-4, 1e-3, 1.5e-3]),
        "hardware.accelerometer.delay": np.array([2e-3, 0, 1e-3, 1.5e-3]),
        "hardware.accelerometer.gyroscope.noise_density": np.linspace(0, 1e-2, paths),
    }
    it, options = loop(EVERYTHING, substeps=2), {"vary": vary, "signals": "all"}
    compiled = simulate_paths(it, paths, 0.1, **options)
    agree(compiled, simulate_paths(it, paths, 0.1, engine="interpreted", **options))


def test_a_profile_in_an_ensemble_and_its_replay():
    arm = load_arm("panda")
    it = loop("fr3", arm, reference=Constant(arm.home), vibration=None)
    runs = ensemble(it, 5, 0.1)
    again = replay(runs, 3)
    assert again.attrs["engine"] == "compiled"
    assert "u_driven" in again


@pytest.mark.parametrize("paths", [1, 9])
def test_a_path_diverges_by_its_true_state(paths):
    wild = Hardware(Sensors(offset=1e6))
    found = simulate_paths(loop(wild), paths, 0.2)
    at = np.asarray(found.diverged_at)
    first = np.asarray(found.q)[:, 0]
    assert np.all(np.isfinite(first))
    assert np.all(np.isnan(at) | (at > 0))


def test_hardware_that_differs_from_path_to_path():
    spread = {"hardware.sensors.latency": (0.0, 2e-3), "hardware.sensors.offset": (-1e-3, 3e-3)}
    hardware = Hardware(Sensors(largest_latency=2e-3, offset=[0.0, 0.0]))
    it = loop(hardware, substeps=2, spread=spread)
    many = simulate_paths(it, 400, 0.02, signals=["q_measured"])
    late, offset = many["hardware.sensors.latency"].values, many["hardware.sensors.offset"].values
    np.testing.assert_allclose(late / 5e-4, np.round(late / 5e-4), atol=1e-9)
    assert (late.min(), late.max()) == (0.0, 2e-3)
    assert offset.shape == (400, 2)
    assert stats.kstest((offset.ravel() + 1e-3) / 4e-3, "uniform").pvalue > 1e-6
    alone = simulate(it, 0.02, path=77, signals=["q_measured"])
    np.testing.assert_array_equal(alone.q_measured, many.q_measured[77])
    fixed = Hardware(Sensors(latency=late[77], offset=offset[77]))
    same = simulate(loop(fixed, substeps=2), 0.02, path=77, signals=["q_measured"])
    np.testing.assert_allclose(alone.q_measured, same.q_measured, atol=1e-9)
    with pytest.raises(ParameterError, match="drawn for every path"):
        simulate_paths(it, 2, 0.01, vary={"hardware.sensors.latency": np.zeros(2)})


@dataclass(frozen=True, eq=False)
class Forgetful:
    """A law whose state is the reading with which it began; its tenth torque is not finite."""

    def init(self, measured, desired):
        return measured.q, measured.base.specific_force, np.zeros(1)

    def step(self, state, measured, desired, period):
        began, force, count = state
        u = np.where(count[0] == 9.0, np.inf, 0.0) + 0.0 * measured.q
        return {"u": u, "began": began, "force": force}, (began, force, count + 1.0)


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_a_law_that_starts_anew_gets_the_last_reading(engine):
    hardware = Hardware(Sensors(offset=0.5, latency=2e-3), accelerometer=Accelerometer(bias=0.1))
    found = simulate(loop(hardware, controller=Forgetful()), 0.02, signals="all", engine=engine)
    assert found.attrs["engine"] == engine
    began, force = found.began.values, np.asarray(found.force)
    assert np.all(began[:10] == began[0])
    np.testing.assert_array_equal(began[10], found.q_measured.values[9])
    np.testing.assert_array_equal(force[10], found.base_measured.values[9])
    assert np.any(began[10] != began[0])
