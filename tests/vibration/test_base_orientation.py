"""A base that turns swings about level: its orientation, excitation by excitation."""

from functools import cache

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from ftcfa import (
    FTCF,
    BaseAcceleration,
    BaseMotion,
    ClosedLoop,
    Constant,
    Harmonic,
    LinearFilter,
    ParameterError,
    RandomPhase,
    Record,
    RecordedAcceleration,
    Road,
    ShapedNoise,
    SineSweep,
    Stacked,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.vibration.inputs.base_motion import _product, _rotation
from ftcfa.vibration.realisation import initial_normals, noise_of_steps

from .masses import CONFIDENCE

TABLE = "astm_d4169_truck_low"
AGREEMENT = 1e-9
"""Of the engines, relative: rounding of another order of operations."""


def smooth(axes, samples=300):
    """Tones that fit into the record, an axis each of its own."""
    t, axis = np.arange(samples) / samples, np.arange(axes)
    return Record(1e-3, np.cos(2 * np.pi * ((axis + 2) * t[:, None] + axis / 7)))


TURNING = {
    "shaped": ShapedNoise((TABLE,) * 6),
    "lines": RandomPhase((TABLE,) * 6, 20),
    "record": RecordedAcceleration(smooth(6)),
    "record at another step": RecordedAcceleration(Record(0.7e-3, smooth(6).values)),
    "sine": Harmonic(np.arange(1.0, 7.0), 5.0 + np.arange(6)),
    "sweep": SineSweep(1.0, 5.0, 40.0, 0.1),
    "sum": ShapedNoise((TABLE,) * 6) + Harmonic(1.0, 30.0) + RecordedAcceleration(smooth(6)),
    "white noise along and a sweep about": Stacked(
        (WhiteNoise(0.1), SineSweep(1.0, 5.0, 40.0, 0.5)), 3
    ),
}


def loop_on(noise_input, excitation, robot="panda", **changes):
    arm = load_arm(robot)
    vibration = Vibration(noise_input, excitation, level=0.7)
    controller = FTCF(arm, compensation="bias")
    return ClosedLoop(arm, controller, Constant(arm.home), vibration, **changes)


def check_engines(loop, duration=0.05):
    runs = [
        simulate_paths(loop, [0, 7], duration, seed=4, engine=engine)
        for engine in ("compiled", "interpreted")
    ]
    assert runs[0].attrs["engine"] == "compiled"
    for name in ("q", "v", "u"):
        largest = np.abs(runs[1][name]).max().item()
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=0, atol=AGREEMENT * largest)


@pytest.mark.parametrize("kind", TURNING)
def test_the_engines_agree(kind):
    """Every excitation on a small arm, which compiles fast, and the sum of most on a large one."""
    robot = "panda" if kind == "sum" else "double_pendulum"
    check_engines(loop_on(BaseMotion(), TURNING[kind], robot, substeps=2))


def test_a_base_that_does_not_turn_takes_any_excitation():
    """It is BaseAcceleration then."""
    loop = loop_on(BaseMotion("xyz", ""), WhiteNoise(0.1))
    check_engines(loop)
    shaken = loop_on(BaseAcceleration(), WhiteNoise(0.1))
    np.testing.assert_array_equal(simulate(loop, 0.05).q, simulate(shaken, 0.05).q)


class Weightless:
    """A user's arm that the motion of its base does not load, as only the base is looked at."""

    n, home, gravity = 1, np.zeros(1), np.zeros(3)

    def base_coupling(self, q):
        return np.zeros((1, 6))

    def base_rotation_force(self, q, v, omega):
        return np.zeros(1)


@cache
def turning(excitation, angular, step, linear):
    arm, vibration = Weightless(), Vibration(BaseMotion(linear, angular), excitation)
    return arm, vibration, vibration.process(arm, step)


def orientations(excitation, angular, step, steps, path=0, linear="z"):
    """Rotation vectors of the base by BaseMotion's own D and the process's U, (steps, 3) [rad]."""
    arm, vibration, process = turning(excitation, angular, step, linear)
    state = vibration.init(process, initial_normals(process, 0, path))
    normals, rows = noise_of_steps(process, range(steps), 0, path)
    chosen = np.eye(3)[:, ["xyz".index(axis) for axis in angular]]
    still, found = np.zeros(1), []
    for k in range(steps):
        _, U = process.integrals(state.process, rows[k])
        found.append(_product(state.input, _rotation(chosen @ U[len(linear) :])))
        _, state = vibration.impulse(process, arm, still, still, state, normals[k], rows[k], step)
    return Rotation.from_quat(np.array(found), scalar_first=True).as_rotvec()


ROLL = np.radians(5.0)
SLOW = 2 * np.pi * 0.1


@pytest.mark.parametrize("path", range(4))
def test_a_ship_rolls_about_level_from_any_phase(path):
    """5 degrees at 0.1 Hz: the very sinusoid, over three periods, whatever its phase."""
    roll = Harmonic([0.0, ROLL * SLOW**2], [1.0, 0.1])
    found = orientations(roll, "x", 0.02, 1500, path)
    t = 0.02 * np.arange(1500)
    waves = np.column_stack([np.cos(SLOW * t), np.sin(SLOW * t)])
    shares, *_ = np.linalg.lstsq(waves, found[:, 0], rcond=None)
    np.testing.assert_allclose(found[:, 0], waves @ shares, atol=1e-9)
    assert np.hypot(*shares) == pytest.approx(ROLL, rel=1e-9)
    np.testing.assert_array_equal(found[:, 1:], 0.0)


def test_roll_and_pitch_follow_their_rates_from_the_first_orientation_on():
    """R' = R [omega]x by products of many short turns, 5 degrees about two axes."""
    w, step, steps = np.array([SLOW, 0.13 * 2 * np.pi]), 0.02, 1000
    both = Harmonic([0.0, *(ROLL * w**2)], [1.0, *(w / (2 * np.pi))], 0.3)
    found = orientations(both, "xy", step, steps)
    fine = step / 20 * (np.arange(20 * steps)[:, None] + 0.5)
    omega = np.pad(ROLL * w * np.sin(w * fine + 0.3), ((0, 0), (0, 1)))
    R = Rotation.from_rotvec(np.append(-ROLL * np.cos([0.3, 0.3]), 0.0))
    exact = []
    for k, turn in enumerate(Rotation.from_rotvec(omega * step / 20)):
        if k % 20 == 0:
            exact.append(R.as_rotvec())
        R = R * turn
    np.testing.assert_allclose(found, exact, atol=5e-6)  # of 0.02 rad of yaw: h^2
    assert np.abs(np.mean(found, axis=0)[:2]).max() < 0.2 * ROLL
    assert np.abs(found).max() < 1.02 * ROLL


def test_a_sweep_of_a_hundred_seconds_ends_level():
    found = orientations(SineSweep(2.0, 2.0, 10.0, 10.0), "x", 0.0125, 8000)[:, 0]
    largest = 2.0 / (2 * np.pi * 2.0) ** 2
    assert np.abs(found).max() <= largest
    for part in np.split(found, 10):
        assert abs(part.mean()) < 0.02 * largest


def test_the_tilt_of_a_filtered_base_is_stationary():
    """Its variance by Lyapunov's equation of the filter with two integrators' outputs, from the
    first step on."""
    paths, step = 400, 5e-4
    (filter,) = ShapedNoise(TABLE).filters
    twice = np.linalg.solve(filter.A, np.linalg.solve(filter.A, np.eye(filter.order)))
    exact = LinearFilter(filter.A, filter.B, filter.C @ twice).rms()[0] ** 2
    noise = ShapedNoise((TABLE, TABLE))
    tilts = [orientations(noise, "y", step, 30, path)[[0, -1], 1] for path in range(paths)]
    low, high = stats.chi2.interval(CONFIDENCE, paths) / np.float64(paths)
    ratio = np.mean(np.square(tilts), axis=0) / exact
    assert np.all((low < ratio) & (ratio < high))


def drifting():
    """A gyroscope's: 0.02 rad/s^2 rms of white noise on a roll of 5 degrees at 0.2 Hz."""
    t, w = 0.01 * np.arange(6000), 2 * np.pi * 0.2
    noise = 0.02 * np.random.default_rng(0).standard_normal(6000)
    roll = -ROLL * w**2 * np.sin(w * t) + noise
    return Record(0.01, np.column_stack([np.zeros(6000), roll]))


@pytest.mark.filterwarnings("ignore:integration step")
def test_a_record_without_its_drift_swings_about_level():
    excitation = RecordedAcceleration(drifting(), high_pass=0.1)
    found = orientations(excitation, "x", 0.005, 12_000)[::2, 0]
    assert abs(found.mean()) < 1e-9
    rolls = np.abs(np.fft.rfft(found)) / 3000
    assert rolls[12] == pytest.approx(0.2**4 / (0.2**4 + 0.1**4) * ROLL, rel=0.01)  # 0.2 Hz
    assert np.all(np.delete(rolls, 12) < 0.1 * ROLL)


@pytest.mark.parametrize(
    ("excitation", "reason"),
    [
        (WhiteNoise(0.1), "white noise, whose integral is a random walk"),
        (ShapedNoise((Road("C", 20.0),) * 2), "noise whose density does not vanish like f^4"),
        (RecordedAcceleration(drifting()), r"a record that turns the base by up to \d.\d+ rad"),
        (Harmonic(1.0, 5.0) + WhiteNoise(0.1), "white noise, whose integral is a random walk"),
    ],
)
def test_what_would_tip_the_base_over_is_refused(excitation, reason):
    message = (
        f"BaseMotion: angular acceleration about y: {reason}, expected one whose density vanishes "
        "at 0 Hz like f.4 and keeps the base about level; take ShapedNoise.from_psd, RandomPhase, "
        "a record with its high_pass, or shake linearly only"
    )
    with pytest.raises(ParameterError, match=message.replace("f^4,", r"f\^4,")):
        loop_on(BaseMotion("z", "y"), excitation)
