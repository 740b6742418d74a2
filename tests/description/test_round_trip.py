"""Loops written as files, descriptions and attributes of results give the same bits again."""

import dataclasses
import json
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest

import ftcfa
from ftcfa import (
    FTCF,
    ClosedLoop,
    Experiment,
    ExperimentError,
    PaperPendulum,
    ParameterError,
    PDGravity,
    Record,
    RecordedAcceleration,
    SlotineLi,
    Vibration,
    WhiteNoise,
    compare,
    ensemble,
    load_arm,
    load_experiment,
    simulate,
    simulate_paths,
)
from ftcfa.description.hints import choices, element
from ftcfa.description.read import rebuild
from ftcfa.description.registry import PARTS
from ftcfa.description.write import LARGE, document, provenance

from .loops import ARM, DURATION, LOOPS, THIRD, URDF, loop, same_bits


@pytest.fixture(scope="module", params=LOOPS)
def written(request):
    """An experiment that Python built, and what came of it."""
    experiment = Experiment(LOOPS[request.param](), DURATION, seed=3)
    return experiment, simulate(experiment.loop, experiment.duration, seed=experiment.seed)


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
    classes, waiting = set(), [cls]
    while waiting:
        part = waiting.pop()
        if part not in classes:
            classes.add(part)
            hints = [] if part is ftcfa.Arm else [*get_type_hints(part).values()]
            waiting.extend(one for hint in hints for one in choices(hint))
            waiting.extend(one for hint in hints for one in choices(element(hint)))
    return classes


def test_every_kind_of_part_is_among_the_loops():
    used = set().union(*(types_in(make()) for make in LOOPS.values()))
    assert used == reachable(ClosedLoop)
    assert used >= {part for parts in PARTS.values() for part in parts}


def test_every_public_part_can_be_written():
    results = {
        "Bounds",
        "FeedForwardBand",
        "FilterFit",
        "InertiaBounds",
        "InertiaSplit",
        "Profile",
        "RealisedStandard",
        "SpectrumEstimate",
        "Tuning",
        "Verification",
    }
    public = {name: getattr(ftcfa, name) for name in ftcfa.__all__}
    parts = {
        n: it for n, it in public.items() if isinstance(it, type) and dataclasses.is_dataclass(it)
    }
    assert {name for name, it in parts.items() if it not in reachable(Experiment)} <= results


def test_a_nominal_arm_that_is_the_true_one_is_written_once():
    for law in (FTCF, SlotineLi):
        assert "nominal" not in Experiment(loop(controller=law(ARM)), 1.0).to_text()
    assert (
        "nominal" not in Experiment(loop(controller=FTCF(load_arm("double_pendulum"))), 1).to_text()
    )
    assert "[controller.nominal]" in Experiment(loop(controller=FTCF(PaperPendulum())), 1).to_text()
    again = Experiment.from_text(Experiment(loop(), 1.0).to_text()).loop
    assert again.controller.nominal is again.arm


def test_a_loop_alone_travels_too():
    data = json.loads(json.dumps(document(loop(excitation=WhiteNoise(THIRD)))))
    again = rebuild(ClosedLoop, data, "loop", Path())
    assert same_bits(
        Experiment(again, DURATION), simulate(loop(excitation=WhiteNoise(THIRD)), DURATION)
    )


LONG = np.zeros((LARGE // 2 + 1, 2))
"""Values of a record that is too long to be remembered."""
SHORT = 10_000
"""Characters of a description without large arrays."""


class Push:
    """A law of a user's own."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
        return {"u": np.zeros_like(q)}, state


class Peak:
    """An observer of a user's own."""

    def init(self, n):
        return np.zeros(n)

    def step(self, state, signals, period):
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
    message = (
        f"{text}, expected a part of ftcfa; "
        "a part of your own cannot be written: run its loop with simulate"
    )
    for write in (experiment.to_text, experiment.description, lambda: experiment.digest):
        with pytest.raises(ParameterError) as caught:
            write()
        assert str(caught.value) == message
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


def remembered(dataset):
    return rebuild(ClosedLoop, json.loads(dataset.attrs["experiment"]), "attributes", Path())


def test_the_attributes_of_a_path_rebuild_its_loop(written):
    experiment, path = written
    again = remembered(path)
    assert same_bits(Experiment(again, path.duration, seed=path.seed), path)
    assert provenance(again) == provenance(experiment.loop)


@pytest.mark.parametrize(
    "run",
    [
        lambda loop: simulate_paths(loop, 2, DURATION, threads=1),
        lambda loop: simulate_paths(loop, 2, DURATION, vary={"controller.gains.c1": [1.0, 2.0]}),
        lambda loop: ensemble(loop, 2, DURATION, threads=1),
    ],
)
def test_the_attributes_of_many_paths_rebuild_their_loop(run):
    shaken = loop(excitation=WhiteNoise(THIRD))
    assert provenance(remembered(run(shaken))) == provenance(shaken)


def test_a_comparison_rebuilds_its_loops():
    loops = {"FTCF": loop(), "PD": loop(controller=PDGravity(ARM))}
    dataset = compare(loops, 2, DURATION, threads=1)
    for name, one in loops.items():
        data = json.loads(str(dataset["experiment"].sel(loop=name).values))
        assert provenance(rebuild(ClosedLoop, data, "attributes", Path())) == provenance(one)


def test_results_need_no_file_of_this_machine(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF)
    path = simulate(loop(load_arm(file)), DURATION)
    file.unlink()
    assert same_bits(Experiment(remembered(path), DURATION), path)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: loop(controller=Push()), "controller of the experiment: a Push, expected a part"),
        (lambda: loop(dataclasses.replace(ARM, damping=ARM.damping + 1.0)), "no longer what"),
        (
            lambda: loop(excitation=RecordedAcceleration(Record(1e-3, LONG))),
            "digest: keep the loop",
        ),
    ],
)
def test_results_say_why_a_loop_cannot_be_rebuilt(make, reason):
    data = provenance(make())
    assert reason in data["not_rebuildable"]
    assert len(json.dumps(data)) < SHORT
    with pytest.raises(ExperimentError, match=f"attributes: no whole loop; .*{reason}"):
        rebuild(ClosedLoop, data, "attributes", Path())


def test_results_show_the_parts_of_a_user():
    data = provenance(loop(controller=Push()))
    assert data["controller"] == {"type": "Push"}
    assert data["reference"]["type"] == "Sinusoid"


def test_a_long_record_is_remembered_by_its_digest():
    data = provenance(loop(excitation=RecordedAcceleration(Record(1e-3, LONG))))
    values = data["vibration"]["excitation"]["record"]["values"]
    assert (values["type"], values["shape"], len(values["sha256"])) == ("array", [*LONG.shape], 64)
