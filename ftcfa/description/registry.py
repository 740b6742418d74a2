"""The parts that a description of a closed loop may name.

A part is a frozen dataclass; its keys are read from its type hints. A new part is an entry of
`PARTS`; a part that another part's hint names outright, such as `Gains`, needs none.
"""

from collections.abc import Callable, Mapping
from dataclasses import field, make_dataclass
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import numpy.typing as npt

from ftcfa.control.filters import FILTERS, CommandFilter
from ftcfa.control.laws import LAWS
from ftcfa.control.protocol import Controller
from ftcfa.errors import UnknownNameError
from ftcfa.loop.references import Constant, MinimumJerk, Reference, Sinusoid, Table
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.pendulum import PaperPendulum
from ftcfa.model.urdf.load import arm_from_text, load_arm
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
from ftcfa.vibration.spectra.standards import Standard, read_table


def table_of_file(file: str | Path, name: str) -> Standard:
    """The specification of one name in a file such as `read_table` reads.

    Raises:
        ParameterError, UnknownNameError: If the file is wrong or has no such table.
    """
    tables = read_table(file)
    if name not in tables:
        raise UnknownNameError(f"{file}: table", name, tuple(tables))
    return tables[name]


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
    Arm: ("urdf", arm_from_text),
    Record: ("file", read_record),
    Spectrum: ("g2_per_hz", Spectrum.from_g),
    Standard: ("file", table_of_file),
    Table: ("file", Table.from_file),
}
"""Functions that also make a part, each with the key that a table for it has."""


CHANGES = ("inertias", "damping", "friction")
"""Keys of an Arm for what was changed after it was loaded; see `Arm.source`."""


def make(cls: type, keywords: Mapping[str, Any]) -> Any:
    """Call the function that makes a part of some keywords: `load_arm` for an Arm."""
    if cls is not Arm:
        return maker(cls, keywords)(**keywords)
    changes = {
        name: np.asarray(keywords[name], dtype=float) for name in CHANGES if name in keywords
    }
    rest = {name: value for name, value in keywords.items() if name not in CHANGES}
    arm: Arm = maker(cls, keywords)(**rest)
    if "inertias" in changes:
        arm = arm.with_inertias(changes.pop("inertias"))
    return arm.with_joint_friction(**changes) if changes else arm


def maker(cls: type, keys: Mapping[str, Any]) -> Callable[..., Any]:
    """The class itself, or the function that makes a part of such keys."""
    key, function = MAKERS.get(cls, ("", cls))
    if key in keys:
        return function
    return load_arm if cls is Arm else cls


@cache
def arguments(call: Callable[..., Any]) -> Any:
    """A dataclass with a field for each argument of a function that makes a part."""
    hints = get_type_hints(call)
    described: list[Any] = [
        (
            name,
            hints[name],
            *([] if given.default is given.empty else [field(default=given.default)]),
        )
        for name, given in signature(call).parameters.items()
    ]
    if call in (load_arm, arm_from_text):
        described += [(name, npt.ArrayLike, field(default=())) for name in CHANGES]
    return make_dataclass("Arguments", described, kw_only=True)
