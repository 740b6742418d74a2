"""The parts that a description of a closed loop may name.

A part is a frozen dataclass; its keys are read from its type hints. A new part is an entry of
`PARTS`; a part that another part's hint names outright, such as `Gains`, needs none.
"""

from collections.abc import Callable, Mapping
from dataclasses import field, make_dataclass
from functools import cache
from inspect import signature
from typing import Any, get_type_hints

from ftcfa.control.filters import FILTERS, CommandFilter
from ftcfa.control.laws import LAWS
from ftcfa.control.protocol import Controller
from ftcfa.loop.references import Constant, MinimumJerk, Reference, Sinusoid, Table
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.pendulum import PaperPendulum
from ftcfa.model.urdf.source import arm_from_source
from ftcfa.vibration.excitation import Excitation, Superposition
from ftcfa.vibration.excitations.harmonic import Harmonic
from ftcfa.vibration.excitations.random_phase import RandomPhase
from ftcfa.vibration.excitations.recorded import RecordedAcceleration
from ftcfa.vibration.excitations.shaped_noise import ShapedNoise
from ftcfa.vibration.excitations.stacked import Stacked
from ftcfa.vibration.excitations.sweep import SineSweep
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.base_motion import BaseMotion
from ftcfa.vibration.inputs.noise_input import (
    BaseAcceleration,
    FrameWrench,
    JointTorque,
    NoiseInput,
    PaperPendulumInput,
)
from ftcfa.vibration.record import Record, read_record
from ftcfa.vibration.spectra.spectrum import Spectrum
from ftcfa.vibration.spectra.standards import Standard, read_standard

PARTS: Mapping[Any, tuple[type, ...]] = {
    Dynamics: (Arm, PaperPendulum),
    Controller: LAWS,
    CommandFilter: tuple(FILTERS.values()),
    Reference: (Constant, MinimumJerk, Sinusoid, Table),
    NoiseInput: (BaseAcceleration, BaseMotion, FrameWrench, JointTorque, PaperPendulumInput),
    Excitation: (
        WhiteNoise,
        ShapedNoise,
        RandomPhase,
        RecordedAcceleration,
        Harmonic,
        SineSweep,
        Superposition,
        Stacked,
    ),
}
"""The parts that implement each protocol; a new part is one more entry."""
MAKERS: Mapping[type, tuple[str, Callable[..., Any]]] = {
    Arm: ("robot", arm_from_source),
    Record: ("file", read_record),
    Spectrum: ("g2_per_hz", Spectrum.from_g),
    Standard: ("file", read_standard),
    Table: ("file", Table.from_file),
}
"""Functions that also make a part, each with the key that a table for it has."""


def maker(cls: type, keys: Mapping[str, Any]) -> Callable[..., Any]:
    """The class itself, or the function that makes a part of such keys."""
    key, function = MAKERS.get(cls, ("", cls))
    return function if key in keys or cls is Arm else cls


@cache
def arguments(call: Callable[..., Any]) -> Any:
    """A dataclass with a field for each argument of a function that makes a part."""
    hints = get_type_hints(call)
    made: list[Any] = []
    for name, given in signature(call).parameters.items():
        default = [] if given.default is given.empty else [field(default=given.default)]
        made.append((name, hints[name], *default))
    return make_dataclass("Arguments", made, kw_only=True)
