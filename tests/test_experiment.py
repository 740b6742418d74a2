"""Experiments as files and descriptions: the same bits when run, and all that is wrong at once."""

import dataclasses
import hashlib
import json
import subprocess
import sys
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest
import xarray as xr

import ftcfa
from ftcfa import (
    FTCF,
    TRUCK,
    BaseAcceleration,
    BaseMotion,
    ClosedLoop,
    CommandFilteredBackstepping,
    ComputedTorque,
    Constant,
    Experiment,
    ExperimentError,
    ExplicitFilter,
    FiniteTimeBackstepping,
    FrameWrench,
    Gains,
    Harmonic,
    ImplicitFilter,
    JointTorque,
    LinearFilter,
    MinimumJerk,
    PaperPendulum,
    PaperPendulumInput,
    ParameterError,
    PDGravity,
    ProperFilter,
    RandomPhase,
    RBFNetwork,
    Record,
    RecordedAcceleration,
    Road,
    SecondOrderFilter,
    ShapedNoise,
    SineSweep,
    Sinusoid,
    SlotineLi,
    Specification,
    Spectrum,
    Stacked,
    Standard,
    StochasticBackstepping,
    Superposition,
    SuperTwisting,
    Table,
    Uncertainty,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    load_experiment,
    simulate,
    verify,
)
from ftcfa.description.hints import choices, element
from ftcfa.description.read import rebuild
from ftcfa.description.registry import PARTS
from ftcfa.description.write import describe, document, self_contained
from ftcfa.model.urdf.catalogue import catalogue, robots_folder

DURATION = 0.05
ARM = load_arm("double_pendulum")
URDF = (robots_folder() / "double_pendulum.urdf").read_text()
THIRD = 1.0 / 3.0
"""A float that no short decimal is."""
RNG = np.random.default_rng(7)
RECORD = Record(0.004, RNG.standard_normal((50, 2)), ("x", "z"), ("by hand",))
BAND = Spectrum([5.0, 20.0, 60.0], [0.1, 0.2, 0.05])
COLOUR = LinearFilter([[-3.0, 1.0], [0.0, -THIRD]], [[0.0], [1.0]], [[1.0, 0.0]])


def loop(arm=ARM, *, excitation=None, axes="xz", vibration=None, **changes):
    """A pendulum under the paper's law, shaken."""
    if excitation is not None:
        vibration = Vibration(BaseAcceleration(axes), excitation)
    parts = {"controller": FTCF(arm), "reference": Sinusoid(THIRD, 1.0, 0.0, arm.home)}
    return ClosedLoop(arm, **{**parts, "vibration": vibration, **changes})


def shaped(*axes):
    return loop(excitation=ShapedNoise(axes), axes="x", substeps=4)


LOOPS = {
    "still": lambda: loop(),
    "numbers of a loop": lambda: loop(
        period=THIRD / 100, substeps=3, integrator="semi-implicit", q0=[0.1, THIRD], v0=[0.2, 1e-17]
    ),
    "keywords of load_arm": lambda: loop(
        load_arm(
            "panda",
            lock={"panda_joint7": THIRD, "panda_finger_joint1": 0.02},
            gravity=[0.0, THIRD, -9.0],
            effort_limit={"panda_joint1": 50 * THIRD},
            mounting="wall",
        )
    ),
    "gains, filter, network": lambda: loop(
        controller=FTCF(
            ARM, Gains(c1=THIRD), ExplicitFilter(700.0, 170.0), "gravity", RBFNetwork(7, THIRD)
        )
    ),
    "other filter": lambda: loop(controller=FTCF(ARM, filter=ImplicitFilter(700.0))),
    "second-order filter": lambda: loop(
        controller=FTCF(ARM, filter=SecondOrderFilter(100.0, THIRD))
    ),
    "proper filter": lambda: loop(controller=FTCF(ARM, filter=ProperFilter(1e5 * THIRD))),
    "ablation": lambda: loop(
        controller=FTCF(ARM, error_compensation=False, anti_saturation=False, adaptation=False)
    ),
    "command-filtered": lambda: loop(
        controller=CommandFilteredBackstepping(ARM, Gains(c2=THIRD), "proper", "none")
    ),
    "stochastic backstepping": lambda: loop(
        controller=StochasticBackstepping(ARM, Gains(k1=THIRD), "gravity")
    ),
    "finite-time backstepping": lambda: loop(
        controller=FiniteTimeBackstepping(ARM, width=THIRD, compensation="none")
    ),
    "computed torque": lambda: loop(controller=ComputedTorque(ARM, 10.0 * THIRD)),
    "PD with gravity": lambda: loop(controller=PDGravity(ARM, 10.0 * THIRD, 20.0 * THIRD)),
    "Slotine and Li": lambda: loop(controller=SlotineLi(ARM, leakage=THIRD)),
    "super-twisting": lambda: loop(controller=SuperTwisting(ARM, r1=10.0 * THIRD)),
    "drawn arm, drawn nominal": lambda: loop(
        ARM.perturbed(np.random.default_rng(1)),
        controller=FTCF(ARM.perturbed(np.random.default_rng(2)), compensation="bias"),
    ),
    "a path's own robot": lambda: loop(
        Uncertainty(mass=0.2, friction=0.3).robot(load_arm("xarm7"), seed=1, path=2)
    ),
    "closed form": lambda: loop(
        PaperPendulum(m=(0.5, THIRD), as_printed=True, effort_limit=np.array([THIRD, 9.0])),
        vibration=Vibration(PaperPendulumInput(m=(0.5, THIRD)), WhiteNoise(THIRD)),
        reference=Constant([0.1, THIRD]),
    ),
    "closed form, nominal from a URDF": lambda: loop(PaperPendulum(), controller=FTCF(ARM)),
    "minimum jerk": lambda: loop(reference=MinimumJerk([0.0, THIRD], [[0.0, 0.1], [THIRD, 0.2]])),
    "table": lambda: loop(
        reference=Table([0.0, 0.1, THIRD], [[0.0, 0.1], [THIRD, 0.2], [0.3, 0.3]])
    ),
    "uncertainty": lambda: loop(
        load_arm("xarm7"),
        uncertainty=Uncertainty(THIRD, friction=0.1, payload=(0.1, THIRD), distribution="bounded"),
    ),
    "correlated white noise": lambda: loop(
        excitation=WhiteNoise([[0.2, THIRD / 9], [THIRD / 9, 0.1]], "amplitude")
    ),
    "level": lambda: loop(vibration=Vibration(BaseAcceleration("x"), WhiteNoise(0.1), THIRD)),
    "joint torques": lambda: loop(vibration=Vibration(JointTorque(("elbow",)), WhiteNoise(THIRD))),
    "all joint torques": lambda: loop(vibration=Vibration(JointTorque(), WhiteNoise(THIRD))),
    "wrench": lambda: loop(
        load_arm("ur5"),
        vibration=Vibration(FrameWrench("tool0", ("x", "z"), "y"), WhiteNoise(THIRD)),
    ),
    "turning base": lambda: loop(
        vibration=Vibration(BaseMotion("x", "y"), ShapedNoise((BAND, BAND))), substeps=4
    ),
    "spectrum": lambda: shaped(BAND),
    "filter": lambda: shaped(COLOUR),
    "road": lambda: shaped(Road("B", 20 * THIRD, TRUCK)),
    "road under a filter": lambda: shaped(Road("C", 20.0, COLOUR)),
    "table by name": lambda: shaped("mil_std_810g_highway_truck_vertical"),
    "table of one's own": lambda: shaped(Standard("floor", "measured", "by us", None, BAND)),
    "random phase": lambda: loop(excitation=RandomPhase(BAND, 50), axes="x", substeps=4),
    "record": lambda: loop(excitation=RecordedAcceleration(RECORD, random_start=False)),
    "harmonic": lambda: loop(excitation=Harmonic([THIRD, 1.0], 10.0), axes="xz"),
    "sweep": lambda: loop(excitation=SineSweep(THIRD, 5.0, 50.0, 0.04, "linear"), axes="x"),
    "sum": lambda: loop(
        excitation=Superposition((WhiteNoise(THIRD), Harmonic(1.0, 10.0))), axes="x"
    ),
    "stack": lambda: loop(excitation=Stacked((WhiteNoise(THIRD), RECORD_OF_ONE), (1, 1))),
}
RECORD_OF_ONE = RecordedAcceleration(Record(0.002, RNG.standard_normal((60, 1))))


@pytest.fixture(scope="module", params=LOOPS)
def written(request):
    """An experiment that Python built, and what came of it."""
    experiment = Experiment(LOOPS[request.param](), DURATION, seed=3)
    return experiment, simulate(experiment.loop, experiment.duration, seed=experiment.seed)


def same_bits(experiment, path):
    again = simulate(experiment.loop, experiment.duration, seed=experiment.seed)
    return all(np.array_equal(again[name], path[name], equal_nan=True) for name in path.data_vars)


def test_save_load_and_run_gives_the_same_bits(written, tmp_path):
    experiment, path = written
    experiment.save(tmp_path / "experiment.toml")
    again = load_experiment(tmp_path / "experiment.toml")
    assert same_bits(again, path)
    assert again.to_text() == experiment.to_text()
    assert again.digest == experiment.digest


def test_send_and_run_gives_the_same_bits(written):
    experiment, path = written
    text = experiment.description()
    again = Experiment.from_description(text)
    assert same_bits(again, path)
    assert again.description() == text


def types_in(part):
    if isinstance(part, list | tuple):
        return set().union(*map(types_in, part))
    if not dataclasses.is_dataclass(part):
        return set()
    if isinstance(part, ftcfa.Arm):
        return {ftcfa.Arm}
    inside = (types_in(getattr(part, field.name)) for field in dataclasses.fields(part))
    return {type(part)}.union(*inside)


def reachable(cls):
    """All parts that a part may be made of."""
    found, waiting = set(), [cls]
    while waiting:
        part = waiting.pop()
        if part not in found:
            found.add(part)
            hints = [] if part is ftcfa.Arm else [*get_type_hints(part).values()]
            waiting.extend(one for hint in hints for one in choices(hint))
            waiting.extend(one for hint in hints for one in choices(element(hint)))
    return found


def test_every_kind_of_part_is_among_the_loops():
    used = set().union(*(types_in(make()) for make in LOOPS.values()))
    assert used == reachable(ClosedLoop)
    assert used >= {part for parts in PARTS.values() for part in parts}


def test_every_public_part_can_be_written():
    results = {
        "Bounds",
        "FilterFit",
        "InertiaBounds",
        "InertiaSplit",
        "RealisedStandard",
        "SpectrumEstimate",
        "Verification",
    }
    public = {name: getattr(ftcfa, name) for name in ftcfa.__all__}
    parts = {
        n: it for n, it in public.items() if isinstance(it, type) and dataclasses.is_dataclass(it)
    }
    assert {name for name, it in parts.items() if it not in reachable(Experiment)} <= results


FILE = """
duration = 0.05
seed = 5
paths = 20
record_every = 2
tolerance = 0.04
after = 0.01
quantiles = [0.1, 0.5]
chunk = 8
period = 2e-3

[specification]
error = 0.3
within = 0.02
effort = [150, 150, 150, 28, 28, 28]
share = 0.9

[arm]
robot = "ur5"

[controller]
type = "FTCF"
compensation = "bias"
gains = { c1 = 8 }
nominal = { robot = "ur5", gravity = 9.7 }

[reference]
type = "Sinusoid"
amplitude = 0.2
offset = "home"

[vibration]
input = { type = "BaseAcceleration", axes = ["x", "z"] }
excitation = { type = "WhiteNoise", intensity = 0.2 }
"""


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
    asked = Specification(0.3, 0.02, [150, 150, 150, 28, 28, 28], share=0.9)
    assert dataclasses.astuple(experiment.specification) == dataclasses.astuple(asked)
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
    found = experiment.verify(threads=1)
    again = verify(experiment.loop, experiment.specification, 0.05, seed=5)
    assert found.specification is experiment.specification
    assert (found.answer, found.verdict, found.seed) == (again.answer, again.verdict, 5)


def test_without_a_specification_there_is_nothing_to_verify():
    with pytest.raises(ParameterError) as caught:
        Experiment(loop(), 1.0).verify()
    assert str(caught.value) == (
        "Experiment specification: missing, expected a Specification; "
        "in a file: a table [specification] with error and within"
    )


def test_what_an_experiment_says_of_its_ensemble_comes_back():
    asked = Specification(THIRD, 0.5, torque_rate=[1.0, THIRD], budget=7)
    written = Experiment(loop(), 1.0, 3, 9, 2, THIRD, 0.25, (THIRD, 0.5), 7, asked)
    again = Experiment.from_text(written.to_text())
    assert "type" not in written.to_text().split("[specification]")[1].split("[")[0]
    for name in ("seed", "paths", "record_every", "tolerance", "after", "quantiles", "chunk"):
        assert getattr(again, name) == getattr(written, name)
    assert dataclasses.astuple(again.specification) == dataclasses.astuple(asked)
    assert (
        again.digest == written.digest == Experiment.from_description(written.description()).digest
    )
    assert dataclasses.replace(written, specification=None).digest != written.digest


def test_home_is_the_posture_of_the_arm_wherever_postures_are_expected():
    text = FILE.replace('type = "Sinusoid"\namplitude = 0.2\noffset = "home"', """
type = "MinimumJerk"
times = [0.0, 1.0]
points = ["home", [0, 1, 2, 3, 4, 5]]""").replace("seed", 'q0 = "home"\nseed')  # fmt: skip
    experiment = Experiment.from_text(text)
    home = load_arm("ur5").home
    assert np.array_equal(experiment.loop.q0, home)
    assert np.array_equal(experiment.loop.reference.points, [home, [0, 1, 2, 3, 4, 5]])


def test_a_nominal_arm_that_is_the_true_one_is_written_once():
    assert "nominal" not in Experiment(loop(), 1.0).to_text()
    assert (
        "nominal" not in Experiment(loop(controller=FTCF(load_arm("double_pendulum"))), 1).to_text()
    )
    assert "[controller.nominal]" in Experiment(loop(controller=FTCF(PaperPendulum())), 1).to_text()
    again = Experiment.from_text(Experiment(loop(), 1.0).to_text()).loop
    assert again.controller.nominal is again.arm


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


def test_a_loop_alone_travels_too():
    told = json.loads(json.dumps(self_contained(document(loop(excitation=WhiteNoise(THIRD))))))
    again = rebuild(ClosedLoop, told, "loop", Path())
    assert same_bits(
        Experiment(again, DURATION), simulate(loop(excitation=WhiteNoise(THIRD)), DURATION)
    )


@dataclasses.dataclass(frozen=True)
class Goal:
    """Settings that a later version might add."""

    share: float = 0.9


@dataclasses.dataclass(frozen=True, eq=False)
class Richer(Experiment):
    """An experiment with one more table."""

    goal: Goal | None = None


def test_a_new_field_needs_no_more_than_its_type():
    made = Richer.from_text(FILE.replace("[arm]", "[goal]\nshare = 0.5\n[arm]"))
    assert made.goal == Goal(0.5)
    assert Richer.from_text(made.to_text()).goal == Goal(0.5)
    with pytest.raises(ExperimentError, match=r"\[goal\] share: 'x', expected a number"):
        Richer.from_text(FILE.replace("[arm]", "[goal]\nshare = 'x'\n[arm]"))


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
    told = [
        subprocess.run(
            command, capture_output=True, text=True, check=True, env={"PYTHONHASHSEED": s}
        )
        for s in ("1", "2")
    ]
    assert [one.stdout.strip() for one in told] == [Experiment.from_text(FILE).digest] * 2


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


class Push:
    """A law of a user's own."""

    def init(self, q, v, desired):  # noqa: ARG002
        return ()

    def step(self, state, q, v, desired, period):  # noqa: ARG002
        return {"u": np.zeros_like(q)}, state


class Peak:
    """An observer of a user's own."""

    def init(self, n):
        return np.zeros(n)

    def step(self, state, signals, period):  # noqa: ARG002
        return np.maximum(state, np.abs(signals["u"]))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"controller": Push()}, "controller of the experiment: a Push"),
        (
            {"vibration": Vibration(lambda arm, q: np.eye(2), WhiteNoise())},  # noqa: ARG005
            "vibration.input of the experiment: a InputFunction",
        ),
        ({"observer": Peak()}, "observer of the experiment: a Peak"),
    ],
)
def test_a_part_of_ones_own_cannot_be_written(tmp_path, changes, text):
    experiment = Experiment(loop(**changes), 1.0)
    told = (
        f"{text}, expected a part of ftcfa; "
        "a part of your own cannot be written: run its loop with simulate"
    )
    for write in (experiment.to_text, experiment.description, lambda: experiment.digest):
        with pytest.raises(ParameterError) as caught:
            write()
        assert str(caught.value) == told
    with pytest.raises(ParameterError):
        experiment.save(tmp_path / "e.toml")
    assert list(tmp_path.iterdir()) == []


def test_a_subclass_of_a_part_is_a_part_of_ones_own():
    class Harder(WhiteNoise):
        pass

    with pytest.raises(ParameterError, match=r"vibration\.excitation of the experiment: a Harder"):
        Experiment(loop(excitation=Harder(0.1)), 1.0).to_text()


def test_an_arm_that_was_changed_by_hand_cannot_be_written(tmp_path):
    changed = dataclasses.replace(ARM, damping=ARM.damping + 1.0)
    with pytest.raises(ParameterError, match="is no longer what double_pendulum gives"):
        Experiment(loop(changed), 1.0).description()
    file = tmp_path / "arm.urdf"
    file.write_text(URDF)
    experiment = Experiment(loop(load_arm(file)), 1.0)
    file.write_text(URDF.replace('value="0.6"', 'value="0.7"'))
    with pytest.raises(ParameterError, match="load it again if the file has changed"):
        experiment.description()


def test_an_arm_made_by_hand_cannot_be_written():
    with pytest.raises(ParameterError, match="made by hand, expected an Arm that load_arm gave"):
        Experiment(loop(dataclasses.replace(ARM, source=None)), 1.0).to_text()


def test_what_results_remember_shows_any_part():
    told = describe(loop(controller=Push()))
    assert told["controller"] == {"type": "Push"}


ROBOTS = ", ".join(catalogue())
TOP = (
    "duration, seed, paths, record_every, tolerance, after, quantiles, chunk, specification, "
    "arm, controller, reference, vibration, period, substeps, integrator, q0, v0, uncertainty"
)
INPUTS = "BaseAcceleration, BaseMotion, FrameWrench, JointTorque, PaperPendulumInput"
EXCITATIONS = (
    "WhiteNoise, ShapedNoise, RandomPhase, RecordedAcceleration, Harmonic, SineSweep, "
    "Superposition, Stacked"
)
BROKEN = {
    "unknown key at the top": (
        "seed = 5", "sede = 5",
        ["e.toml: sede: unknown key; did you mean 'seed'?"],
    ),
    "unknown table": (
        "seed = 5", "[colour]",
        [
            f"e.toml: colour: unknown key, expected one of: {TOP}",
        ],
    ),
    "unknown key in a table": (
        "amplitude = 0.2", "ampltude = 0.2",
        ["e.toml: [reference] ampltude: unknown key; did you mean 'amplitude'?"],
    ),
    "key with nothing near": (
        "amplitude = 0.2", "zoom = 0.2",
        [
            "e.toml: [reference] zoom: unknown key, expected one of: "
            "amplitude, angular_frequency, phase, offset"
        ],
    ),
    "key of the top in a table": (
        "amplitude = 0.2", "substeps = 2",
        [
            "e.toml: [reference] substeps: unknown key; "
            "it belongs at the top, before the first table"
        ],
    ),
    "text for a number": (
        "0.05", '"0.05"',
        ["e.toml: duration: '0.05', expected a number"],
    ),
    "number for an integer": (
        "seed = 5", "seed = 5.0",
        ["e.toml: seed: 5.0, expected an integer"],
    ),
    "true for a number": (
        "2e-3", "true",
        ["e.toml: period: true, expected a number"],
    ),
    "text for numbers": (
        "amplitude = 0.2", 'amplitude = "0.2"',
        ["e.toml: [reference] amplitude: '0.2', expected numbers"],
    ),
    "text among numbers": (
        "amplitude = 0.2", 'amplitude = [0.2, "0.2", 1, 1, 1, 1]',
        ["e.toml: [reference] amplitude[1]: '0.2', expected numbers"],
    ),
    "number for a table": (
        "gains = { c1 = 8 }", "gains = 8",
        ["e.toml: [controller] gains: 8, expected a table"],
    ),
    "table for a text": (
        'compensation = "bias"', "compensation = {}",
        ["e.toml: [controller] compensation: a table, expected one of: none, gravity, bias"],
    ),
    "negative duration": (
        "0.05", "-1",
        ["e.toml: duration: -1.0, expected a number >= 0 [s]"],
    ),
    "negative seed": (
        "seed = 5", "seed = -1",
        ["e.toml: seed: -1, expected an integer from 0 to 2^64 - 1"],
    ),
    "gain out of range": (
        "c1 = 8", "kappa = 2",
        ["e.toml: [controller.gains] kappa: 2.0, expected 0 < kappa <= 1"],
    ),
    "two gains out of range": (
        "c1 = 8", "c1 = 0, c2 = -1",
        [
            "e.toml: [controller.gains] c1: 0.0, expected a number > 0 [rad^(1-kappa)/s]",
            "e.toml: [controller.gains] c2: -1.0, expected a number > 0 [(rad/s)^(1-kappa)/s]",
        ],
    ),
    "tolerance out of range": (
        "tolerance = 0.04", "tolerance = 0",
        ["e.toml: tolerance: 0.0, expected a number > 0 [rad or m]"],
    ),
    "quantile out of range": (
        "[0.1, 0.5]", "[0.1, 50]",
        [
            "e.toml: quantiles: 50.0, expected a number between 0 and 1; "
            "give 0.5 for 50 percent"
        ],
    ),
    "no quantiles": (
        "[0.1, 0.5]", "[]",
        ["e.toml: quantiles: none, expected one or more numbers"],
    ),
    "quantile that is no number": (
        "[0.1, 0.5]", "[0.1, 'median']",
        ["e.toml: quantiles[1]: 'median', expected a number"],
    ),
    "empty chunks": (
        "chunk = 8", "chunk = 0",
        ["e.toml: chunk: 0, expected an integer >= 1"],
    ),
    "time before the start": (
        "after = 0.01", "after = -1",
        ["e.toml: after: -1.0, expected a number >= 0 [s]"],
    ),
    "unknown key of the specification": (
        "share = 0.9", "shares = 0.9",
        ["e.toml: [specification] shares: unknown key; did you mean 'share'?"],
    ),
    "key missing in the specification": (
        "error = 0.3\n", "",
        ["e.toml: [specification] error: missing, expected a number"],
    ),
    "share in percent and no budget": (
        "share = 0.9", "share = 90\nbudget = 0",
        [
            "e.toml: [specification] share: 90.0, expected a number between 0 and 1; "
            "give 0.9 for 90 percent",
            "e.toml: [specification] budget: 0, expected an integer >= 1",
        ],
    ),
    "longer to settle than the run": (
        "within = 0.02", "within = 2",
        [
            "e.toml: [specification]: Specification within: 2 s, "
            "expected less than the duration of 0.05 s"
        ],
    ),
    "effort of another arm": (
        "effort = [150, 150, 150, 28, 28, 28]", "effort = [1, 2]",
        [
            "e.toml: [specification]: Specification effort: shape (2,), "
            "expected a number or shape (6,)"
        ],
    ),
    "unknown word": (
        '"bias"', '"bais"',
        [
            "e.toml: [controller] compensation: 'bais', expected one of: none, gravity, bias; "
            "did you mean 'bias'?"
        ],
    ),
    "unknown integrator": (
        "seed = 5", 'integrator = "euler"',
        [
            "e.toml: integrator: 'euler', expected one of: euler-maruyama, semi-implicit"
        ],
    ),
    "unknown type": (
        '"WhiteNoise"', '"WhitNoise"',
        [
            f"e.toml: [vibration.excitation] type: 'WhitNoise', expected one of: {EXCITATIONS}; "
            "did you mean 'WhiteNoise'?"
        ],
    ),
    "type of another place": (
        '"BaseAcceleration"', '"WhiteNoise"',
        [f"e.toml: [vibration.input] type: 'WhiteNoise', expected one of: {INPUTS}"],
    ),
    "type missing": (
        'type = "BaseAcceleration", ', "",
        [f"e.toml: [vibration.input] type: missing, expected one of: {INPUTS}"],
    ),
    "type that is no text": (
        '"BaseAcceleration"', "1",
        [f"e.toml: [vibration.input] type: 1, expected one of: {INPUTS}"],
    ),
    "unknown robot": (
        'robot = "ur5"\n', 'robot = "ur55"\n',
        [f"e.toml: [arm] robot: 'ur55', expected one of: {ROBOTS}; did you mean 'ur5'?"],
    ),
    "missing file": (
        'robot = "ur5"\n', 'robot = "arms/mine.urdf"\n',
        [
            "e.toml: [arm] robot: {folder}/arms/mine.urdf: no such file or directory, expected a "
            "readable URDF file; check the path and its permissions"
        ],
    ),
    "missing key": (
        'robot = "ur5"\n', "",
        ["e.toml: [arm] robot: missing, expected a text"],
    ),
    "missing table": (
        '[arm]\nrobot = "ur5"\n', "",
        ["e.toml: [arm]: missing, expected a table"],
    ),
    "unknown joint": (
        'robot = "ur5"\n', 'robot = "ur5"\neffort_limit = { elbow = 3 }\n',
        [
            "e.toml: [arm.effort_limit]: effort_limit of joint 'elbow': unknown name, expected one "
            "of: shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, "
            "wrist_2_joint, wrist_3_joint"
        ],
    ),
    "too many numbers": (
        "amplitude = 0.2", "amplitude = [1, 2]",
        ["e.toml: [reference] amplitude: [1.0, 2.0], expected 1 or 6 finite numbers"],
    ),
    "reference of another arm": (
        'offset = "home"', "offset = [0, 0]",
        [
            "e.toml: [reference]: 2 joints, expected 6: shoulder_pan_joint, shoulder_lift_joint, "
            "elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint"
        ],
    ),
    "parts that do not go together": (
        "intensity = 0.2", "intensity = [1, 2, 3]",
        [
            "e.toml: [vibration]: WhiteNoise intensity: 3 channels, expected 2 channels; "
            "one for each channel of the noise input, or choose fewer of its axes"
        ],
    ),
    "step too long for a spectrum": (
        'type = "WhiteNoise", intensity = 0.2',
        'type = "ShapedNoise", axes = [{ type = "Spectrum", frequencies = [1, 100], '
        "g2_per_hz = [0.1, 0.1] }, { type = \"Road\", road_class = \"A\", speed = 9 }]",
        [
            "e.toml: [vibration]: integration step: 2 ms, for a spectrum up to 100 Hz, expected at "
            "most 1.25 ms (8 steps in the shortest period); take substeps=2 of the period 2 ms, or "
            "a shorter period"
        ],
    ),
    "fault in a list": (
        'type = "WhiteNoise", intensity = 0.2',
        'type = "ShapedNoise", axes = [{ type = "Road", road_class = "G", speed = 9 }]',
        [
            "e.toml: [vibration.excitation.axes[0]] road_class: 'G', "
            "expected one of: A, B, C, D, E, F"
        ],
    ),
    "required values out of range among others": (
        FILE,
        """
duration = -1
paths = 0
seed = -1
tolerance = -0.5
quantiles = [0.5, 2.0]
[arm]
robot = "double_pendulum"
[controller]
type = "FTCF"
[reference]
type = "Constant"
q = "hom"
[vibration]
input = { type = "BaseAcceleration", axes = "x" }
excitation = { type = "SineSweep", amplitude = 0.1, start = -5, stop = -5, duration = 0 }
[specification]
error = -1
within = 0
share = 2
""",
        [
            "e.toml: [reference] q: 'hom', expected numbers or \"home\"",
            "e.toml: [vibration.excitation] start: -5.0, expected a number > 0 [Hz]",
            "e.toml: [vibration.excitation] stop: -5.0, expected a number > 0 [Hz]",
            "e.toml: [vibration.excitation] duration: 0.0, expected a number > 0 [s]",
            "e.toml: [specification] error: -1.0, expected a number > 0 [rad or m]",
            "e.toml: [specification] within: 0.0, expected a number > 0 [s]",
            "e.toml: [specification] share: 2.0, expected a number between 0 and 1; "
            "give 0.02 for 2 percent",
            "e.toml: duration: -1.0, expected a number >= 0 [s]",
            "e.toml: paths: 0, expected an integer >= 1",
            "e.toml: seed: -1, expected an integer from 0 to 2^64 - 1",
            "e.toml: tolerance: -0.5, expected a number > 0 [rad or m]",
            "e.toml: quantiles: 2.0, expected a number between 0 and 1; give 0.02 for 2 percent",
        ],
    ),
    "what stands in for a number is not to blame": (
        'type = "WhiteNoise", intensity = 0.2',
        'type = "SineSweep", amplitude = 0.1, start = -5, stop = 0.001, duration = 1',
        ["e.toml: [vibration.excitation] start: -5.0, expected a number > 0 [Hz]"],
    ),
    "what stands in for an arm is not to blame": (
        FILE,
        """
duration = 1.0
[arm]
robot = "ur55"
[controller]
type = "SlotineLi"
leakage = -1
[reference]
type = "Constant"
q = "home"
""",
        [
            f"e.toml: [arm] robot: 'ur55', expected one of: {ROBOTS}; did you mean 'ur5'?",
            "e.toml: [controller] leakage: -1.0, expected a number > 0 [1/s]",
        ],
    ),
    "several": (
        FILE,
        """
duration = "long"
period = -1
[arm]
robot = "ur55"
gravty = 9.7
[controller]
type = "FTCF"
gains = { c1 = -1, kappa = true }
[reference]
type = "Sinusoid"
offset = "home"
phase = {}
[vibration]
level = -1
input = { type = "BaseAcceleration", axes = "w" }
excitation = { type = "WhiteNoise", intensity = -1, convention = "dB" }
""",
        [
            "e.toml: [arm] gravty: unknown key; did you mean 'gravity'?",
            f"e.toml: [arm] robot: 'ur55', expected one of: {ROBOTS}; did you mean 'ur5'?",
            "e.toml: [controller.gains] kappa: true, expected a number",
            "e.toml: [controller.gains] c1: -1.0, expected a number > 0 [rad^(1-kappa)/s]",
            "e.toml: [reference] phase: a table, expected numbers",
            "e.toml: [vibration.input] axes: 'w', expected such as \"xyz\" or \"xz\"",
            "e.toml: [vibration.excitation] intensity: -1.0, "
            "expected a positive semidefinite varpi",
            "e.toml: [vibration.excitation] convention: 'dB', expected one of: psd, amplitude",
            "e.toml: [vibration] level: -1.0, expected a number >= 0",
            "e.toml: period: -1.0, expected a number > 0 [s]",
            "e.toml: duration: 'long', expected a number",
        ],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_gives_all_its_errors(name, tmp_path, monkeypatch):
    old, new, told = BROKEN[name]
    assert old in FILE
    monkeypatch.chdir(tmp_path)
    Path("e.toml").write_text(FILE.replace(old, new, 1))
    with pytest.raises(ExperimentError) as caught:
        load_experiment("e.toml")
    assert sorted(map(str, caught.value.errors)) == sorted(
        line.replace("{folder}/", "") for line in told
    )
    assert str(caught.value) == "\n".join(map(str, caught.value.errors))


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a = [1,\n\nb", "e.toml: not TOML: Invalid value (at line 3, column 1)"),
        (b"a = 1\na = 2\n", "e.toml: not TOML: Cannot overwrite a value (at line 2, column 6)"),
        (b"\xff\xfe", "e.toml: not UTF-8 (invalid start byte), expected a TOML file"),
        (None, "e.toml: no such file or directory, expected a readable TOML file"),
    ],
)
def test_a_file_that_is_no_toml(content, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path("e.toml").write_bytes(content)
    with pytest.raises(ExperimentError) as caught:
        load_experiment("e.toml")
    assert str(caught.value) == told


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{", "description: not JSON: Expecting property name enclosed in double quotes: "
              "line 1 column 2 (char 1)"),
        ("[]", "description: a list, expected a JSON object"),
        ('{"seed": null}', "description: seed: None, expected an integer"),
    ],
)  # fmt: skip
def test_a_description_that_is_none(text, told):
    with pytest.raises(ExperimentError) as caught:
        Experiment.from_description(text)
    assert told in str(caught.value).splitlines()


@pytest.mark.parametrize(
    ("values", "told"),
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
def test_an_experiment_checks_its_numbers(values, told):
    with pytest.raises(ParameterError) as caught:
        Experiment(*values)
    assert str(caught.value) == told
