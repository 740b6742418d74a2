"""The command line as its user meets it: real runs, exit status, what goes to which stream."""

import contextlib
import io
import json
import os
import pty
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import distributed
import pytest
import xarray as xr
from matplotlib.image import imread
from typer.main import get_command

import ftcfa
from ftcfa.cli import COMMANDS, app, main
from ftcfa.cli.progress import pace
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.report.figures import STYLE
from ftcfa.study.reproduction import QUICK_CASES, QUICK_DURATION
from ftcfa.vibration.spectra.road import ROAD_CLASSES
from ftcfa.vibration.spectra.standards import standards

NAMES = [command.rpartition(":")[2] for command in COMMANDS]
FTCFA = [sys.executable, "-c", "from ftcfa.cli import main; main()"]
BAD_URDF = """<robot name="bad">
  <link name="base"/>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="forearm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
  </joint>
  <link name="forearm"><inertial><mass value="-1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"""
DPI = 60
"""Resolution of the figures here: they take most of the time of a command."""


@pytest.fixture(autouse=True, scope="module")
def coarse_figures():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(STYLE, "figure.dpi", DPI)
        yield


@pytest.fixture
def no_figures(monkeypatch) -> None:
    """Figures are left empty: other things are under test."""
    monkeypatch.setattr("ftcfa.report.figures.rendered", lambda _: {"png": b"", "svg": b""})
    monkeypatch.setattr("ftcfa.report.reproduction.rendered", lambda _: {"png": b"", "svg": b""})


def call(*words: str) -> int:
    """Run a command in this process; its exit status."""
    with pytest.raises(SystemExit) as exit_:
        main(words)
    return int(exit_.value.code or 0)


def run(*words: str, **options) -> subprocess.CompletedProcess[str]:
    """Run a command as a process of its own."""
    return subprocess.run([*FTCFA, *words], capture_output=True, text=True, **options)


def one_sentence(error: str) -> str:
    """Standard error: a single line that begins with the program's name."""
    assert error.startswith("ftcfa: ")
    assert error.count("\n") == 1
    assert "Traceback" not in error
    return error


def test_version(capsys) -> None:
    assert call("--version") == 0
    assert re.fullmatch(r"ftcfa \d+\.\d+\.\d+\S*\n", capsys.readouterr().out)


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_lists_the_commands(capsys, option) -> None:
    assert call(option) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in [*NAMES, "--version"])


@pytest.mark.parametrize("name", NAMES)
def test_help_of_a_command(capsys, monkeypatch, name) -> None:
    """It has an example, and every option says what its value is."""
    monkeypatch.setenv("COLUMNS", "100")
    assert call(name, "-h") == 0
    text = capsys.readouterr().out
    assert f"Example: ftcfa {name} " in text
    for option in get_command(app).commands[name].params:
        assert option.help.endswith(".")
        assert option.help.split()[0] in text
        is_argument = option.param_type_name == "argument"
        assert (option.metavar or option.name if is_argument else option.opts[-1]) in text


def test_inspect_shows_an_arm(capsys) -> None:
    assert call("inspect", "panda") == 0
    shown = capsys.readouterr()
    for word in ("panda_joint7", "revolute", "87", "-2.356", "16.82 kg", "Mmin, Mmax", "locked"):
        assert word in shown.out
    assert shown.err == ""


def test_inspect_json_is_one_object_and_nothing_else(capsys) -> None:
    assert call("inspect", "double_pendulum", "--gravity", "9.8", "--json") == 0
    shown = capsys.readouterr()
    record = json.loads(shown.out)
    assert [joint["effort_limit"] for joint in record["joints"]] == [15.0, 15.0]
    assert record["source"]["gravity"] == [0.0, 0.0, -9.8]
    assert record["mass_matrix_bounds"]["Mmin"] > 0
    assert len(record["warnings"]) == 2
    assert shown.err == ""


def test_inspect_passes_its_options_on(capsys, tmp_path) -> None:
    package = tmp_path / "my_arm" / "urdf"
    package.mkdir(parents=True)
    (package / "arm.urdf").write_bytes(catalogue()["double_pendulum"].path().read_bytes())
    words = ["inspect", "package://my_arm/urdf/arm.urdf", "--package-dir", str(tmp_path)]
    assert call(*words, "--lock", "elbow=0.5", "--effort-limit", "7", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert [joint["name"] for joint in record["joints"]] == ["shoulder"]
    assert record["joints"][0]["effort_limit"] == 7.0
    assert record["locked"] == {"elbow": 0.5}


def test_inspect_alone_lists_the_arms(capsys) -> None:
    assert call("inspect") == 0
    text = capsys.readouterr().out
    assert all(name in text for name in catalogue())
    assert call("inspect", "--json") == 0
    assert set(json.loads(capsys.readouterr().out)) == set(catalogue())


def test_unknown_robot_lists_the_known_ones(capsys) -> None:
    assert call("inspect", "pandora") == 2
    shown = capsys.readouterr()
    assert "'pandora'" in one_sentence(shown.err)
    assert all(name in shown.err for name in catalogue())
    assert shown.out == ""


def test_bad_urdf_is_one_sentence_even_as_json(capsys, tmp_path) -> None:
    file = tmp_path / "bad.urdf"
    file.write_text(BAD_URDF)
    assert call("inspect", str(file), "--json") == 2
    shown = capsys.readouterr()
    assert "link 'forearm': mass is -1 kg" in one_sentence(shown.err)
    assert shown.out == ""


@pytest.mark.parametrize(
    "words",
    [
        ["no_such.urdf"],
        ["panda", "--lock", "panda_joint1"],
        ["panda", "--lock", "=1"],
        ["panda", "--lock", "panda_joint1=straight"],
        ["panda", "--lock", "panda_joint1=nan"],
        ["panda", "--lock", "elbow=0"],
        ["panda", "--effort-limit", "0"],
        ["panda", "--gravity", "nan"],
        ["package://nowhere/arm.urdf"],
        ["[bold]robot"],
    ],
    ids=repr,
)
def test_bad_input_is_one_sentence(capsys, words) -> None:
    assert call("inspect", *words) == 2
    shown = capsys.readouterr()
    one_sentence(shown.err)
    assert shown.out == ""


@pytest.mark.parametrize("words", [["inspect", "panda", "--gravity", "down"], ["fly"], ["--fly"]])
def test_bad_usage(capsys, words) -> None:
    assert call(*words) == 2
    assert capsys.readouterr().err


def test_output_that_cannot_be_written(capsys, tmp_path, monkeypatch) -> None:
    """The command says so before the study, not after it."""
    monkeypatch.setattr("ftcfa.study.reproduction.run_case", lambda *_: pytest.fail("it has begun"))
    (tmp_path / "file").write_text("kept")
    assert call("reproduce", "--out", str(tmp_path / "file" / "out")) == 2
    assert "cannot be written" in one_sentence(capsys.readouterr().err)
    assert (tmp_path / "file").read_text() == "kept"


def test_full_standard_output() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*FTCFA, "inspect", "double_pendulum", "--json"],
            stdout=full, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    assert done.returncode == 2
    assert "No space left" in one_sentence(done.stderr)


def test_closed_pipe_is_quiet() -> None:
    process = subprocess.Popen(
        [*FTCFA, "inspect", "panda"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == ""
    process.wait()


OWN_TABLE = """[floor]
points = [[5, 1e-5], [20, 1e-4], [80, 1e-4]]
[deck]
points = [[2, 0.001], [10, 0.01], [40, 0.001]]
source = "own measurement"
"""


@pytest.fixture
def own_table(tmp_path, monkeypatch) -> str:
    """A user's own tables; estimates of a few segments, for speed."""
    monkeypatch.setattr("ftcfa.study.realised_spectrum.LENGTHS", 4)
    file = tmp_path / "own.toml"
    file.write_text(OWN_TABLE)
    return str(file)


def test_vibration_alone_lists_the_standards(capsys) -> None:
    assert call("vibration") == 0
    text = capsys.readouterr().out
    assert all(word in text for word in [*standards(), "unverified", "ISO 8608", "16384e-6 m^3"])
    assert call("vibration", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in record["standards"]] == list(standards())
    assert record["roads"]["roughness"] == ROAD_CLASSES
    assert "unverified" in record["roads"]["provenance"]


def test_vibration_of_a_table(capsys, own_table) -> None:
    assert call("vibration", "--table", own_table) == 0
    shown = capsys.readouterr()
    for word in ("floor", "deck", "own measurement", "not stated", "shaping filter", "substeps=1"):
        assert word in shown.out
    assert "files" not in shown.out
    assert shown.err == ""


def test_vibration_of_a_name_writes_its_figure(capsys, own_table, tmp_path) -> None:
    out = tmp_path / "new" / "out"
    assert call("vibration", "deck", "--table", own_table, "--out", str(out), "--json") == 0
    shown = capsys.readouterr()
    record = json.loads(shown.out)
    assert shown.err == ""
    files = record.pop("files")
    assert [entry["name"] for entry in record["standards"]] == ["deck"]
    assert json.loads((out / "summary.json").read_text()) == record
    assert sorted(map(Path, files)) == sorted(out.iterdir())
    assert imread(out / "spectrum.png").std() > 0.05


def test_vibration_of_a_known_name(capsys, own_table, tmp_path) -> None:  # noqa: ARG001
    assert call("vibration", "mil_std_810g_highway_truck_vertical", "--out", str(tmp_path)) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert "3 files in" in shown.out
    assert (tmp_path / "spectrum.png").exists()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["gevs"], ["vibration standard 'gevs': unknown name", *standards()]),
        (["ship", "--table", "{own}"], ["own.toml: table 'ship': unknown name", "floor, deck"]),
        (["--table", "no_such.toml"], ["no_such.toml: no such file"]),
        (["--table", "{own}.bad"], ["own.toml.bad: [floor]: points: missing"]),
        (["gevs_acceptance", "--out", "{own}/out"], ["cannot be written"]),
    ],
    ids=repr,
)
def test_vibration_of_bad_input_is_one_sentence(capsys, own_table, words, expected) -> None:
    Path(f"{own_table}.bad").write_text("[floor]\n")
    assert call("vibration", *(word.format(own=own_table) for word in words)) == 2
    shown = capsys.readouterr()
    assert all(text in one_sentence(shown.err) for text in expected)
    assert shown.out == ""


EXPERIMENT = """
duration = 0.7
seed = 4
paths = 24
chunk = 8
q0 = [-0.1, 0.25]
v0 = [-0.3, 0.45]

[arm]
robot = "double_pendulum"

[controller]
type = "FTCF"

[reference]
type = "Sinusoid"
amplitude = [1.5, 1.0]
angular_frequency = [1.0, 2.0]

[vibration]
input = { type = "BaseAcceleration", axes = "xz" }
excitation = { type = "WhiteNoise", intensity = 0.1, convention = "amplitude" }
"""
SPECIFICATION = """
[specification]
error = 0.05
within = 0.6
"""


@pytest.fixture
def experiment(tmp_path) -> str:
    """An experiment's file."""
    file = tmp_path / "experiment.toml"
    file.write_text(EXPERIMENT + SPECIFICATION)
    return str(file)


def test_run_writes_the_ensemble(capsys, experiment, tmp_path) -> None:
    out = tmp_path / "new" / "out"
    assert call("run", experiment, "--out", str(out), "--json") == 0
    shown = capsys.readouterr()
    assert shown.err == ""  # no progress where there is no terminal
    record = json.loads(shown.out)
    files = record.pop("files")
    assert json.loads((out / "summary.json").read_text()) == record
    assert sorted([*map(Path, files), out / "ensemble.zarr"]) == sorted(out.iterdir())
    assert imread(out / "ensemble.png").std() > 0.05
    expected = ftcfa.load_experiment(experiment).run()
    xr.testing.assert_identical(xr.open_dataset(out / "ensemble.nc"), expected)
    stored = xr.open_zarr(out / "ensemble.zarr", group="result", consolidated=False)
    xr.testing.assert_identical(stored.load(), expected)


@pytest.mark.usefixtures("no_figures")
def test_run_prints_a_table(capsys, experiment, tmp_path) -> None:
    words = ["run", experiment, "--out", str(tmp_path / "out"), "--paths", "3", "--threads", "1"]
    assert call(*words, "--duration", "0.2") == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    for word in ("3 of seed 4, 0.2 s each", "E|z1|^2", "Definition 1", "torque rate", "energy"):
        assert word in shown.out
    files = "ensemble.nc, ensemble.png, ensemble.svg, summary.json"
    assert files in " ".join(shown.out.split())


def test_run_goes_on_where_it_was(capsys, experiment, tmp_path) -> None:
    short, whole = str(tmp_path / "short"), str(tmp_path / "whole")
    assert call("run", experiment, "--out", short, "--paths", "8", "--json") == 0
    kept = Path(short, "ensemble.zarr", "chunks", "000000")
    before = kept.stat().st_mtime_ns
    assert call("run", experiment, "--out", short) == 0
    assert kept.stat().st_mtime_ns == before
    assert call("run", experiment, "--out", whole) == 0
    capsys.readouterr()
    for name in ("ensemble.nc", "summary.json", "ensemble.png"):
        assert Path(short, name).read_bytes() == Path(whole, name).read_bytes()


@pytest.mark.usefixtures("no_figures")
def test_interrupted_run_says_what_is_done_and_goes_on(capsys, experiment, tmp_path) -> None:
    out = tmp_path / "out"
    command = [*FTCFA, "run", experiment, "--out", str(out)]
    process = subprocess.Popen(
        [*command, "--paths", "1000000", "--json"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    chunks = out / "ensemble.zarr" / "chunks"
    while process.poll() is None and len(list(chunks.glob("[0-9]*[0-9]"))) < 3:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    text, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (130, "")
    record = json.loads(text)
    assert 16 <= record["paths"] < record["requested"] == 1000000
    assert json.loads((out / "summary.json").read_text())["paths"] == record["paths"]
    done = len(list(chunks.glob("[0-9]*[0-9]")))
    assert call("run", experiment, "--out", str(out), "--paths", str(8 * done), "--json") == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert json.loads(shown.out)["paths"] == 8 * done


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["no_such.toml"], "no such file"),
        (["{file}", "--paths", "0"], "paths: 0, expected an integer >= 1"),
        (["{file}", "--duration", "-1"], "duration: -1.0, expected a number >= 0"),
        (["{file}", "--threads", "0"], "--threads: 0, expected an integer >= 1"),
        (["{file}", "--out", "{file}/out"], "cannot be written"),
        (
            ["{file}", "--scheduler", "here"],
            "--scheduler: here, expected an address such as tcp://",
        ),
    ],
    ids=repr,
)
def test_run_of_bad_input_is_one_sentence(capsys, experiment, monkeypatch, words, message) -> None:
    monkeypatch.chdir(Path(experiment).parent)
    assert call("run", *(word.format(file=experiment) for word in words)) == 2
    shown = capsys.readouterr()
    assert message in one_sentence(shown.err)
    assert shown.out == ""


def test_a_wrong_file_gives_all_its_errors(capsys, experiment) -> None:
    text = EXPERIMENT.replace("paths", "path").replace("seed = 4", "seed = -1")
    Path(experiment).write_text(text)
    for command in ("run", "verify"):
        assert call(command, experiment) == 2
        lines = capsys.readouterr().err.splitlines()
        assert lines == [
            f"ftcfa: {experiment}: path: unknown key; did you mean 'paths'?",
            f"ftcfa: {experiment}: seed: -1, expected an integer from 0 to 2^64 - 1",
        ]


@pytest.mark.usefixtures("no_figures")
def test_run_of_another_experiment_leaves_the_store(capsys, experiment, tmp_path) -> None:
    out = str(tmp_path / "out")
    assert call("run", experiment, "--out", out, "--paths", "8", "--json") == 0
    before = Path(out, "summary.json").read_bytes()
    capsys.readouterr()
    assert call("run", experiment, "--out", out, "--duration", "0.1") == 2
    assert "they differ in plan.duration" in one_sentence(capsys.readouterr().err)
    assert Path(out, "summary.json").read_bytes() == before


def test_a_scheduler_that_does_not_answer(experiment, tmp_path) -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{listener.getsockname()[1]}"  # nobody listens there
        done = run("run", experiment, "--out", str(tmp_path / "out"), "--scheduler", address)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"no answer from {address} within 5 s" in one_sentence(done.stderr)


def cluster(workers: int) -> distributed.LocalCluster:
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=False, protocol="tcp://",
        host="127.0.0.1", dashboard_address=None,
    )  # fmt: skip


@pytest.mark.usefixtures("no_figures")
def test_run_on_a_cluster_gives_the_same(capsys, experiment, tmp_path) -> None:
    there, here = tmp_path / "there", tmp_path / "here"
    with cluster(1) as workers:
        address = workers.scheduler_address
        assert call("run", experiment, "--out", str(there), "--scheduler", address) == 0
    assert capsys.readouterr().err == ""
    assert call("run", experiment, "--out", str(here)) == 0
    assert (there / "ensemble.nc").read_bytes() == (here / "ensemble.nc").read_bytes()


def test_a_scheduler_without_workers(capsys, experiment, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("ftcfa.cli.cluster.SECONDS_TO_ANSWER", 1)
    with cluster(0) as nobody:
        words = ["--out", str(tmp_path / "out"), "--scheduler", nobody.scheduler_address]
        assert call("run", experiment, *words) == 2
    assert "has no workers, expected one or more" in one_sentence(capsys.readouterr().err)


def test_a_scheduler_needs_its_package(capsys, experiment, tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    words = ["--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:1"]
    assert call("run", experiment, *words) == 2
    assert "pip install 'ftcfa[cluster]'" in one_sentence(capsys.readouterr().err)


def test_run_shows_its_progress_on_a_terminal(experiment, tmp_path) -> None:
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*FTCFA, "run", experiment, "--out", str(tmp_path / "out"), "--json"],
        stdout=subprocess.PIPE, stderr=theirs, text=True, env={**os.environ, "TERM": "xterm"},
    )  # fmt: skip
    os.close(theirs)
    text, _ = process.communicate(timeout=120)
    shown = b""
    with contextlib.suppress(OSError):  # which says that the terminal is closed
        while part := os.read(ours, 65536):
            shown += part
    os.close(ours)
    assert json.loads(text)["paths"] == 24
    assert b"24 of 24 paths" in shown
    assert b"paths/s" in shown
    assert b"left" in shown


@pytest.mark.parametrize(
    ("done", "seconds", "paths", "message"),
    [
        (0, 3.0, 0, "0 of 5,000 paths"),
        (1000, 2.0, 1000, "1,000 of 5,000 paths, 500 paths/s, 0:00:08 left"),
        (2000, 2000.0, 1000, "2,000 of 5,000 paths, 0.5 paths/s, 1:40:00 left"),
        (5000, 1.0, 500, "5,000 of 5,000 paths, 500 paths/s, 0:00:00 left"),
    ],
)
def test_rate_and_time_left(done, seconds, paths, message) -> None:
    assert pace(done, 5000, seconds, paths) == message


@pytest.mark.parametrize(
    ("words", "status", "answer"),
    [
        ([], 0, "yes"),
        (["--within", "0.3", "--effort", "20"], 1, "no"),
        (["--budget", "20"], 3, "undecided"),
    ],
)
def test_verify_answers_by_its_exit_status(capsys, experiment, words, status, answer) -> None:
    assert call("verify", experiment, *words) == status
    shown = capsys.readouterr()
    assert shown.err == ""
    assert shown.out.splitlines()[0] == answer
    assert "each with confidence 0.95" in shown.out
    assert call("verify", experiment, *words, "--json", "--threads", "1") == status
    record = json.loads(capsys.readouterr().out)
    assert record["answer"] == answer
    assert record["seed"] == 4
    assert record["share"]["low"] < 1.0


def test_verify_shows_how_to_see_the_worst_path(capsys, experiment) -> None:
    words = ["--torque-rate", "4000", "--share", "0.9", "--json"]
    assert call("verify", experiment, *words) == 1
    worst = json.loads(capsys.readouterr().out)["worst"][0]
    assert worst["reason"] == f"torque rate {worst['excess']:.3g} times its limit"
    path = eval(worst["replay"], {"ftcfa": ftcfa})
    rate = float(abs(path.u.diff("time")).max()) / 1e-3
    assert rate == pytest.approx(4000 * worst["excess"])
    assert rate > 4000


def test_verify_of_options_alone(capsys, experiment) -> None:
    Path(experiment).write_text(EXPERIMENT)
    assert call("verify", experiment, "--error", "0.05", "--within", "0.6") == 0
    capsys.readouterr()
    assert call("verify", experiment, "--error", "0.05") == 2
    assert one_sentence(capsys.readouterr().err) == (
        "ftcfa: specification: missing, expected a table [specification] in the file with error "
        "and within; or give --within and --error or --tool-error\n"
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--within", "3"], "within: 3 s, expected less than the duration of 0.7 s"),
        (["--share", "95"], "share: 95.0, expected a number between 0 and 1; give 0.95 for 95"),
        (["--error", "-1"], "error: -1.0, expected a number > 0"),
        (["--threads", "0"], "--threads: 0, expected an integer >= 1"),
    ],
)
def test_verify_of_bad_input_is_one_sentence(capsys, experiment, words, message) -> None:
    assert call("verify", experiment, *words) == 2
    shown = capsys.readouterr()
    assert message in one_sentence(shown.err)
    assert shown.out == ""


def test_compare_of_chosen_laws(capsys, tmp_path) -> None:
    laws = ("--controller", "FTCF", "--controller", "PDGravity")
    assert call("compare", *laws, "--paths", "8", "--duration", "0.1", "--out", str(tmp_path)) == 0
    shown = capsys.readouterr()
    assert "PDGravity against as given: " in shown.out
    assert shown.err == ""
    assert imread(tmp_path / "comparison.png").std() > 0.01
    record = json.loads((tmp_path / "summary.json").read_text())
    assert [row["loop"] for row in record["loops"]] == ["as given", "FTCF", "PDGravity"]


TUNE = ("--generations", "2", "--candidates", "4", "--paths", "2", "--duration", "0.2")


def test_tune_writes_an_experiment_with_the_tuned_gains(capsys, experiment, tmp_path) -> None:
    out = tmp_path / "tuned.toml"
    status = call("tune", experiment, *TUNE, "--validate", "8", "--out", str(out), "--json")
    record = json.loads(capsys.readouterr().out)
    assert status == {"yes": 0, "no": 1}[record["answer"]]
    assert record["file"] == str(out)
    assert record["validation"]["paths"] == 8
    tuned = ftcfa.load_experiment(out).loop.controller
    assert tuned.gains.c1 == record["gains"]["controller.gains.c1"]["value"]
    assert call("run", str(out), "--paths", "4", "--out", str(tmp_path / "out")) == 0


def test_tune_shows_a_table_and_goes_on(capsys, experiment, tmp_path) -> None:
    words = (*TUNE, "--validate", "0", "--store", str(tmp_path / "search.json"), "--per-joint")
    call("tune", experiment, *words)
    first = capsys.readouterr()
    assert "controller.gains.c1" in first.out
    assert first.err == ""
    call("tune", experiment, *words)
    assert capsys.readouterr().out == first.out
    assert call("tune", experiment, *words, "--seed", "5") == 2
    assert "of another search: plan differ" in one_sentence(capsys.readouterr().err)


def test_tune_answers_no_where_nothing_keeps_the_limits(capsys, experiment) -> None:
    text = Path(experiment).read_text()
    limit = '{ metric = "late_peak_error", at_most = 1e-9 }'
    objective = f'[objective]\nterms = [{{ metric = "late_rms_error" }}]\nlimits = [{limit}]\n'
    Path(experiment).write_text(f"{text}\n{objective}")
    assert call("tune", experiment, *TUNE, "--validate", "0") == 1
    assert "no: none of 8 candidates" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--generations", "0"], "tune generations: 0, expected an integer >= 1"),
        (["--controller", "PID"], "'PID'"),
        (["--controller", "PDGravity", "--theorem"], "the only law that Theorem 1 covers"),
    ],
)
def test_tune_of_bad_input_is_one_sentence(capsys, experiment, words, message) -> None:
    assert call("tune", experiment, *TUNE, *words) == 2
    assert message in one_sentence(capsys.readouterr().err)


def test_compare_of_ingredients_is_one_object(capsys, experiment) -> None:
    words = ("--against", "ablations", "--paths", "8", "--duration", "0.1", "--json")
    assert call("compare", experiment, *words) == 0
    record = json.loads(capsys.readouterr().out)
    names = [row["loop"] for row in record["loops"]]
    assert names[0] == "as given"
    assert "without the network" in names


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--controller", "ftcf"), "controller 'ftcf': unknown name, expected one of: FTCF, "),
        (
            ("--against", "ablations", "--controller", "FTCF"),
            "--controller: FTCF with --against ablations, expected --against rivals",
        ),
        (("--out", "/dev/null/x"), "cannot be written"),
    ],
)
def test_compare_of_bad_input_is_one_sentence(capsys, words, message) -> None:
    assert call("compare", "--paths", "2", "--duration", "0.01", *words) == 2
    assert message in one_sentence(capsys.readouterr().err)


@pytest.fixture(scope="module")
def quick(tmp_path_factory) -> tuple[int, str, str, Path]:
    """A quick look: its status, its two streams, and its output folder."""
    out = tmp_path_factory.mktemp("reproduce") / "new" / "out"
    streams = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        status = call("reproduce", "--quick", "--out", str(out), "--json")
    return status, *(stream.getvalue() for stream in streams), out


def test_quick_reproduction_says_what_it_did(quick) -> None:
    status, text, error, out = quick
    assert (status, error) == (0, "")  # no progress bar where there is no terminal
    record = json.loads(text)
    assert record["quick"] is True
    assert record["duration"] == QUICK_DURATION
    assert len(record["cases"]) == len(QUICK_CASES)
    assert record["cases"][0]["rms_ote"] < 0.1 * record["cases"][1]["rms_ote"]
    files = record.pop("files")
    assert json.loads((out / "summary.json").read_text()) == record
    assert sorted(map(Path, files)) == sorted(out.iterdir())  # and no temporary file left


def test_quick_reproduction_draws_its_figures(quick) -> None:
    *_, out = quick
    for name in ("figure-1-1", "figure-1-2", "figure-2", "figure-filter"):
        assert imread(out / f"{name}.png").std() > 0.05
        assert (out / f"{name}.svg").read_text().rstrip().endswith("</svg>")


@pytest.mark.usefixtures("no_figures")
def test_table_of_the_quick_reproduction(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("ftcfa.study.reproduction.QUICK_DURATION", 0.1)
    assert call("reproduce", "--quick", "--out", str(tmp_path)) == 0
    shown = capsys.readouterr()
    assert f"{len(QUICK_CASES)} of " in shown.out
    assert "0.1 s of 20 s" in shown.out
    assert "9 files" in shown.out
    assert shown.err == ""


def test_interrupt_is_clean(tmp_path) -> None:
    out = tmp_path / "out"
    process = subprocess.Popen(
        [*FTCFA, "reproduce", "--out", str(out)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while process.poll() is None and not out.exists():
        time.sleep(0.01)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    text, error = process.communicate(timeout=60)
    assert (process.returncode, text, error) == (130, "", "")
    assert not list(out.iterdir())
