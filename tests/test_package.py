"""The wheel that a user installs: complete, and usable far from the checkout."""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]


@pytest.fixture(scope="module", params=["running", pytest.param("fresh", marks=pytest.mark.slow)])
def installed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment with the built wheel.

    It sees the packages of the environment that runs the tests, and downloads nothing; or it is
    fresh, and fetches what the wheel requires, some 300 MB.
    """
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder]
    subprocess.run(build, check=True, cwd=CHECKOUT, capture_output=True)
    (wheel,) = folder.glob("ftcfa-*.whl")
    environment = folder / "environment"
    venv.create(environment, with_pip=False)
    options = []
    if request.param != "fresh":
        options = ["--no-deps", "--no-index"]
        (packages,) = environment.glob("lib/python*/site-packages")
        running = sysconfig.get_path("purelib")
        (packages / "running.pth").write_text(f"import site; site.addsitedir({running!r})")
    pip = [sys.executable, "-m", "pip", "--python", environment / "bin" / "python"]
    subprocess.run([*pip, "install", "-q", *options, wheel], check=True)
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
    assert done.stdout.startswith(f"7 {installed.parent}")
