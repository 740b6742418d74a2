"""What a column of a record measures, by its unit, and the acceleration that follows from it."""

import re
from typing import Literal, NamedTuple

import numpy as np
from scipy.signal import savgol_filter

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

DEGREE = np.pi / 180.0
WINDOW, ORDER = 9, 4
"""Samples and order of the polynomials of Savgolay and Golay that derivatives are taken from."""
Unit = Literal[
    "m/s^2", "mm/s^2", "g", "mg", "gal", "rad/s^2", "deg/s^2", "m/s", "mm/s", "rad/s", "deg/s", "m",
    "mm", "rad", "deg",
]  # fmt: skip


class Quantity(NamedTuple):
    """A unit: its size in SI, and how many derivatives make an acceleration of it."""

    size: float
    derivatives: int = 0
    unit: str = "m/s^2"  # of the acceleration


UNITS: dict[str, Quantity] = {
    "m/s^2": Quantity(1.0),
    "mm/s^2": Quantity(1e-3),
    "g": Quantity(STANDARD_GRAVITY),
    "mg": Quantity(1e-3 * STANDARD_GRAVITY),
    "gal": Quantity(1e-2),
    "rad/s^2": Quantity(1.0, 0, "rad/s^2"),
    "deg/s^2": Quantity(DEGREE, 0, "rad/s^2"),
    "m/s": Quantity(1.0, 1),
    "mm/s": Quantity(1e-3, 1),
    "rad/s": Quantity(1.0, 1, "rad/s^2"),
    "deg/s": Quantity(DEGREE, 1, "rad/s^2"),
    "m": Quantity(1.0, 2),
    "mm": Quantity(1e-3, 2),
    "rad": Quantity(1.0, 2, "rad/s^2"),
    "deg": Quantity(DEGREE, 2, "rad/s^2"),
}
"""Units of accelerations, and of rates and positions whose derivatives are accelerations."""
_SQUARED = re.compile(r"/\(?s(?:\^2|2|²|\*\*2|/s)\)?")
_POWER = re.compile(r"\s*[*·⋅ ]\s*s(?:\^-2|-2|⁻²)")


def quantity(subject: str, unit: str) -> Quantity:
    """The quantity of a unit in one of its spellings.

    Raises:
        ParameterError: If no unit is stated.
        UnknownNameError: If it is unknown.
    """
    if not unit:
        remedy = 'unit="g" or unit="m/s^2", or a header such as "x [g]"'
        raise ParameterError(subject, "not stated", remedy)
    usual = same_unit(unit)
    if usual not in UNITS:
        raise UnknownNameError(subject, unit, UNITS)
    return UNITS[usual]


def same_unit(unit: str) -> str:
    """A unit in our spelling: m/s^2 for m/s², m/s/s, m/s2, m s^-2; deg for °."""
    text = unit.strip().replace("°", "deg").replace("degrees", "deg")
    text = _SQUARED.sub("/s^2", _POWER.sub("/s^2", text))
    folded = {name.lower(): name for name in UNITS}
    return folded.get(text.lower(), text)


def acceleration(values: Array, kind: Quantity, step: float) -> Array:
    """The acceleration of values of a quantity, shape (samples,) [m/s^2 or rad/s^2].

    Derivatives are those of polynomials of degree ORDER fitted to WINDOW samples (Savitzky and
    Golay 1964): exact to that degree, and within 3 dB up to about a quarter of the sampling rate.

    Raises:
        ParameterError: If there are fewer samples than the window has.
    """
    values = values * kind.size
    if not kind.derivatives:
        return values
    if len(values) < WINDOW:
        got, expected = f"{len(values)} samples", f"{WINDOW} or more for a derivative"
        raise ParameterError("record", got, expected)
    return np.asarray(savgol_filter(values, WINDOW, ORDER, deriv=kind.derivatives, delta=step))


def derivation(kind: Quantity) -> str:
    """How an acceleration was made of a quantity, as a note; "" for an acceleration."""
    if not kind.derivatives:
        return ""
    which = {1: "first", 2: "second"}[kind.derivatives]
    return f"{which} derivative by polynomials of degree {ORDER} over {WINDOW} samples"
