"""The scripts, each in a quick mode, as a user would run it."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[1] / "scripts"
PNG = b"\x89PNG\r\n\x1a\n"


def printed(script, *arguments):
    """Standard output of a script that ends well; a warning is an error."""
    run = subprocess.run(
        [sys.executable, "-W", "error", SCRIPTS / script, *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "COLUMNS": "80"},
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.mark.slow
def test_truck_floor(tmp_path):
    text = printed("truck_floor.py", "--quick", "--out", tmp_path)
    assert "pendulum, 8 paths of 1 s" in text
    assert "Panda, 8 paths of 1 s" in text
    assert "…" not in text  # nothing is cut off in 80 columns
    files = sorted(file.name for file in tmp_path.iterdir())
    assert files == ["truck-floor.json", "truck-floor.png"]
    assert (tmp_path / "truck-floor.png").read_bytes().startswith(PNG)


def test_own_noise_input():
    """Gusts move the arm more, the more of the forearm is turned to the wind."""
    lines = printed("own_noise_input.py", "--paths", "16").splitlines()[2:]
    torques, shaken, still = ([float(line.split()[k]) for line in lines] for k in (-7, -4, -2))
    assert len(lines) == 3
    assert torques == sorted(torques, reverse=True)
    assert torques[-1] == 0.0  # it turns no area to a wind along it
    added = [a - b for a, b in zip(shaken, still, strict=True)]
    assert added == sorted(added, reverse=True)
    assert added[0] > added[-1]


@pytest.mark.slow
def test_compare_laws(tmp_path):
    text = printed("compare_laws.py", "--quick", "--out", tmp_path)
    for kind in ("rivals", "ablations", "conditions"):
        assert f"Double pendulum, white noise 0.1 (psd): {kind}" in text
        assert f"Panda on a truck's floor: {kind}" in text
    assert "…" not in text
    files = sorted(file.name for file in tmp_path.iterdir())
    pictures = ["rivals-panda-fr3.png", "rivals-panda.png", "rivals-pendulum.png"]
    assert files == ["compare-laws.json", *pictures]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "title"),
    [
        ("generator.py", "The paper's study, 8 paths of 0.3 s"),
        ("rival_singularity.py", "Panda: largest demanded torque of a path"),
        ("filters.py", "Rms error of the derivative"),
        ("basin.py", "Lost paths [%]"),
        ("sensors_and_motors.py", "sensors-and-motors.png and .json"),
    ],
)
def test_scripts_with_a_figure(tmp_path, script, title):
    quick = [] if script == "filters.py" else ["--quick"]
    assert title in printed(script, *quick, "--out", tmp_path)
    (figure,) = tmp_path.glob("*.png")
    assert figure.read_bytes().startswith(PNG)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "title"),
    [
        ("all_arms.py", "Late rms error, 4 paths"),
        ("coverage_table.py", "Coverage of 95 % intervals"),
        ("kernel_accuracy.py", "Largest error [ulp]"),
        ("velocities.py", "Panda on a truck, 2 paths of 0.2 s"),
        ("margins.py", "latency doubles"),
    ],
)
def test_scripts_with_a_table(tmp_path, script, title):
    short = ["--numbers", "20"] if script == "kernel_accuracy.py" else ["--quick"]
    text = printed(script, *short, "--out", tmp_path)
    assert title in text
    assert "…" not in text
    (record,) = tmp_path.iterdir()
    assert json.loads(record.read_text())


@pytest.mark.slow
def test_ensemble_paper(tmp_path):
    text = printed("ensemble_paper.py", "--quick", "--paths", "20", "--out", tmp_path)
    assert "20 paths of 5 s each" in text
    assert "difference, κ = 1 minus κ = 0.6, path by path" in text


@pytest.mark.slow
def test_bench_answers_a_question():
    record = json.loads(printed("bench", "paths", "--quick", "--threads", "1", "--json", "-"))
    assert [row["paths"] for row in record["paths"]["rows"]] == [1, 8, 64, 1024, 10000]
    assert all(row["us"] > 0 for row in record["paths"]["rows"])


@pytest.mark.slow
def test_fair_comparison(tmp_path):
    text = printed("fair_comparison.py", "--quick", "--out", tmp_path)
    assert "CommandFilteredBackstepping" in text
    files = sorted(file.name for file in tmp_path.iterdir())
    assert files == ["fair-comparison.json", "fair-comparison.png"]
    before = (tmp_path / "fair-comparison.json").read_bytes()
    printed("fair_comparison.py", "--quick", "--out", tmp_path)  # it runs nothing again
    assert (tmp_path / "fair-comparison.json").read_bytes() == before


@pytest.mark.slow
def test_tune_arms(tmp_path):
    gains = tmp_path / "gains.toml"
    text = printed("tune_arms.py", "--quick", "--out", tmp_path, "--gains", gains)
    assert "double_pendulum" in text
    assert set(tomllib.loads(gains.read_text())["double_pendulum"]) == {"still", "truck", "ship"}


@pytest.mark.slow
def test_which_gains_matter(tmp_path):
    text = printed("which_gains_matter.py", "--quick", "--out", tmp_path)
    assert "Panda on a truck, tuned gains" in text
    assert (tmp_path / "which-gains-matter.png").read_bytes().startswith(PNG)


@pytest.mark.slow
def test_gradients(tmp_path):
    assert "double_pendulum" in printed("gradients.py", "--quick", "--out", tmp_path)
    assert (tmp_path / "gradients.json").exists()
