"""Vibration specifications as excitations take them: a table's name, a table, or a spectrum."""

from collections.abc import Sequence
from typing import Any

from ftcfa.errors import ParameterError
from ftcfa.vibration.spectrum import Spectrum
from ftcfa.vibration.standards import Standard, standard

Specification = str | Standard | Spectrum
"""A specification: the name of a standard's table, the table, or a spectrum."""


def spectrum_of(specification: Specification) -> Spectrum:
    """The spectrum of a specification.

    Raises:
        UnknownNameError: If there is no table of a name; it lists the known ones.
        ParameterError: If it is no specification.
    """
    if isinstance(specification, str):
        specification = standard(specification)
    if isinstance(specification, Standard):
        return specification.spectrum
    if isinstance(specification, Spectrum):
        return specification
    raise ParameterError(
        "vibration specification",
        repr(specification),
        "a standard's name, a Standard or a Spectrum",
        "break points make one: Spectrum.from_g([10, 40, 500], [0.015, 0.015, 0.00015])",
    )


def several(subject: str, axes: Any) -> tuple[Any, ...]:
    """The axes of an excitation as a tuple; a single one needs no brackets.

    Raises:
        ParameterError: If there is none.
    """
    one = isinstance(axes, str) or not isinstance(axes, Sequence)
    found = (axes,) if one else tuple(axes)
    if not found:
        raise ParameterError(subject, "none", "a specification for each axis")
    return found
