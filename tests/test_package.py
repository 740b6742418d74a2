"""The wheel that a user installs: complete, and usable far from the checkout."""

import json
import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
INSTALL_TIMEOUT = 900
"""Seconds: a fresh environment fetches some 300 MB of dependencies on a slow line."""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty environment with nothing but the built wheel and what it asks for."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "-q", "-w", folder, CHECKOUT]
    subprocess.run(build, check=True, timeout=INSTALL_TIMEOUT)
    (wheel,) = folder.glob("ftcfa-*.whl")
    environment = folder / "environment"
    venv.create(environment, with_pip=True)
    install = [environment / "bin" / "pip", "install", "-q", wheel]
    subprocess.run(install, check=True, timeout=INSTALL_TIMEOUT)
    return environment / "bin"


def run(command: list[str | Path], folder: Path) -> subprocess.CompletedProcess[str]:
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return subprocess.run(command, cwd=folder, env=clean, capture_output=True, text=True)


def test_wheel_inspects_the_pendulum_from_another_directory(installed: Path, tmp_path: Path):
    done = run([installed / "ftcfa", "inspect", "double_pendulum", "--json"], tmp_path)
    assert done.returncode == 0, done.stderr
    assert [joint["name"] for joint in json.loads(done.stdout)["joints"]] == ["shoulder", "elbow"]


def test_wheel_simulates_a_catalogue_arm(installed: Path, tmp_path: Path):
    script = (
        "import ftcfa; a = ftcfa.load_arm('panda');"
        "l = ftcfa.ClosedLoop(a, ftcfa.FTCF(a), ftcfa.Sinusoid(offset=a.home));"
        "print(ftcfa.simulate(l, 0.01).sizes['joint'], ftcfa.__file__)"
    )
    done = run([installed / "python", "-W", "error", "-c", script], tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("7 ")
    assert str(CHECKOUT) not in done.stdout
