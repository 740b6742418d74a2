"""The parts that a description of a closed loop may name, and what each is made of.

A part is a dataclass; what it takes is read from its own type hints, so that a new one needs no
more than a place in `PARTS`, and one that another part's hint names outright not even that.
"""

import inspect
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import InitVar, is_dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from ftcfa.control.filters import FILTERS, CommandFilter
from ftcfa.control.ftcf import FTCF
from ftcfa.control.laws import LAWS
from ftcfa.control.protocol import Controller
from ftcfa.errors import UnknownNameError
from ftcfa.loop.closed_loop import ClosedLoop
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
"""What can stand where one of the protocols is asked for."""
OTHERWISE: Mapping[type, tuple[str, Callable[..., Any]]] = {
    Record: ("file", read_record),
    Spectrum: ("g2_per_hz", Spectrum.from_g),
    Standard: ("file", table_of_file),
    Table: ("file", Table.from_file),
}
"""What else makes a part, and the key by which a table asks for it."""


def _arm() -> Arm:
    return load_arm("double_pendulum")


STAND_INS: Mapping[Any, Callable[[], Any]] = {
    Dynamics: _arm,
    Controller: lambda: FTCF(_arm()),
    Reference: lambda: Constant([0.0, 0.0]),
    NoiseInput: lambda: BaseAcceleration("xz"),
    Excitation: WhiteNoise,
    ClosedLoop: lambda: ClosedLoop(_arm(), FTCF(_arm()), Constant([0.0, 0.0])),
}
"""What takes the place of a broken part while the rest is checked."""
SPARES: Mapping[Any, tuple[Any, Any]] = {float: (1e-3, 1e3), int: (1, 1000)}
"""The same for numbers, twice: what is wrong with the rest is wrong with either."""


class Parameter(NamedTuple):
    """What a part takes under one name."""

    hint: Any
    """Its type."""
    default: bool
    """Whether it has one."""

    @property
    def required(self) -> bool:
        """Whether it must be given: it has no default and may not be None."""
        return not self.default and types.NoneType not in get_args(self.hint)


def parameters(call: Callable[..., Any]) -> dict[str, Parameter]:
    """What a dataclass or function takes, by name."""
    hints = get_type_hints(call)
    return {
        name: Parameter(hints[name], given.default is not given.empty)
        for name, given in inspect.signature(call).parameters.items()
        if not isinstance(hints[name], InitVar)
    }


def arm_loader(keys: Iterable[str]) -> tuple[Callable[..., Arm], dict[str, Parameter]]:
    """What makes an Arm of such keywords as `Arm.source` holds, and what it takes."""
    load: Callable[..., Arm] = arm_from_text if "urdf" in keys else load_arm

    def loader(*, inertias: npt.ArrayLike | None = None, **keywords: Any) -> Arm:
        friction = {
            name: np.asarray(keywords.pop(name), dtype=float)
            for name in ("damping", "friction")
            if name in keywords
        }
        arm = load(**keywords)
        if inertias is not None:
            arm = arm.with_inertias(np.asarray(inertias, dtype=float))
        return arm.with_joint_friction(**friction) if friction else arm

    own = ("inertias", "damping", "friction")
    return loader, {**parameters(load), **dict.fromkeys(own, Parameter(npt.ArrayLike, True))}


def alternatives(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows, without None; `numpy.typing.ArrayLike` is one of them."""
    if get_origin(hint) not in (Union, types.UnionType):
        return (hint,)
    allowed = [one for one in get_args(hint) if one is not types.NoneType]
    array = get_args(npt.ArrayLike)
    if set(array) <= set(allowed):
        return (npt.ArrayLike, *(one for one in allowed if one not in array))
    return tuple(allowed)


def choices(hint: Any) -> tuple[type, ...]:
    """The parts that a hint allows."""
    found: list[type] = []
    for one in alternatives(hint):
        if one in PARTS:
            found.extend(PARTS[one])
        elif isinstance(one, type) and is_dataclass(one):
            found.append(one)
    return tuple(found)


def element(hint: Any) -> Any:
    """The hint of an entry of a sequence or mapping, None if the hint allows neither."""
    for one in alternatives(hint):
        if get_origin(one) in (tuple, list, Sequence, Iterable):
            return get_args(one)[0]
        if get_origin(one) in (dict, Mapping):
            return get_args(one)[1]
    return None


def stand_ins(required: Mapping[str, Parameter]) -> dict[str, Any]:
    """Sound parts for those names that ask for parts."""
    found = {}
    for name, parameter in required.items():
        for one in alternatives(parameter.hint):
            if one in STAND_INS:
                found[name] = STAND_INS[one]()
    return found


def spares(required: Mapping[str, Parameter]) -> dict[str, tuple[Any, Any]]:
    """Two sound values, far apart, for those names that ask for numbers or words."""
    found = {}
    for name, parameter in required.items():
        for one in alternatives(parameter.hint):
            if one in SPARES:
                found[name] = SPARES[one]
            elif get_origin(one) is Literal:
                found[name] = (get_args(one)[0], get_args(one)[-1])
    return found
