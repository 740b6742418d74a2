"""`ftcfa new`: the file runs as it is, for any arm and any vibration, and explains every key."""

import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import ftcfa
from ftcfa.cli import main
from ftcfa.errors import FtcfaError
from ftcfa.loop.feasibility import doubts
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.starter import Shaking, starter

TRUCK = tuple(f"mil_std_810g_highway_truck_{a}" for a in ("longitudinal", "transverse", "vertical"))
FEW = {"panda", "so101", "double_pendulum_relative"}
"""Arms whose loops are compiled in every run of the tests."""
ARMS = [
    robot if robot in FEW else pytest.param(robot, marks=pytest.mark.slow) for robot in catalogue()
]
WEAK = {"double_pendulum_relative"}
"""Arms whose motors cannot hold them at home, of which the file warns when it runs."""


def loaded(text, folder: Path):
    file = folder / "new.toml"
    file.write_text(text)
    return ftcfa.load_experiment(file)


@pytest.mark.parametrize("robot", ARMS)
def test_every_arm_gets_a_motion_within_its_limits(robot, tmp_path):
    experiment = loaded(starter(robot, Shaking(road="C")), tmp_path)
    if robot not in WEAK:
        assert doubts(experiment.loop, experiment.duration) == []
    path = ftcfa.simulate(experiment.loop, 0.01)
    assert np.all(np.isfinite(path.q))


def test_every_key_is_there_with_its_default_or_its_meaning(tmp_path):
    text = starter("panda", Shaking(TRUCK), hardware="fr3")
    data = tomllib.loads(text)
    assert data["substeps"] == 4
    for cls in (ftcfa.Experiment, ftcfa.ClosedLoop, ftcfa.FTCF, ftcfa.Sinusoid, ftcfa.Gains):
        for one in fields(cls):
            if one.name not in ("loop", "observer", "alpha_filter"):
                assert (
                    f"\n{one.name} = " in text
                    or f"\n# {one.name} = " in text
                    or (f"\n[{one.name}" in text or f".{one.name}]" in text)
                ), one.name
    uncommented = "\n".join(
        line.removeprefix("# ") if line.startswith("# ") and " = " in line and "..." not in line
        else line
        for line in text.splitlines()
    )  # fmt: skip
    again = loaded(uncommented, tmp_path)  # every default that is shown is the default
    assert again.loop.vibration.excitation.axes == TRUCK
    first = loaded(text, tmp_path)
    assert ftcfa.simulate(first.loop, 0.05).equals(ftcfa.simulate(again.loop, 0.05))


def test_a_table_and_a_record_are_found_from_the_files_folder(tmp_path):
    table = tmp_path / "site.toml"
    table.write_text(
        '[hall]\npoints = [[5, 0.001], [20, 0.01], [100, 0.01]]\nsource = "s"\nverified = "no"\n'
    )
    record = tmp_path / "floor.csv"
    rows = np.random.default_rng(0).normal(size=(400, 3))
    lines = [f"{k / 200},{','.join(map(str, row))}" for k, row in enumerate(rows)]
    record.write_text("\n".join(["time [s],x [m/s^2],y [m/s^2],z [m/s^2]", *lines]))
    folder = tmp_path / "deeper"
    folder.mkdir()
    for shaking, axes in ((Shaking(table=table), "z"), (Shaking(record=record), "xyz")):
        experiment = loaded(starter("ur10", shaking, folder=folder), folder)
        assert experiment.loop.vibration.input.axes == axes
        assert ftcfa.simulate(experiment.loop, 0.01).q.shape[1] == 6


@pytest.mark.parametrize(
    ("shaking", "words"),
    [
        (Shaking(road="C", vibration=TRUCK), "vibration and road"),
        (Shaking(speed=3.0), "a road class"),
        (Shaking(vibration=TRUCK[:2]), "one (up and down) or three"),
        (Shaking(vibration=("truk",)), "mil_std_810g"),
        (Shaking(road="Z"), "A, B, C"),
    ],
)
def test_bad_vibration_is_one_sentence(shaking, words):
    with pytest.raises(FtcfaError) as error:
        starter("panda", shaking)
    assert words in str(error.value)


def command(*words):
    """Run the command line; its exit status."""
    with pytest.raises(SystemExit) as stopped:
        main(words)
    return stopped.value.code


def test_the_command_writes_a_file_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command("new", "ur5", "--road", "B", "--mounting", "ceiling") == 0
    text = Path("ur5.toml").read_text()
    assert 'mounting = "ceiling"' in text
    assert "ftcfa run ur5.toml" in " ".join(capsys.readouterr().out.split())
    assert command("new", "ur5") == 2
    assert "--force" in capsys.readouterr().err
    assert Path("ur5.toml").read_text() == text
    assert command("new", "ur5", "--force") == 0
    assert Path("ur5.toml").read_text() != text
