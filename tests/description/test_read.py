"""Files that are broken give all their faults; what a new part needs to be read."""

import dataclasses
import tomllib
from collections.abc import Mapping
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest

from ftcfa import Experiment, ExperimentError, load_arm, load_experiment

from .loops import FILE

BROKEN = tomllib.loads(Path(__file__).with_name("broken.toml").read_text())


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_gives_all_its_faults(name, tmp_path, monkeypatch):
    case = BROKEN[name]
    old, new = case.get("change", (FILE, case.get("file")))
    assert old in FILE
    monkeypatch.chdir(tmp_path)
    Path("e.toml").write_text(FILE.replace(old, new, 1))
    with pytest.raises(ExperimentError) as caught:
        load_experiment("e.toml")
    errors = {error.subject: error for error in caught.value.errors}
    assert len(errors) == len(caught.value.errors)
    assert errors.keys() == {f"e.toml: {key}" for key, *_ in case["faults"]}
    for key, *fragments in case["faults"]:
        error = errors[f"e.toml: {key}"]
        texts = (error.got, error.expected, error.remedy)
        for text, fragment in zip_longest(texts, fragments, fillvalue=""):
            assert fragment in text
            assert bool(fragment) == bool(text)
    assert str(caught.value) == "\n".join(map(str, caught.value.errors))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"a = [1,\n\nb", "e.toml: not TOML: Invalid value (at line 3, column 1)"),
        (b"a = 1\na = 2\n", "e.toml: not TOML: Cannot overwrite a value (at line 2, column 6)"),
        (b"\xff\xfe", "e.toml: not UTF-8 (invalid start byte), expected a TOML file"),
        (None, "e.toml: no such file or directory, expected a readable TOML file"),
    ],
)
def test_a_file_that_is_no_toml(content, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path("e.toml").write_bytes(content)
    with pytest.raises(ExperimentError) as caught:
        load_experiment("e.toml")
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "description: not JSON: Expecting property name enclosed in double quotes: "
              "line 1 column 2 (char 1)"),
        ("[]", "description: a list, expected a JSON object"),
        ('{"seed": null}', "description: seed: None, expected an integer"),
    ],
)  # fmt: skip
def test_a_description_that_is_none(text, message):
    with pytest.raises(ExperimentError) as caught:
        Experiment.from_description(text)
    assert message in str(caught.value).splitlines()


def test_home_is_the_posture_of_the_arm_wherever_postures_are_expected():
    text = FILE.replace('type = "Sinusoid"\namplitude = 0.2\noffset = "home"', """
type = "MinimumJerk"
times = [0.0, 1.0]
points = ["home", [0, 1, 2, 3, 4, 5]]""").replace("seed", 'q0 = "home"\nseed')  # fmt: skip
    experiment = Experiment.from_text(text)
    home = load_arm("ur5").home
    assert np.array_equal(experiment.loop.q0, home)
    assert np.array_equal(experiment.loop.reference.points, [home, [0, 1, 2, 3, 4, 5]])


@dataclasses.dataclass(frozen=True)
class Goal:
    """Settings that a later version might add."""

    share: float = 0.9
    limits: Mapping[str, float] = dataclasses.field(default_factory=dict)
    names: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True, eq=False)
class Richer(Experiment):
    """An experiment with one more table."""

    goal: Goal | None = None


def test_a_new_field_needs_no_more_than_its_type():
    made = Richer.from_text(
        FILE.replace("[arm]", "[goal]\nshare = 0.5\nlimits = { a = 1 }\nnames = ['b']\n[arm]")
    )
    assert made.goal == Goal(0.5, {"a": 1.0}, ("b",))
    assert Richer.from_text(made.to_text()).goal == made.goal
    with pytest.raises(ExperimentError, match=r"\[goal\] share: 'x', expected a number"):
        Richer.from_text(FILE.replace("[arm]", "[goal]\nshare = 'x'\n[arm]"))
