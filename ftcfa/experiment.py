"""Experiments as files: a TOML document that maps onto the same dataclasses as the Python API.

    duration = 10.0
    seed = 0
    period = 1e-3

    [arm]                           # the keywords of load_arm
    robot = "panda"                 # or the path of a URDF, counted from this file

    [controller]                    # a part says its type, and its fields
    type = "FTCF"
    compensation = "bias"
    gains = { c1 = 7.5 }

    [reference]
    type = "Sinusoid"
    offset = "home"                 # the arm's home posture

    [vibration]
    input = { type = "BaseAcceleration", axes = "xyz" }
    excitation = { type = "WhiteNoise", intensity = 0.1 }

At the top stand the numbers of the run and of the `ClosedLoop`, then a table for each of its
parts. What is left out has the default of the Python API; a controller's nominal arm is the true
one unless ``[controller.nominal]`` says otherwise.
"""

import hashlib
import json
import os
import re
import tomllib
from dataclasses import dataclass, fields
from numbers import Real
from pathlib import Path
from typing import Any, Self

import numpy as np
import tomli_w

from ftcfa.arrays import counting
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.describe import arms, describe, document, has_path, self_contained
from ftcfa.loop.faults import ExperimentError
from ftcfa.loop.rebuild import rebuild
from ftcfa.report.files import write_whole
from ftcfa.streams import natural

_NUMBERS = re.compile(r"\[\n([^\[\]\"{}]*)\]")
"""An array of plain numbers as tomli-w writes it, one a line; texts hold no bare line break."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """A closed loop and how it is run: what a file says and another machine needs to know.

    Attributes:
        loop: What is simulated.
        duration: Simulated time [s].
        seed: Of the random streams, 0 <= seed < 2^64.
        paths: How many.
        record_every: Keep every so many samples.
    """

    loop: ClosedLoop
    duration: float
    seed: int = 0
    paths: int = 1
    record_every: int = 1

    def __post_init__(self) -> None:
        if not isinstance(self.loop, ClosedLoop):
            raise ParameterError("Experiment loop", f"a {type(self.loop).__name__}", "a ClosedLoop")
        number = isinstance(self.duration, Real) and not isinstance(self.duration, bool)
        if not (number and 0 <= self.duration < np.inf):
            raise ParameterError("Experiment duration", repr(self.duration), "a number >= 0 [s]")
        natural("Experiment seed", self.seed)
        counting("Experiment paths", self.paths)
        counting("Experiment record_every", self.record_every)

    @classmethod
    def from_text(
        cls, text: str, folder: str | os.PathLike[str] = ".", *, file: str = "experiment"
    ) -> Self:
        """The experiment that a TOML text describes.

        Args:
            text: The text.
            folder: Where its relative paths count from.
            file: What messages call it.

        Raises:
            ExperimentError: If anything is wrong with it; it holds all errors.
        """
        try:
            told = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise _unreadable(file, f"not TOML: {error}") from error
        return rebuild(cls, told, file, Path(folder))

    @classmethod
    def from_description(cls, text: str) -> Self:
        """The experiment that another machine described by `description`.

        Raises:
            ExperimentError: If the text is no such description.
        """
        try:
            told = json.loads(text)
        except json.JSONDecodeError as error:
            raise _unreadable("description", f"not JSON: {error}") from error
        if not isinstance(told, dict):
            raise _unreadable("description", f"a {type(told).__name__}", "a JSON object")
        return rebuild(cls, told, "description", Path())

    def description(self) -> str:
        """A JSON text that says everything, without any file of this machine.

        Arms that we know by name go by it; other URDFs, records and tables go with their contents.

        Raises:
            ParameterError: If the loop holds a part of a user's own, which no text can tell.
        """
        return json.dumps(self_contained(self._document()))

    @property
    def digest(self) -> str:
        """SHA-256 of the description: the same for the same experiment, wherever it came from."""
        told = _canonical(json.loads(self.description()))
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()

    def to_text(self, folder: str | os.PathLike[str] | None = None) -> str:
        """The TOML text that `from_text` reads; paths below the folder count from there.

        Raises:
            ParameterError: If the loop holds a part of a user's own.
        """
        told = self._document()
        for arm in filter(has_path, arms(told)):
            path = Path(arm["robot"])
            if folder is not None and path.is_relative_to(Path(folder).resolve()):
                arm["robot"] = path.relative_to(Path(folder).resolve()).as_posix()
        return _NUMBERS.sub(_on_one_line, tomli_w.dumps(told))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the TOML file, whole or not at all.

        Raises:
            ParameterError: If the loop holds a part of a user's own.
            FtcfaError: If the file cannot be written.
        """
        file = Path(path)
        write_whole(file, self.to_text(file.parent).encode())

    def _document(self) -> dict[str, Any]:
        own = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "loop"}
        told = {name: describe(value) for name, value in own.items() if value is not None}
        return {**told, **document(self.loop)}


def load_experiment(path: str | os.PathLike[str]) -> Experiment:
    """Read an experiment from its TOML file.

    Raises:
        ExperimentError: If anything is wrong with it; it holds all errors, each with file, table
            and key.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise _unreadable(str(file), reason, "a readable TOML file") from error
    except UnicodeDecodeError as error:
        raise _unreadable(str(file), f"not UTF-8 ({error.reason})", "a TOML file") from error
    return Experiment.from_text(text, file.parent, file=str(file))


def _on_one_line(array: re.Match[str]) -> str:
    return f"[{' '.join(array[1].split()).rstrip(',')}]"


def _unreadable(file: str, got: str, expected: str = "") -> ExperimentError:
    return ExperimentError([FtcfaError(file, got, expected)])


def _canonical(told: Any) -> Any:
    """Data in which 1 and 1.0 are the same."""
    if isinstance(told, dict):
        return {key: _canonical(value) for key, value in told.items()}
    if isinstance(told, list):
        return [_canonical(item) for item in told]
    integer = isinstance(told, int) and not isinstance(told, bool)
    return float(told) if integer and abs(told) <= 2**53 else told
