"""Profiles by name: complete, sourced, and usable from the command line."""

import json

import numpy as np
import pytest

from ftcfa import Accelerometer, accelerometer_profile, accelerometers, hardware_profile, profiles
from ftcfa.cli import main
from ftcfa.report.hardware import UNITS

JOINTS = {"ideal": None, "fr3": 7, "ur5e": 6, "iiwa14": 7, "gen3": 7, "so101": 5}


def ran(words, capsys):
    """Exit status and standard output of a command."""
    with pytest.raises(SystemExit) as caught:
        main(words)
    captured = capsys.readouterr()
    return caught.value.code or 0, captured.out, captured.err


def test_the_robots():
    assert {name: profile.joints for name, profile in profiles().items()} == JOINTS


@pytest.mark.parametrize("group", [profiles, accelerometers])
def test_every_number_has_a_source(group):
    for profile in group().values():
        for name, number in profile.numbers.items():
            assert len(number.source) > 3, name
            assert number.verified, name
            assert ("assumed" in number.source) == ("no public source" in number.verified)
            assert name in UNITS or isinstance(number.value, dict)


def test_what_fr3_holds():
    it = hardware_profile("fr3")
    assert (it.period, it.actuators.rate_limit) == (1e-3, 1000.0)
    np.testing.assert_array_equal(it.actuators.effort_limit, [87] * 4 + [12] * 3)


def test_accelerometer_classes():
    for name in accelerometers():
        assert isinstance(accelerometer_profile(name), Accelerometer)
    micro_g = 9.80665e-6
    assert accelerometer_profile("low_noise_mems").noise_density == pytest.approx(
        22.5 * micro_g, rel=0.02
    )


def test_the_command(capsys):
    status, out, _ = ran(["hardware", "fr3"], capsys)
    assert status == 0
    assert "1000 N m/s" in out
    assert "assumed" in out
    status, out, _ = ran(["hardware", "--json"], capsys)
    names = [profile["name"] for profile in json.loads(out)["profiles"]]
    assert names == [*JOINTS, *accelerometers()]
    status, _, err = ran(["hardware", "fr4"], capsys)
    assert status == 2
    assert "did you mean 'fr3'" in err


FILE = """
duration = 0.2
paths = 4
arm = { robot = "panda" }
controller = { type = "FTCF", compensation = "bias" }
reference = { type = "Sinusoid", amplitude = 0.1, offset = "home" }
vibration = { input = { type = "BaseAcceleration" }, excitation = { type = "WhiteNoise" } }
specification = { error = 0.05, within = 0.1 }
"""


@pytest.mark.parametrize("command", ["run", "verify", "compare"])
def test_commands_take_a_profile(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "e.toml").write_text(FILE)
    more = ["--controller", "ComputedTorque"] if command == "compare" else []
    status, out, _ = ran([command, "e.toml", "--hardware", "fr3", "--json", *more], capsys)
    assert status in (0, 1, 3)
    assert json.loads(out)
    status, _, err = ran([command, "e.toml", "--hardware", "ur5e", *more], capsys)
    assert status == 2
    assert "an arm of 7 joints, expected 6 joints" in err
