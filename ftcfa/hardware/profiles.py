"""Hardware of real robots by name, with the source of every number."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ftcfa.checks import known_name
from ftcfa.errors import ParameterError
from ftcfa.hardware.accelerometer import Accelerometer, Gyroscope
from ftcfa.hardware.actuators import Actuators
from ftcfa.hardware.hardware import Hardware
from ftcfa.hardware.sensors import Sensors
from ftcfa.hardware.velocity import BackwardDifference

ROBOTS = Path(__file__).with_name("profiles.toml")
ACCELEROMETERS = Path(__file__).with_name("accelerometers.toml")
ESTIMATORS = {"BackwardDifference": BackwardDifference}


@dataclass(frozen=True)
class Number:
    """A number of a profile.

    Attributes:
        value: The number, or one for each joint.
        source: Document that states it, or "assumed".
        verified: How far that was checked.
    """

    value: Any
    source: str
    verified: str


@dataclass(frozen=True)
class Profile:
    """The hardware of a robot by name.

    Attributes:
        name: Its name.
        description: The robot and its interface, in a phrase.
        numbers: Its numbers, by their names in `Hardware`, such as ``actuators.rate_limit``.
        joints: Number of joints of the robot, or None for any.
        note: What a user must know before using it; empty if nothing.
    """

    name: str
    description: str
    numbers: Mapping[str, Number]
    joints: int | None = None
    note: str = ""

    def hardware(self) -> Hardware:
        """The hardware; the ideal has none of its blocks."""
        groups: dict[str, dict[str, Any]] = {"sensors": {}, "actuators": {}, "": {}}
        for name, number in self.numbers.items():
            group, _, field = name.rpartition(".")
            groups[group][field] = _made(number.value)
        sensors, actuators = Sensors(**groups["sensors"]), Actuators(**groups["actuators"])
        own: dict[str, Any] = {"joints": self.joints, "note": self.note, "name": self.name}
        return Hardware(sensors, actuators, **own, **groups[""])


def _made(value: Any) -> Any:
    """A value, or the part that a table with a type describes."""
    if not isinstance(value, Mapping):
        return value
    rest = {key: each for key, each in value.items() if key != "type"}
    return ESTIMATORS[value["type"]](**rest)


@cache
def profiles() -> Mapping[str, Profile]:
    """All profiles of robots by name."""
    return _read(ROBOTS)


@cache
def accelerometers() -> Mapping[str, Profile]:
    """All classes of accelerometers by name; the numbers of one are those of `Accelerometer`."""
    return _read(ACCELEROMETERS)


def _read(file: Path) -> Mapping[str, Profile]:
    """The profiles of a file by name."""
    tables = tomllib.loads(file.read_text())
    return MappingProxyType({name: _profile(name, table) for name, table in tables.items()})


def _profile(name: str, table: Mapping[str, Any]) -> Profile:
    numbers = {key: Number(**entry) for key, entry in table.get("numbers", {}).items()}
    rest = {key: value for key, value in table.items() if key != "numbers"}
    return Profile(name, numbers=numbers, **rest)


def hardware_profile(profile: str, accelerometer: Accelerometer | None = None) -> Hardware:
    """The hardware of a profile.

    Args:
        profile: Its name: ideal, fr3, ur5e, iiwa14, gen3 or so101.
        accelerometer: Accelerometer on the base, which no profile has.

    Raises:
        UnknownNameError: If there is no such profile; it lists those there are.
    """
    known_name("hardware", profile, profiles(), field="profile")
    found = profiles()[profile].hardware()
    return replace(found, accelerometer=accelerometer)


def accelerometer_profile(profile: str, gyroscope: Gyroscope | None = None) -> Accelerometer:
    """An accelerometer of a class.

    Args:
        profile: Its name: low_noise_mems, industrial_mems or phone.
        gyroscope: Gyroscopes beside it, or None.

    Raises:
        UnknownNameError: If there is no such class; it lists those there are.
    """
    known_name("accelerometer", profile, accelerometers(), field="profile")
    numbers = {name: one.value for name, one in accelerometers()[profile].numbers.items()}
    axes = 3 if gyroscope is None else 6
    return Accelerometer(axes=axes, gyroscope=gyroscope, **numbers)


def as_hardware(subject: str, given: Any) -> Hardware:
    """Hardware as it is, or the profile of a name.

    Raises:
        ParameterError, UnknownNameError: If it is neither.
    """
    if isinstance(given, str):
        known_name(subject, given, profiles())
        return profiles()[given].hardware()
    if not isinstance(given, Hardware):
        expected = f"Hardware(...), or one of: {', '.join(profiles())}"
        raise ParameterError(subject, f"a {type(given).__name__}", expected)
    return given
