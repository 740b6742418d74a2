"""The parts that a description of a closed loop may name.

A part is a frozen dataclass; its keys are read from its type hints. A new part is an entry of
`PARTS`; a part that another part's hint names outright, such as `Gains`, needs none.
"""

from collections.abc import Callable, Iterable, Mapping
from pkgutil import resolve_name
from typing import Any

from ftcfa.control.feed_forward import FeedForward
from ftcfa.control.filters import FILTERS, CommandFilter
from ftcfa.control.laws import LAWS
from ftcfa.control.protocol import Controller
from ftcfa.hardware.accelerometer import Accelerometer
from ftcfa.hardware.hardware import Hardware
from ftcfa.hardware.profiles import accelerometer_profile, hardware_profile
from ftcfa.hardware.velocity import VelocityEstimator
from ftcfa.loop.references import Reference, Table
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.load import arm_from_source
from ftcfa.vibration.excitation import Excitation
from ftcfa.vibration.inputs.noise_input import NoiseInput
from ftcfa.vibration.records.record import Record, read_record
from ftcfa.vibration.spectra.spectrum import Spectrum
from ftcfa.vibration.spectra.standards import (
    Standard,
    read_standard,
    spectrum_of_points,
    standard_of_table,
)

NAMES: Mapping[Any, tuple[str, ...]] = {
    Dynamics: ("ftcfa.model.arm:Arm", "ftcfa.model.pendulum:PaperPendulum"),
    Reference: (
        "ftcfa.loop.references:Constant",
        "ftcfa.loop.references:MinimumJerk",
        "ftcfa.loop.references:Sinusoid",
        "ftcfa.loop.references:Table",
    ),
    NoiseInput: (
        "ftcfa.vibration.inputs.noise_input:BaseAcceleration",
        "ftcfa.vibration.inputs.base_motion:BaseMotion",
        "ftcfa.vibration.inputs.noise_input:FrameWrench",
        "ftcfa.vibration.inputs.noise_input:JointTorque",
        "ftcfa.vibration.inputs.noise_input:PaperPendulumInput",
    ),
    VelocityEstimator: (
        "ftcfa.hardware.velocity:BackwardDifference",
        "ftcfa.hardware.velocity:Kalman",
        "ftcfa.hardware.velocity:Levant",
        "ftcfa.hardware.velocity:ModelObserver",
    ),
    Excitation: (
        "ftcfa.vibration.excitations.white_noise:WhiteNoise",
        "ftcfa.vibration.excitations.shaped_noise:ShapedNoise",
        "ftcfa.vibration.excitations.random_phase:RandomPhase",
        "ftcfa.vibration.excitations.recorded:RecordedAcceleration",
        "ftcfa.vibration.excitations.harmonic:Harmonic",
        "ftcfa.vibration.excitations.sweep:SineSweep",
        "ftcfa.vibration.excitation:Superposition",
        "ftcfa.vibration.excitation:Stacked",
    ),
}
"""The parts that implement each protocol, ``module:class``; a new part is one more line."""
PARTS: Mapping[Any, tuple[type, ...]] = {
    Controller: (*LAWS, FeedForward),
    CommandFilter: tuple(FILTERS.values()),
    **{protocol: tuple(map(resolve_name, names)) for protocol, names in NAMES.items()},
}
"""The classes that implement each protocol."""
MAKERS: Mapping[type, Mapping[str, Callable[..., Any]]] = {
    Arm: {"robot": arm_from_source},
    Accelerometer: {"profile": accelerometer_profile},
    Hardware: {"profile": hardware_profile},
    Record: {"file": read_record},
    Spectrum: {"g2_per_hz": Spectrum.from_g, "points": spectrum_of_points},
    Standard: {"table": standard_of_table, "file": read_standard},
    Table: {"file": Table.from_file},
}
"""Functions that also make a part, by the key that a table for it has."""


def maker(cls: type, keys: Mapping[str, Any]) -> Callable[..., Any]:
    """The class itself, or the function that makes a part of such keys."""
    if cls is Arm:
        return arm_from_source
    return next((make for key, make in MAKERS.get(cls, {}).items() if key in keys), cls)


def made_by(parts: Iterable[type], keys: Mapping[str, Any]) -> list[str]:
    """Names of the parts that one of the keys alone makes."""
    return [p.__name__ for p in parts if any(key in keys for key in MAKERS.get(p, {}))]
