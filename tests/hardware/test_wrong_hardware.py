"""Wrong hardware is one sentence."""

import numpy as np
import pytest

from ftcfa import (
    FTCF,
    Accelerometer,
    Actuators,
    Constant,
    FtcfaError,
    Gyroscope,
    Hardware,
    Kalman,
    Levant,
    Sensors,
    load_arm,
    load_experiment,
    simulate,
    simulate_paths,
)

from .loops import ARM, loop

PANDA = load_arm("panda")
WRONG = {
    "negative bandwidth": (lambda: Actuators(bandwidth=-3.0), "bandwidth: -3.0, expected numbers"),
    "negative resolution": (lambda: Sensors(resolution=-1e-3), "expected numbers >= 0 [rad or m]"),
    "a probability of one": (lambda: Sensors(dropped=1.0), "expected a number from 0, below 1"),
    "half a step of latency": (
        lambda: loop(Hardware(Sensors(latency=1.5e-3))),
        "0.0015 s, expected whole integration steps of 0.001 s; take 0.001 or 0.002 s",
    ),
    "half a step of delay": (
        lambda: loop(Hardware(actuators=Actuators(delay=0.4e-3))), "take 0 or 0.001 s",
    ),
    "less than the time": (
        lambda: Sensors(latency=2e-3, largest_latency=1e-3), "expected latency or more, 0.002 s",
    ),
    "noise of an estimate": (
        lambda: Sensors(velocity=Levant(), velocity_noise=0.1), "velocities that are estimated",
    ),
    "an estimator that is none": (lambda: Sensors(velocity=3.0), "expected an estimator"),
    "six axes without a gyroscope": (lambda: Accelerometer(6), "give gyroscope=Gyroscope(...)"),
    "three axes with one": (lambda: Accelerometer(gyroscope=Gyroscope()), "say axes=6"),
    "two axes": (lambda: Accelerometer(2), "Accelerometer axes: 2, expected 3 or 6"),
    "a rate above the step's": (
        lambda: loop(Hardware(accelerometer=Accelerometer(rate=4000.0))),
        "4000 Hz, expected at most one reading an integration step, 1000 Hz",
    ),
    "a rate between": (
        lambda: loop(Hardware(accelerometer=Accelerometer(rate=400.0))), "take 500 or 333.333 Hz",
    ),
    "a rate between, faster": (
        lambda: loop(Hardware(accelerometer=Accelerometer(rate=1500.0)), substeps=3),
        "1500 Hz, expected a multiple or a whole part of the controller's 1000 Hz; take 1000 or",
    ),
    "two biases for three axes": (
        lambda: Accelerometer(bias=[1.0, 2.0]), "Accelerometer bias: 2 numbers, expected one numb",
    ),
    "two biases of gyroscopes": (
        lambda: Gyroscope(bias=[1.0, 2.0]), "Gyroscope bias: 2 numbers, expected one number",
    ),
    "axes that are no integer": (lambda: Accelerometer(3.0), "axes: 3.0, expected 3 or 6"),
    "an estimator that is a law": (
        lambda: Sensors(velocity=FTCF(ARM)), "Sensors velocity: a FTCF, expected an estimator",
    ),
    "three numbers for two joints": (
        lambda: loop(Hardware(actuators=Actuators(ripple=[0.1, 0.2, 0.3]))),
        "Actuators ripple: 3 numbers, expected one number, or one for each of 2 joints",
    ),
    "an unknown profile": (lambda: loop("fr4"), "'fr4': unknown name, expected one of: ideal, fr3"),
    "no hardware": (lambda: loop(3), "a int, expected Hardware(...), or one of: ideal"),
    "a profile of another arm": (
        lambda: loop("fr3"), "hardware: an arm of 2 joints, expected 7 joints; take another",
    ),
    "a spread of nothing": (
        lambda: loop(Hardware(), spread={"hardware.sensors.latencies": (0.0, 1.0)}),
        "mean 'hardware.sensors.latency'",
    ),
    "a spread beyond the largest": (
        lambda: loop(
            Hardware(Sensors(latency=1e-3)), spread={"hardware.sensors.latency": (0.0, 2e-3)}
        ),
        "0 to 0.002 s, expected 0 to 0.001 s; state largest_latency",
    ),
    "a spread upside down": (
        lambda: loop(Hardware(), spread={"hardware.sensors.noise": (1e-3, 0.0)}),
        "a smallest and a largest number",
    ),
    "sensors that are none": (lambda: Hardware(Actuators()), "Sensors(...)"),
    "noise of zero": (lambda: Kalman(ARM, noise=0.0), "expected a number > 0 [rad]"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_parts(name):
    make, message = WRONG[name]
    with pytest.raises(FtcfaError) as caught:
        make()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_loop_faster_than_the_robots_interface():
    with pytest.raises(FtcfaError, match=r"0\.0005 s, expected 0\.001 s or longer"):
        loop("fr3", PANDA, period=5e-4, reference=Constant(PANDA.home))


def test_a_delay_longer_than_the_run():
    with pytest.raises(FtcfaError, match=r"hardware sensors: latency 1 s, expected at most .* 0.5"):
        simulate(loop(Hardware(Sensors(latency=1.0))), 0.5)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("sensors.latency", [0.0, 3e-3], "0 to 0.003 s, expected 0 to 0.002 s"),
        ("sensors.latency", [0.0, 0.5e-3], "take 0 or 0.001 s"),
        ("actuators.rate_limit", [-1.0, 2.0], "expected numbers > 0"),
        ("sensors.noise", [-1.0, 2.0], "expected numbers >= 0"),
        ("sensors.dropped", [0.1, 2.0], "below 1"),
    ],
)
def test_wrong_values_that_vary(name, values, message):
    it = loop(Hardware(Sensors(latency=1e-3, largest_latency=2e-3)))
    with pytest.raises(FtcfaError) as caught:
        simulate_paths(it, 2, 0.1, vary={f"hardware.{name}": np.array(values)})
    assert message in str(caught.value)


def test_a_servo_arm_warns():
    arm = load_arm("so101")
    it = loop("so101", arm, period=0.01, reference=Constant(arm.home), vibration=None)
    with pytest.warns(UserWarning, match="a torque command is a fiction on this arm"):
        simulate(it, 0.1)


FILE = """
duration = 0.1
arm = { robot = "double_pendulum" }
controller = { type = "FTCF" }
reference = { type = "Sinusoid", offset = "home" }
"""


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('hardware = "fr4"', "'fr4', expected one of: ideal"),
        ('hardware = "fr3"', "expected 7 joints"),
        ('hardware = { profile = "fr4" }', "profile: 'fr4', expected one of: ideal"),
        ("hardware = { sensors = { latency = -1 } }", "[hardware.sensors] latency: -1"),
        ("hardware = { accelerometer = { axes = 6 } }", "gyroscope"),
        ("hardware = { actuators = { bandwith = 3 } }", "did you mean 'bandwidth' [Hz]?"),
    ],
)
def test_files(tmp_path, line, message):
    file = tmp_path / "e.toml"
    file.write_text(FILE + line)
    with pytest.raises(FtcfaError) as caught:
        load_experiment(file)
    assert message in str(caught.value)


def test_a_file_with_hardware(tmp_path):
    file = tmp_path / "e.toml"
    accelerometer = "{ axes = 6, rate = 500, gyroscope = { range = 3 } }"
    file.write_text(f'{FILE}hardware = {{ profile = "ideal", accelerometer = {accelerometer} }}')
    experiment = load_experiment(file)
    assert experiment.loop.hardware.accelerometer.gyroscope.range == 3
    experiment.save(tmp_path / "again.toml")
    assert load_experiment(tmp_path / "again.toml").digest == experiment.digest
