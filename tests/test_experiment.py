"""Experiments: run and verified as their file says, saved whole, with a digest of their own."""

import dataclasses
import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import ftcfa
from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Experiment,
    ExperimentError,
    Gains,
    ParameterError,
    Sinusoid,
    Specification,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    load_experiment,
    simulate,
    verify,
)

from .description.loops import DURATION, FILE, THIRD, URDF, loop, same_bits


def test_a_file_says_what_python_says():
    experiment = Experiment.from_text(FILE)
    arm = load_arm("ur5")
    built = ClosedLoop(
        arm,
        FTCF(load_arm("ur5", gravity=9.7), Gains(c1=8.0), compensation="bias"),
        Sinusoid(0.2, offset=arm.home),
        Vibration(BaseAcceleration(("x", "z")), WhiteNoise(0.2)),
        period=2e-3,
    )
    numbers = (experiment.seed, experiment.paths, experiment.record_every, experiment.duration)
    assert numbers == (5, 20, 2, 0.05)
    assert (experiment.tolerance, experiment.after, experiment.chunk) == (0.04, 0.01, 8)
    assert experiment.quantiles == (0.1, 0.5)
    specification = Specification(0.3, 0.02, [150, 150, 150, 28, 28, 28], share=0.9)
    assert dataclasses.astuple(experiment.specification) == dataclasses.astuple(specification)
    assert same_bits(experiment, simulate(built, 0.05, seed=5))


def test_run_is_the_ensemble_that_the_file_says():
    experiment = Experiment.from_text(FILE)
    again = ensemble(
        experiment.loop, 20, 0.05, seed=5, record_every=2, tolerance=0.04, after=0.01,
        quantiles=(0.1, 0.5), chunk=8, threads=1,
    )  # fmt: skip
    xr.testing.assert_identical(experiment.run(threads=1), again)


def test_verify_asks_what_the_file_says():
    experiment = Experiment.from_text(FILE)
    verification = experiment.verify(threads=1)
    again = verify(experiment.loop, experiment.specification, 0.05, seed=5)
    assert verification.specification is experiment.specification
    assert (verification.answer, verification.verdict, verification.seed) == (
        again.answer,
        again.verdict,
        5,
    )


def test_without_a_specification_there_is_nothing_to_verify():
    with pytest.raises(ParameterError) as caught:
        Experiment(loop(), 1.0).verify()
    assert str(caught.value) == (
        "Experiment specification: missing, expected a Specification; "
        "in a file: a table [specification] with error and within"
    )


def test_what_an_experiment_says_of_its_ensemble_comes_back():
    specification = Specification(THIRD, 0.5, torque_rate=[1.0, THIRD], budget=7)
    written = Experiment(loop(), 1.0, 3, 9, 2, THIRD, 0.25, (THIRD, 0.5), 7, specification)
    again = Experiment.from_text(written.to_text())
    assert "type" not in written.to_text().split("[specification]")[1].split("[")[0]
    for name in ("seed", "paths", "record_every", "tolerance", "after", "quantiles", "chunk"):
        assert getattr(again, name) == getattr(written, name)
    assert dataclasses.astuple(again.specification) == dataclasses.astuple(specification)
    assert (
        again.digest == written.digest == Experiment.from_description(written.description()).digest
    )
    assert dataclasses.replace(written, specification=None).digest != written.digest


@pytest.fixture
def folder(tmp_path):
    """An experiment whose arm, record and tables lie beside it."""
    there = tmp_path / "there"
    (there / "data").mkdir(parents=True)
    (there / "data" / "arm.urdf").write_text(URDF)
    rows = "\n".join(f"{k / 100},{k % 7 / 3}" for k in range(30))
    (there / "data" / "drive.csv").write_text(f"time [s],x [g]\n{rows}\n")
    (there / "floor.toml").write_text("[floor]\npoints = [[5, 0.01], [50, 0.01]]\n")
    (there / "experiment.toml").write_text("""
duration = 0.05
substeps = 4
[arm]
robot = "data/arm.urdf"
effort_limit = 15
[controller]
type = "FTCF"
[reference]
type = "Table"
file = "motion.csv"
[vibration]
input = { type = "BaseAcceleration", axes = "xz" }
[vibration.excitation]
type = "Stacked"
[[vibration.excitation.parts]]
type = "RecordedAcceleration"
record = { file = "data/drive.csv" }
[[vibration.excitation.parts]]
type = "ShapedNoise"
axes = { type = "Standard", file = "floor.toml", name = "floor" }
""")
    (there / "motion.csv").write_text("0,0,0\n0.5,0.1,0.2\n1,0,0\n")
    return there


def test_relative_paths_count_from_the_file(folder, monkeypatch):
    file = folder / "experiment.toml"
    path = simulate(load_experiment(file).loop, DURATION)
    monkeypatch.chdir(folder)
    assert same_bits(load_experiment("experiment.toml"), path)
    monkeypatch.chdir(folder.parent)
    assert same_bits(load_experiment("there/experiment.toml"), path)
    with pytest.raises(ExperimentError, match="no such file"):
        Experiment.from_text(file.read_text())  # which counts from here


def test_what_lies_below_a_saved_file_goes_by_its_relative_path(folder):
    experiment = load_experiment(folder / "experiment.toml")
    experiment.save(folder / "copy.toml")
    assert 'robot = "data/arm.urdf"' in (folder / "copy.toml").read_text()
    moved = folder.parent / "elsewhere"
    folder.rename(moved)
    assert (
        load_experiment(moved / "copy.toml").digest
        == load_experiment(moved / "experiment.toml").digest
    )


def test_a_description_needs_no_file(folder, monkeypatch):
    experiment = load_experiment(folder / "experiment.toml")
    path = simulate(experiment.loop, DURATION)
    text, digest = experiment.description(), experiment.digest
    for file in (*folder.glob("*.*"), *folder.glob("data/*")):
        file.unlink()
    monkeypatch.chdir("/")
    assert str(folder) not in text
    again = Experiment.from_description(text)
    assert same_bits(again, path)
    assert again.digest == digest
    again.save(folder / "again.toml")  # the text of the URDF stands in it
    assert same_bits(load_experiment(folder / "again.toml"), path)


def test_the_digest_is_that_of_the_experiment_not_of_its_form():
    experiment = Experiment.from_text(FILE)
    spelled = FILE.replace("c1 = 8", "c1 = 8.0").replace("0.05", "5e-2").replace('"ur5"', "'ur5'")
    assert Experiment.from_text(spelled).digest == experiment.digest
    assert int(experiment.digest, 16) < 2**256
    changes = [
        ("seed = 5", "seed = 6"),
        ("c1 = 8", "c1 = 8.000000000000002"),
        ("0.05", "0.06"),
        ('"ur5"\n', '"ur10"\n'),
        ('"z"', '"y"'),
        ("9.7", "9.8"),
    ]
    others = {Experiment.from_text(FILE.replace(*change)).digest for change in changes}
    assert len(others | {experiment.digest}) == len(changes) + 1


def test_the_digest_is_stable_across_processes(tmp_path):
    (tmp_path / "e.toml").write_text(FILE)
    code = "import ftcfa, sys; print(ftcfa.load_experiment(sys.argv[1]).digest)"
    command = [sys.executable, "-c", code, str(tmp_path / "e.toml")]
    digests = [
        subprocess.run(
            command, capture_output=True, text=True, check=True, env={"PYTHONHASHSEED": s}
        )
        for s in ("1", "2")
    ]
    assert [one.stdout.strip() for one in digests] == [Experiment.from_text(FILE).digest] * 2


def test_the_digest_of_a_large_seed_is_its_own():
    digests = {Experiment(loop(), 1.0, seed=2**64 - k).digest for k in (1, 2)}
    assert len(digests) == 2


def test_saving_is_whole_or_not_at_all(tmp_path, monkeypatch):
    file = tmp_path / "e.toml"
    Experiment(loop(), 1.0).save(file)
    before = hashlib.sha256(file.read_bytes()).digest()

    def cut_short(path, content):
        with path.open("wb") as stream:
            stream.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", cut_short)
    with pytest.raises(ftcfa.FtcfaError, match="cannot be written"):
        Experiment(loop(), 2.0).save(file)
    assert hashlib.sha256(file.read_bytes()).digest() == before
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((None, 1.0), "Experiment loop: a NoneType, expected a ClosedLoop"),
        ((loop(), np.nan), "Experiment duration: nan, expected a number >= 0 [s]"),
        ((loop(), "1"), "Experiment duration: '1', expected a number >= 0 [s]"),
        ((loop(), 1.0, -1), "Experiment seed: -1, expected an integer from 0 to 2^64 - 1"),
        ((loop(), 1.0, 0, 0), "Experiment paths: 0, expected an integer >= 1"),
        (
            (loop(), 1.0, 0, 1, 0.5),
            "Experiment record_every: 0.5, expected an integer from 0 to 2^64 - 1",
        ),
        (
            (loop(), 1.0, 0, 1, 0, 0.05, None, (0.5,), 1, 3),
            "Experiment specification: a int, expected a Specification, or None",
        ),
    ],
)
def test_an_experiment_checks_its_numbers(values, message):
    with pytest.raises(ParameterError) as caught:
        Experiment(*values)
    assert str(caught.value) == message
