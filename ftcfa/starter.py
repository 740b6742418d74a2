"""`starter`: an experiment for any arm that runs as it is, to be read and changed.

The arm follows a sinusoid about home that stays within 60 % of the way to its limits of position
and half of its limits of velocity, under the paper's law with its bias compensated and the gains of
`ftcfa.suggest_gains`. The integration steps are as many as the excitation needs.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import known_name
from ftcfa.description.commented import commented
from ftcfa.description.read import rebuild
from ftcfa.errors import ExperimentError, ParameterError
from ftcfa.experiment import Experiment
from ftcfa.hardware.profiles import hardware_profile
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.suggested_gains import suggest_gains
from ftcfa.model.arm import Arm
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.model.urdf.load import load_arm
from ftcfa.parts import fields_of
from ftcfa.study.verification import Specification
from ftcfa.vibration.records.record import read_record
from ftcfa.vibration.spectra.standards import read_table, standards
from ftcfa.vibration.vibration import Vibration

AMPLITUDE, SWEEP = 0.3, 0.1
"""Largest amplitude of a revolute joint [rad] and of a prismatic one [m]."""
WAY, SPEED = 0.6, 0.5
"""Largest share of the way to a limit of position, and of a limit of velocity."""
SUBSTEPS = (1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100)
"""Integration steps of a period that are tried."""
DIGITS = 3
AXES = {1: "z", 3: "xyz"}
"""Axes of the base by the number of channels."""
DURATION, PATHS, ERROR, TOOL_ERROR, WITHIN = 10.0, 100, 0.05, 0.01, 3.0


@dataclass(frozen=True)
class Shaking:
    """What shakes the base: at most one of these.

    Attributes:
        vibration: Names of standards, one (up and down) or three (world axes x, y, z).
        table: File with one or three tables of one's own.
        record: File of a record with one or three axes.
        road: Class of a road, "A" to "F".
        speed: Speed on the road [m/s].
    """

    vibration: tuple[str, ...] = ()
    table: Path | None = None
    record: Path | None = None
    road: str | None = None
    speed: float | None = None

    def excitation(self, folder: Path) -> tuple[dict[str, Any], str] | None:
        """The excitation as data for a file in a folder, and the axes of the base.

        Raises:
            FtcfaError: If more than one is given, or it has another number of axes.
        """
        given = [name for name in ("vibration", "table", "record", "road") if getattr(self, name)]
        if len(given) > 1:
            raise ParameterError("base", " and ".join(given), "one of them")
        if self.speed is not None and self.road is None:
            raise ParameterError("speed", f"{self.speed:g} without a road", "a road class, A to F")
        if self.vibration:
            for name in self.vibration:
                known_name("vibration", name, standards())
            return self._shaped(list(self.vibration))
        if self.table is not None:
            file = relative(self.table, folder)
            return self._shaped([{"table": file, "name": name} for name in read_table(self.table)])
        if self.record is not None:
            channels = read_record(self.record).values.shape[1]
            record = {"file": relative(self.record, folder)}
            return {"type": "RecordedAcceleration", "record": record}, _axes("record", channels)
        if self.road is not None:
            speed = 15.0 if self.speed is None else self.speed
            return self._shaped([{"type": "Road", "road_class": self.road, "speed": speed}])
        return None

    def _shaped(self, axes: list[Any]) -> tuple[dict[str, Any], str]:
        return {"type": "ShapedNoise", "axes": axes}, _axes("spectra", len(axes))


def _axes(subject: str, count: int) -> str:
    """Axes of the base for a number of channels."""
    if count not in AXES:
        expected = "one (up and down) or three (x, y, z of the world)"
        raise ParameterError(subject, str(count), expected, "choose them in the file")
    return AXES[count]


def starter(
    robot: str,
    shaking: Shaking | None = None,
    *,
    mounting: str | None = None,
    hardware: str | None = None,
    folder: Path = Path(),
) -> str:
    """The text of an experiment file.

    Args:
        robot: An arm of the catalogue or the path of a URDF.
        shaking: What shakes the base; None for a base at rest.
        mounting: "floor", "wall" or "ceiling".
        hardware: A profile's name.
        folder: The folder of the file, from which its paths count.

    Raises:
        FtcfaError: If the arm, the vibration or the profile cannot be used.
    """
    source = {"robot": robot} if mounting is None else {"robot": robot, "mounting": mounting}
    arm = load_arm(**source)  # type: ignore[arg-type]
    if robot not in catalogue() and not robot.startswith("package://"):
        source["robot"] = relative(Path(robot), folder)
    profile = None if hardware is None else hardware_profile(hardware)
    period = 1e-3 if profile is None or profile.period is None else profile.period
    excitation = None if shaking is None else shaking.excitation(folder)
    numbers = {
        "duration": DURATION, "paths": PATHS, "period": period, "tolerance": ERROR,
        **({} if hardware is None else {"hardware": hardware}),
    }  # fmt: skip
    data: dict[str, Any] = {
        **numbers,
        "arm": source,
        "controller": {"type": "FTCF", "compensation": "bias"},
        "reference": reference(arm),
    }
    if excitation is not None:
        given, axes = excitation
        moved = {"type": "BaseAcceleration", "axes": axes}
        data["vibration"] = {"input": moved, "excitation": given}
    data["specification"] = {"error": ERROR, "within": WITHIN, "tool_error": TOOL_ERROR}
    loop = _resolved(data, folder)
    gains = suggest_gains(arm, period, loop.hardware, loop.vibration)
    data["controller"]["gains"] = {
        name: float(f"{value:.{DIGITS}g}") for name, value in fields_of(gains).items()
    }
    makers: dict[str, Any] = {
        "arm": load_arm, "controller": type(loop.controller),
        "reference": type(loop.reference), "vibration": Vibration, "specification": Specification,
        "loop": ClosedLoop,
    }  # fmt: skip
    return HEAD + commented(data, makers, Experiment, ClosedLoop)


HEAD = """\
# An experiment that runs as it is: `ftcfa run FILE`, `ftcfa verify FILE`, `ftcfa tune FILE`.
# A key in a comment has the default that it shows; "..." stands for a key without one.

"""


def _resolved(data: dict[str, Any], folder: Path) -> ClosedLoop:
    """The loop of a document, with as many integration steps as its excitation needs."""
    for substeps in SUBSTEPS:
        data["substeps"] = substeps
        try:
            return rebuild(Experiment, data, "new", folder).loop
        except ExperimentError as error:
            too_long = all(one.got.startswith("integration step") for one in error.errors)
            if not too_long or substeps == SUBSTEPS[-1]:
                raise
    raise AssertionError("SUBSTEPS is not empty")


def reference(arm: Arm) -> dict[str, Any]:
    """A sinusoid about home within the limits of an arm, as data."""
    room = WAY * np.minimum(arm.upper - arm.home, arm.home - arm.lower)
    prismatic = np.array([kind == "prismatic" for kind in arm.joint_types])
    amplitude = np.minimum(np.where(prismatic, SWEEP, AMPLITUDE), np.maximum(room, 0.0))
    speeds = SPEED * arm.velocity_limit / np.maximum(amplitude, 1e-9)
    return {
        "type": "Sinusoid",
        "amplitude": _rounded(amplitude),
        "angular_frequency": _rounded(np.minimum(1.0, speeds)),
        "offset": "home",
    }


def _rounded(values: Array) -> float | list[float]:
    """Numbers rounded down to DIGITS decimals; one number if all are the same."""
    found = (np.floor(values * 10**DIGITS) / 10**DIGITS).tolist()
    return found[0] if len(set(found)) == 1 else found


def relative(file: Path, folder: Path) -> str:
    """The path of a file from a folder."""
    return os.path.relpath(file.expanduser(), folder)
