"""Vibration standards by name, and tables of a user's own in the same TOML schema.

[name]
points = [[10, 0.015], [40, 0.015], [500, 0.00015]]   # [Hz, g^2/Hz], the only required key
#        [[20, "+3 dB/octave"], [80, 0.04], [350, 0.04], [350, 0.08], [2000, "-3 dB/octave"]]
#        a slope stands for the density to which it leads; the same frequency twice is a step
unit = "g^2/Hz"                                       # or "(m/s^2)^2/Hz"
source = "document that states the table"
verified = "how far that was checked"
nominal_g_rms = 1.04                                  # if given, checked to 5 %
integral_g_rms = 1.043                                # if given, checked to 1 %
plausible_g_rms = 60                                  # a level above it is refused
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ftcfa.checks import known_name, positive
from ftcfa.errors import ParameterError
from ftcfa.files import read_toml
from ftcfa.vibration.records.columns import read_text_columns
from ftcfa.vibration.spectra.spectrum import PLAUSIBLE_G_RMS, STANDARD_GRAVITY, Spectrum

G_UNIT, SI_UNIT = "g^2/Hz", "(m/s^2)^2/Hz"
LEVEL_TOLERANCE = {"integral_g_rms": 0.01, "nominal_g_rms": 0.05}
"""Allowed relative difference from the integral; nominal levels often have two digits only."""
OCTAVE_DB = 10.0 * math.log10(2.0)
"""Decibels of a density that doubles."""
MOST = 300.0
"""Largest number of octaves of a density along a slope."""
STEP = 1e-6
"""Relative width of a step of the density."""
LONGEST = 200
"""Characters of wrong points that a message shows."""
_SLOPE = re.compile(r"\s*([+-]?\d+(?:\.\d*)?)\s*dB\s*/\s*oct(?:ave)?\s*", re.IGNORECASE)
TEXTS = ("unit", "source", "verified")
NOT_STATED = "not stated"
LEVELS = ("nominal_g_rms", "integral_g_rms", "plausible_g_rms")


@dataclass(frozen=True, eq=False)
class Standard:
    """A vibration standard: a spectrum with its provenance.

    Attributes:
        name: Name of its table.
        source: Document that states it.
        verified: How far that was checked; begins with "unverified" if no primary source was
            seen.
        spectrum: The break points.
        nominal_g_rms: Overall level that the document states, if it does [g].
    """

    name: str
    source: str
    verified: str
    spectrum: Spectrum
    nominal_g_rms: float | None = None

    @property
    def provenance(self) -> str:
        """Source and how far it was checked; to be shown wherever the standard is offered."""
        return f"source: {self.source}; verified: {self.verified}"

    def __str__(self) -> str:
        return f"{self.name}: {self.spectrum} ({self.provenance})"


@cache
def standards() -> Mapping[str, Standard]:
    """Standards that come with the package, by name."""
    return read_table(Path(__file__).with_name("standards.toml"))


def standard(name: str) -> Standard:
    """Standard of a name.

    Raises:
        UnknownNameError: If there is none of that name; it lists the known ones.
    """
    known_name("vibration standard", name, standards())
    return standards()[name]


SpectrumLike = str | Standard | Spectrum
"""A spectrum: the name of a table of `standards()`, a `Standard` or a `Spectrum`."""


def spectrum_of(axis: SpectrumLike) -> Spectrum:
    """Spectrum of an axis of an excitation.

    Raises:
        UnknownNameError: If there is no standard of a name; it lists the known ones.
        ParameterError: If the axis is no spectrum.
    """
    if isinstance(axis, str):
        axis = standard(axis)
    if isinstance(axis, Standard):
        return axis.spectrum
    if isinstance(axis, Spectrum):
        return axis
    raise ParameterError(
        "spectrum",
        repr(axis),
        "a standard's name, a Standard or a Spectrum",
        "break points make one: Spectrum.from_g([10, 40, 500], [0.015, 0.015, 0.00015])",
    )


def several(subject: str, axes: Any) -> tuple[Any, ...]:
    """Axes as a tuple, of which a single one needs no brackets; ParameterError if there is none."""
    single = isinstance(axes, str) or not isinstance(axes, Sequence)
    given = (axes,) if single else tuple(axes)
    if not given:
        raise ParameterError(subject, "none", "a spectrum for each axis")
    return given


def read_table(file: str | Path) -> Mapping[str, Standard]:
    """Standards of a TOML file, by table name.

    Args:
        file: File with one TOML table for each standard, with the keys above; or a CSV file with
            a column of frequencies [Hz] and others of densities, such as Welch's estimates,
            whose names are those of the standards: ``frequency [Hz], floor [g^2/Hz]``.

    Raises:
        ParameterError: Naming the file, and the table and key that are wrong.
        UnknownNameError: If a table has an unknown key.
    """
    path = Path(file)
    if path.suffix.lower() in (".csv", ".tsv", ".txt"):
        return MappingProxyType(_spectra_of_csv(path))
    document = read_toml(path)
    if not document:
        raise ParameterError(str(path), "no table", "one TOML table for each standard", _EXAMPLE)
    return MappingProxyType({name: _entry(path, name, it) for name, it in document.items()})


def spectrum_of_points(points: Sequence[Any], unit: str = G_UNIT) -> Spectrum:
    """Spectrum of break points [[frequency, density], ...], as a table has them.

    Raises:
        ParameterError: If they are none.
    """
    return _entry(Path("Spectrum"), "points", {"points": list(points), "unit": unit}).spectrum


def standard_of_table(table: str | Path, name: str) -> Standard:
    """The standard of one name in a file; see `read_table`."""
    return read_standard(table, name)


def read_standard(file: str | Path, name: str) -> Standard:
    """The standard of one name in a file such as `read_table` reads.

    Raises:
        ParameterError, UnknownNameError: If the file is wrong or has no such table.
    """
    tables = read_table(file)
    known_name(f"{file}: table", name, tables, field="name")
    return tables[name]


def _spectra_of_csv(path: Path) -> dict[str, Standard]:
    """The spectra of a text table by the names of their columns, without a density at 0 Hz."""
    columns = read_text_columns(path)
    if not columns.header or columns.units[0].lower() != "hz":
        expected = 'a header such as "frequency [Hz], floor [g^2/Hz]"'
        raise ParameterError(str(path), "no column of frequencies in Hz", expected)
    f, found = columns.numbers(0), {}
    for k, name in enumerate(columns.names[1:], 1):
        S = columns.numbers(k)
        kept = (f > 0) & (S > 0)
        pairs = np.column_stack([f[kept], S[kept]]).tolist()
        entry = {"points": pairs, "unit": columns.units[k] or NOT_STATED, "source": path.name}
        found[name] = _entry(path, name, entry)
    return found


_EXAMPLE = "such as [floor] with points = [[10, 0.015], [500, 0.00015]]"


def _entry(path: Path, name: str, entry: Any) -> Standard:
    where = f"{path}: [{name}]"
    if not isinstance(entry, dict):
        raise ParameterError(f"{path}: '{name}'", repr(entry), "a TOML table", _EXAMPLE)
    for key in entry:
        known_name(f"{where}: key", key, ("points", *TEXTS, *LEVELS))
    texts = {key: entry.get(key, NOT_STATED) for key in TEXTS}
    for key, text in texts.items():
        if not isinstance(text, str):
            raise ParameterError(f"{where}: {key}", repr(text), "a text")
    levels = {}
    for key in LEVELS:
        if key in entry:
            positive(f"{where}: {key}", entry[key], "g")
            levels[key] = float(entry[key])
    unit = entry.get("unit", G_UNIT)
    if unit not in (G_UNIT, SI_UNIT):
        raise ParameterError(f"{where}: unit", repr(unit), f'"{G_UNIT}" or "{SI_UNIT}"')
    points = _points(where, entry)
    plausible = levels.get("plausible_g_rms", PLAUSIBLE_G_RMS)
    try:
        if unit == G_UNIT:
            spectrum = Spectrum.from_g(points[:, 0], points[:, 1], plausible)
        else:
            spectrum = Spectrum(points[:, 0], points[:, 1])
    except ParameterError as error:
        raise ParameterError(
            f"{where}: points: {error.subject}", error.got, error.expected, error.remedy
        ) from error
    for key, tolerance in LEVEL_TOLERANCE.items():
        if key in levels:
            _check_level(where, key, levels[key], spectrum.g_rms(), tolerance)
    return Standard(name, texts["source"], texts["verified"], spectrum, levels.get("nominal_g_rms"))


def _points(where: str, entry: Mapping[str, Any]) -> Any:
    """The break points, shape (k, 2)."""
    rows = entry.get("points")
    pairs = isinstance(rows, list) and all(isinstance(r, list) and len(r) == 2 for r in rows)
    if not (rows and pairs and all(_is_point(*row) for row in rows)):
        got = repr(rows)[:LONGEST] if "points" in entry else "missing"
        raise ParameterError(f"{where}: points", got, "[[frequency, density], ...]", _EXAMPLE)
    f = [float(row[0]) for row in rows]
    S = [_slope(row[1]) if isinstance(row[1], str) else float(row[1]) for row in rows]
    known = [not isinstance(row[1], str) for row in rows]
    for i in [*range(len(f)), *reversed(range(len(f)))]:
        if not known[i]:
            near = next((j for j in (i - 1, i + 1) if 0 <= j < len(f) and known[j]), None)
            if near is not None and min(f[i], f[near], S[near]) > 0:
                octaves = (S[i] / OCTAVE_DB) * (math.log2(f[i]) - math.log2(f[near]))
                S[i], known[i] = S[near] * 2.0 ** min(max(octaves, -MOST), MOST), True
    if not all(known):
        raise ParameterError(f"{where}: points", "slopes only", "a density", _EXAMPLE)
    for i in range(1, len(f)):
        if f[i] == f[i - 1]:
            f[i] = f[i] * (1.0 + STEP)
    return np.column_stack([f, S])


def _is_point(f: Any, S: Any) -> bool:
    """Whether two entries are a frequency and a density or a slope."""
    number = type(S) in (int, float) or (isinstance(S, str) and _SLOPE.fullmatch(S))
    return type(f) in (int, float) and bool(number)


def _slope(text: str) -> float:
    """A slope in dB/octave."""
    match = _SLOPE.fullmatch(text)
    assert match is not None
    return float(match[1])


def _check_level(where: str, key: str, stated: float, level: float, tolerance: float) -> None:
    if abs(level / stated - 1.0) <= tolerance:
        return
    remedy = "correct the points or the level"
    if abs(level / stated * STANDARD_GRAVITY - 1.0) <= tolerance:
        remedy = "the points are 9.81 times too small in amplitude: is their unit g^2/Hz?"
    elif abs(level / stated / STANDARD_GRAVITY - 1.0) <= tolerance:
        remedy = f'the points are 9.81 times too large in amplitude: state unit = "{SI_UNIT}"'
    got = f"{stated:g} stated, {level:.4g} g rms by integration of the points"
    raise ParameterError(f"{where}: {key}", got, f"agreement to {100 * tolerance:g} %", remedy)
