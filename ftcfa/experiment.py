"""Experiments as files: a TOML document that maps onto the same dataclasses as the Python API.

    duration = 10.0
    seed = 0
    paths = 10000
    tolerance = 0.05                # error of a path that has settled [rad or m]
    period = 1e-3

    [arm]                           # the keywords of load_arm
    robot = "panda"                 # or the path of a URDF, counted from this file

    [controller]                    # a part: its type and its fields
    type = "FTCF"
    compensation = "bias"
    gains = { c1 = 7.5 }

    [reference]
    type = "Sinusoid"
    offset = "home"                 # the arm's home posture

    [vibration]
    input = { type = "BaseAcceleration", axes = "xyz" }
    excitation = { type = "WhiteNoise", intensity = 0.1 }

    [specification]                 # what `ftcfa verify` tests
    error = 0.02
    within = 2.0

    [objective]                     # what `ftcfa tune` makes small
    terms = [{ metric = "late_rms_error", statistic = "q95" }]
    limits = [{ metric = "rms_torque_rate", at_most = 1000.0 }]

    [space]                         # what it may change; without it all that the law declares
    "controller.gains.c1" = [1.0, 100.0]

The numbers of the run and of the `ClosedLoop` stand at the top, then a table for each of its parts.
A key that is left out has the default of the Python API. A controller's nominal arm is the true one
unless there is a table ``[controller.nominal]``.
"""

import json
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import numpy.typing as npt
import xarray as xr

from ftcfa.checks import (
    Check,
    about,
    counting,
    natural,
    not_negative,
    of_type,
    positive,
    positive_numbers,
    probability,
)
from ftcfa.description.read import rebuild
from ftcfa.description.text import digest, toml_text
from ftcfa.description.write import document
from ftcfa.errors import ExperimentError, FtcfaError, ParameterError
from ftcfa.files import MAX_TOML, local_path, read_bounded, write_whole
from ftcfa.hardware.hardware import Hardware
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.parts import Part
from ftcfa.study.ensemble import ensemble
from ftcfa.study.summary import QUANTILES
from ftcfa.study.tuning.objective import Objective
from ftcfa.study.tuning.result import Tuning
from ftcfa.study.tuning.space import check_ranges
from ftcfa.study.tuning.tune import tune
from ftcfa.study.verification import Specification, Verification, verify


def check_quantiles(subject: str, quantiles: tuple[float, ...]) -> None:
    """Raise ParameterError unless quantiles are one or more probabilities."""
    if not isinstance(quantiles, Sequence) or not quantiles:
        got = "none" if quantiles == () else repr(quantiles)
        raise ParameterError(subject, got, "one or more numbers")
    for p in quantiles:
        probability(subject, p)


@dataclass(frozen=True, eq=False)
class Experiment(Part):
    """A closed loop and how it is run: the contents of an experiment file.

    Attributes:
        loop: Closed loop that is simulated.
        duration: Simulated time [s].
        seed: Seed of the random streams, 0 <= seed < 2^64.
        paths: Number of paths.
        record_every: Number of samples between two times at which statistics are kept; 0 gives
            about 200 times.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        after: Time from which errors count as late [s]; half of the duration by default.
        quantiles: Probabilities of the quantiles over time.
        chunk: Number of paths that are computed and stored at once.
        specification: Specification that `verify` tests, or None.
        lost: Error beyond which a joint has lost track, one number or one for each joint [rad or
            m]; see `ftcfa.ensemble`.
        objective: What `tune` makes small and must not exceed, or None for its default.
        space: Parameters that `tune` may change, and their ranges, or None for all.

    Raises:
        FtcfaError: If a field is out of range; it carries the field's name.
    """

    loop: Annotated[ClosedLoop, Check(of_type(ClosedLoop, "a ClosedLoop"))]
    duration: Annotated[float, Check(not_negative, "s")]
    seed: Annotated[int, Check(natural)] = 0
    paths: Annotated[int, Check(counting)] = 1
    record_every: Annotated[int, Check(natural)] = 0
    tolerance: Annotated[float, Check(positive, "rad or m")] = 0.05
    after: Annotated[float | None, Check(not_negative, "s")] = None
    quantiles: Annotated[tuple[float, ...], Check(check_quantiles)] = QUANTILES
    chunk: Annotated[int, Check(counting)] = 4096
    specification: Annotated[
        Specification | None, Check(of_type(Specification, "a Specification, or None"))
    ] = None
    lost: Annotated[npt.ArrayLike | None, Check(positive_numbers, "rad or m")] = None
    objective: Annotated[Objective | None, Check(of_type(Objective, "an Objective, or None"))] = (
        None
    )
    space: Mapping[str, tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.specification is not None:
            with about("specification"):
                self.specification.check(self.loop, self.duration)
        if self.space is not None:
            with about("space"):
                check_ranges(self.loop, self.space)

    def run(self, **options: Any) -> xr.Dataset:
        """Run the ensemble: `ftcfa.ensemble` with the fields of this experiment.

        Args:
            options: Further arguments of `ftcfa.ensemble`: ``threads``, ``store``, ``client``,
                ``progress``, ``trajectories`` and ``confidence``.
        """
        return ensemble(
            self.loop,
            self.paths,
            self.duration,
            seed=self.seed,
            record_every=self.record_every,
            tolerance=self.tolerance,
            after=self.after,
            lost=self.lost,
            quantiles=self.quantiles,
            chunk=self.chunk,
            **options,
        )

    def verify(self, **options: Any) -> Verification:
        """Test whether the specification is met: `ftcfa.verify` with this experiment's fields.

        Args:
            options: Further arguments of `ftcfa.verify`: ``threads`` and ``progress``.

        Raises:
            ParameterError: If there is no specification.
        """
        if self.specification is None:
            raise ParameterError(
                "Experiment specification",
                "missing",
                "a Specification",
                "in a file: a table [specification] with error and within",
            )
        return verify(self.loop, self.specification, self.duration, seed=self.seed, **options)

    def tune(self, **options: Any) -> Tuning:
        """Search gains: `ftcfa.tune` with the fields of this experiment.

        Args:
            options: Further arguments of `ftcfa.tune`, such as ``generations`` and ``store``.
        """
        return tune(
            self.loop,
            self.duration,
            self.objective,
            self.space,
            seed=self.seed,
            tolerance=self.tolerance,
            after=self.after,
            lost=self.lost,
            **options,
        )

    @classmethod
    def from_text(
        cls, text: str, folder: str | os.PathLike[str] = ".", *, file: str = "experiment"
    ) -> Self:
        """The experiment that a TOML text describes.

        Args:
            text: The text.
            folder: Folder from which its relative paths count.
            file: How messages name the text.

        Raises:
            ExperimentError: If anything is wrong with it; it holds all errors.
        """
        try:
            data = tomllib.loads(text)
        except (ValueError, RecursionError) as error:  # TOML, numbers of 5,000 digits, nesting
            raise _unreadable(file, f"not TOML: {error}") from error
        return rebuild(cls, data, file, Path(folder))

    @classmethod
    def from_description(cls, text: str) -> Self:
        """The experiment of a `description`, perhaps one from another machine.

        Raises:
            ExperimentError: If the text is not a description; it holds all errors.
        """
        try:
            data = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise _unreadable("description", f"not JSON: {error}") from error
        if not isinstance(data, dict):
            raise _unreadable("description", f"a {type(data).__name__}", "a JSON object")
        return rebuild(cls, data, "description", Path())

    def description(self) -> str:
        """A JSON text of the whole experiment that needs no file of this machine.

        An arm of the catalogue is given by its name; other URDFs, records and tables are written
        out.

        Raises:
            ParameterError: If the loop holds a part of a user's own, which cannot be written.
        """
        return json.dumps(document(self))

    @property
    def digest(self) -> str:
        """SHA-256 of the description: equal for equal experiments, from Python or any file."""
        return digest(json.loads(self.description()))

    def to_text(self, folder: str | os.PathLike[str] | None = None) -> str:
        """The TOML text that `from_text` reads; paths below the folder are relative to it.

        Raises:
            ParameterError: If the loop holds a part of a user's own.
        """
        base = None if folder is None else Path(folder).resolve()

        def robot(path: Path) -> dict[str, str]:
            if base is not None and path.is_relative_to(base):
                path = path.relative_to(base)
            return {"robot": path.as_posix()}

        return toml_text(document(self, robot))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the TOML file, whole or not at all.

        Raises:
            ParameterError: If the loop holds a part of a user's own.
            FtcfaError: If the file cannot be written.
        """
        file = local_path(path)
        write_whole(file, self.to_text(file.parent).encode())


def load_experiment(
    path: str | os.PathLike[str], *, hardware: Hardware | str | None = None
) -> Experiment:
    """Read an experiment from its TOML file.

    Args:
        path: The file.
        hardware: Hardware that replaces that of the file, or the name of a profile.

    Raises:
        ExperimentError: If anything is wrong with it; it holds all errors, each with file, table
            and key.
    """
    file = local_path(path)
    try:
        text = read_bounded(file, MAX_TOML).decode("utf-8-sig")
    except FtcfaError as error:
        raise _unreadable(str(file), error.got, "a readable TOML file") from error
    except UnicodeDecodeError as error:
        raise _unreadable(str(file), f"not UTF-8 ({error.reason})", "a TOML file") from error
    read = Experiment.from_text(text, file.parent, file=str(file))
    return read if hardware is None else replace(read, loop=replace(read.loop, hardware=hardware))


def _unreadable(file: str, got: str, expected: str = "") -> ExperimentError:
    return ExperimentError([FtcfaError(file, got, expected)])
