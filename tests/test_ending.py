"""How commands end: the exit status, and what stands on the outputs, whatever happens."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ftcfa import ParameterError, ensemble, load_experiment
from ftcfa.cli import main
from ftcfa.files import local_path

FTCFA = [str(Path(sys.executable).with_name("ftcfa"))]
SOON = 4.0
"""Time in which an interrupted process ends on a busy machine; a second on an idle one [s]."""
EXPERIMENT = """duration = {duration}
paths = {paths}
arm = {{ robot = "double_pendulum" }}
controller = {{ type = "FTCF" }}
reference = {{ type = "Sinusoid", amplitude = [0.3, 0.2] }}
{more}
"""


@pytest.fixture
def experiment(tmp_path):
    def write(duration=1.0, paths=100, more=""):
        file = tmp_path / "e.toml"
        file.write_text(EXPERIMENT.format(duration=duration, paths=paths, more=more))
        return file

    return write


def test_a_fault_of_ours_is_one_sentence_and_70(monkeypatch, capsys):
    def broken(*_, **__):
        raise TypeError("a\nb")

    monkeypatch.setattr("ftcfa.model.urdf.load.load_arm", broken)
    with pytest.raises(SystemExit) as caught:
        main(["inspect", "panda"])
    assert caught.value.code == 70
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ftcfa: a fault of ours, not of your input (TypeError: a\\nb; ")


@pytest.mark.parametrize("options", [[], ["--json"]])
@pytest.mark.parametrize("command", ["inspect", "vibration"])
def test_a_closed_pipe_gives_141(command, options):
    words = [*FTCFA, command, *(["baxter"] if command == "inspect" else []), *options]
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (141, b"")


def test_verify_piped_to_grep_does_not_say_no(experiment):
    file = experiment(
        duration=1.0, more="[specification]\nerror = 3.0\nwithin = 0.1\nshare = 0.5\n"
    )
    shell = f"set -o pipefail; {FTCFA[0]} verify {file} | grep -q yes"
    for _ in range(3):
        done = subprocess.run(["bash", "-c", shell], stderr=subprocess.PIPE, check=False)
        assert done.returncode in (0, 141), done.stderr


def test_an_interrupt_in_a_long_chunk_is_obeyed_soon(experiment, tmp_path):
    file = experiment(duration=100.0, paths=100_000)
    words = [*FTCFA, "run", str(file), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    store = tmp_path / "out" / "ensemble.zarr"
    while not store.exists():
        time.sleep(0.05)
    time.sleep(1.0)
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - start < SOON


TOO_MUCH = {
    "paths": {"paths": 10**12},
    "duration": {"duration": 1e12},
    "substeps": {"more": "substeps = 1_000_000_000_000"},
    "steps": {"paths": 10**6, "duration": 1e5, "more": "substeps = 100_000"},
}


def test_a_verification_beyond_the_machine(experiment, capsys):
    required = "[specification]\nerror = 0.1\nwithin = 0.5\nbudget = 1_000_000_000_000\n"
    more = f"substeps = 1_000_000\nperiod = 1e-6\n{required}"
    with pytest.raises(SystemExit) as caught:
        main(["verify", str(experiment(duration=3000.0, more=more))])
    assert caught.value.code == 2
    assert "reference at every sample" in capsys.readouterr().err


@pytest.mark.parametrize("name", TOO_MUCH)
def test_work_beyond_the_machine_is_refused_before_it_begins(name, experiment, tmp_path, capsys):
    start = time.monotonic()
    with pytest.raises(SystemExit) as caught:
        main(["run", str(experiment(**TOO_MUCH[name])), "--out", str(tmp_path / "out")])
    assert caught.value.code == 2
    assert time.monotonic() - start < SOON + 6.0
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_chunk_beyond_the_memory(experiment):
    loop = load_experiment(experiment()).loop
    with pytest.raises(ParameterError, match=r"a chunk: .* GiB, expected at most half"):
        ensemble(loop, 10**7, 1.0, chunk=10**7)


@pytest.mark.parametrize("url", ["s3://bucket/x", "https://x.y/z", "file:///tmp/x"])
def test_urls_are_no_folders(url, experiment, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as caught:
        main(["run", str(experiment()), "--out", url])
    assert caught.value.code == 2
    assert "a URL, expected a path of this machine" in capsys.readouterr().err
    assert {p.name for p in tmp_path.iterdir()} == {"e.toml"}
    with pytest.raises(ParameterError, match="a URL"):
        ensemble(load_experiment(experiment()).loop, 2, 0.1, store=url)


def test_home_is_resolved(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert local_path("~/x") == tmp_path / "x"
    with pytest.raises(ParameterError, match="home directory"):
        local_path("~nobody_of_that_name/x")
