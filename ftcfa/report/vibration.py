"""Vibration standards as plain data and as tables: lists, fits, levels, steps."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Any

import numpy as np
from rich.console import Console
from rich.text import Text

from ftcfa.report.records import versions
from ftcfa.report.terminal import print_facts, print_line
from ftcfa.study.realised_spectrum import RealisedStandard, SpectrumEstimate
from ftcfa.vibration.spectra.filter_fit import FilterFit
from ftcfa.vibration.spectra.road import PROVENANCE, REFERENCE_FREQUENCY, ROAD_CLASSES
from ftcfa.vibration.spectra.section_fit import DB
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY, step_limit, substeps_needed
from ftcfa.vibration.spectra.standards import NOT_STATED, Standard

PERIOD = 1e-3
"""Controller period for which the number of substeps is given, the default of a loop [s]."""
ERRORS = ("worst_db", "worst_frequency", "edge_db", "edge_frequency", "rms_error", "outside")
VERDICTS = ("within_tolerance", "within_edge_tolerance")
"""Attributes of a fit that its record holds: numbers, and yes or no."""
UNITS = {"g_rms": "g", "nominal_g_rms": "g", "band": "Hz", "points": "[Hz, g^2/Hz]"}
"""Units of the entries that describe a table."""


def unverified(verified: str) -> bool:
    """Whether no primary source of a table was seen, by what its author says of checks."""
    return verified == NOT_STATED or verified.startswith("unverified")


def provenance_lines(source: str, verified: str) -> list[str]:
    """Source of a table and how far it was checked, a line each."""
    known = "" if verified.startswith("unverified") else "verified: "
    return [f"source: {source}", f"{known}{verified}"]


def catalogue_record(standards: Mapping[str, Standard]) -> dict[str, Any]:
    """All that ``ftcfa vibration`` without names shows, as plain data."""
    return {
        "standards": [_table(standard) for standard in standards.values()],
        "roads": {
            "provenance": PROVENANCE,
            "reference_frequency": REFERENCE_FREQUENCY,
            "roughness": dict(ROAD_CLASSES),
        },
        "units": {**UNITS, "reference_frequency": "cycles/m", "roughness": "m^3"},
    }


def realised_record(realised: Sequence[RealisedStandard]) -> dict[str, Any]:
    """Content of summary.json: an entry for each standard, and what is needed to run it again."""
    return {
        "standards": [_realised(one) for one in realised],
        "period": PERIOD,
        "versions": versions("ftcfa", "numpy", "scipy", "matplotlib"),
        "units": {
            **UNITS,
            **dict.fromkeys(("worst_db", "edge_db"), "dB"),
            **dict.fromkeys(("worst_frequency", "edge_frequency", "resolution"), "Hz"),
            **dict.fromkeys(("duration", "step", "largest_step", "period"), "s"),
        },
    }


def _table(standard: Standard) -> dict[str, Any]:
    """Record of a table: its points, level and source."""
    spectrum = standard.spectrum
    g = spectrum.densities / STANDARD_GRAVITY**2
    return {
        "name": standard.name,
        "source": standard.source,
        "verified": standard.verified,
        "unverified": unverified(standard.verified),
        "nominal_g_rms": standard.nominal_g_rms,
        "g_rms": spectrum.g_rms(),
        "band": list(spectrum.band),
        "points": np.column_stack([spectrum.frequencies, g]).tolist(),
    }


def _realised(one: RealisedStandard) -> dict[str, Any]:
    """Record of a standard: its table, the fit, and the spectra of realisations."""
    return {
        **_table(one.standard),
        "largest_step": step_limit(one.standard.spectrum.band[1]),
        "substeps": substeps_needed(one.standard.spectrum.band[1], PERIOD),
        "fit": _fit(one.fit),
        "realised": {
            "step": one.step,
            "seed": one.seed,
            "path": 0,
            "shaped_noise": {"duration": one.duration, **_estimate(one.shaped)},
            "random_phase": {"lines": one.lines, **_estimate(one.tones)},
        },
    }


def _fit(fit: FilterFit) -> dict[str, Any]:
    """Record of a fitted filter."""
    return {
        "sentence": str(fit),
        "order": fit.filter.order,
        "g_rms": float(fit.filter.rms()[0]) / STANDARD_GRAVITY,
        **{name: float(getattr(fit, name)) for name in ERRORS},
        **{name: bool(getattr(fit, name)) for name in VERDICTS},
    }


def _estimate(estimate: SpectrumEstimate) -> dict[str, Any]:
    """Record of an estimated spectrum."""
    return {
        "g_rms": float(estimate.rms[0]) / STANDARD_GRAVITY,
        "resolution": float(estimate.frequencies[0]),
        "segments": estimate.segments,
        "standard_error": estimate.standard_error,
    }


def print_catalogue(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `catalogue_record`: the standards, grouped by their sources."""
    origin = itemgetter("source", "verified")
    for (source, verified), entries in groupby(record["standards"], origin):
        print_line(source, console, "bold")
        console.print(_marked(verified))
        rows = [(f"  {x['name']}", f"{x['g_rms']:.4g} g rms", _band(x)) for x in entries]
        print_facts(rows, console, "")
        console.print()
    roads = record["roads"]
    print_line("Road classes of ISO 8608, for ftcfa.Road", console, "bold")
    print_line(roads["provenance"], console, "yellow")
    classes = roads["roughness"].items()
    print_facts([(f"  {name}", f"{1e6 * x:g}e-6 m^3") for name, x in classes], console, "")
    n_0 = f"{roads['reference_frequency']:g} cycles/m"
    print_line(f"  (displacement density at {n_0})", console, "dim")


def print_realised(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `realised_record`: what became of each standard."""
    for entry in record["standards"]:
        print_line(entry["name"], console, "bold")
        print_facts(_facts(entry, record["period"]), console)
        console.print()


def _facts(entry: Mapping[str, Any], period: float) -> list[tuple[str, str | Text]]:
    """Labels and texts of what became of a standard."""
    shaped, tones = (entry["realised"][name] for name in ("shaped_noise", "random_phase"))
    error = DB * np.log1p(shaped["standard_error"])
    step = f"at most {1e3 * entry['largest_step']:.4g} ms"
    return [
        ("source", entry["source"]),
        ("verified", _marked(entry["verified"])),
        ("specified", f"{entry['g_rms']:.4g} g rms, {_band(entry)}"),
        ("fitted", entry["fit"]["sentence"]),
        (
            "realised",
            f"{shaped['g_rms']:.4g} g rms in {shaped['duration']:.0f} s of ShapedNoise (spectrum "
            f"every {shaped['resolution']:.3g} Hz with a standard error of {error:.1f} dB); "
            f"{tones['g_rms']:.4g} g rms by RandomPhase with {tones['lines']} lines",
        ),
        ("step", f"{step}: substeps={entry['substeps']} for a period of {1e3 * period:g} ms"),
    ]


def _band(entry: Mapping[str, Any]) -> str:
    low, high = entry["band"]
    return f"{low:g} to {high:g} Hz"


def _marked(verified: str) -> Text:
    """The text, in yellow if it says that a table is unverified."""
    return Text(verified, "yellow" if unverified(verified) else "")
