"""A measured vibration as plain data, as text and as a table of break points."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w
from rich.console import Console

from ftcfa.errors import ParameterError
from ftcfa.report.records import versions
from ftcfa.report.terminal import print_facts, print_line, print_table
from ftcfa.study.measured_spectrum import BANDS, MeasuredVibration
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY

LINEAR = "m/s^2"
"""Unit of the axes that tables are made of: standards state no angular accelerations."""


def measured_record(measured: MeasuredVibration, table: Path | None = None) -> dict[str, Any]:
    """All that ``ftcfa vibration --record`` shows, as plain data; units stand in each axis.

    ``table`` is the file to which the break points go, if any.
    """
    record, estimate = measured.record, measured.estimate
    axes = [
        {
            "name": name,
            "unit": unit,
            "rms": float(record.rms()[k]),
            "peak": float(measured.peak[k]),
            "crest_factor": float(measured.crest_factor[k]),
            "kurtosis": float(measured.kurtosis[k]),
            "points": _points(measured, k) if unit == LINEAR else None,
        }
        for k, (name, unit) in enumerate(zip(record.axes, record.units, strict=True))
    ]
    return {
        "samples": len(record.values),
        "rate": 1.0 / record.step,
        "duration": record.duration,
        "notes": list(record.notes),
        "resolution": float(estimate.frequencies[0]),
        "segments": estimate.segments,
        "standard_error": estimate.standard_error,
        "confidence": measured.confidence,
        "axes": axes,
        "table": None if table is None else str(table),
        "versions": versions("ftcfa", "numpy", "scipy", "pandas"),
        "units": {"rate": "Hz", "duration": "s", "resolution": "Hz", "points": "[Hz, g^2/Hz]"},
    }


def _points(measured: MeasuredVibration, k: int) -> list[list[float]]:
    """Break points of an axis's envelope [Hz, g^2/Hz]."""
    envelope = measured.envelopes[k]
    g = envelope.densities / STANDARD_GRAVITY**2
    return [
        [float(f"{f:.5g}"), float(f"{S:.4g}")] for f, S in zip(envelope.frequencies, g, strict=True)
    ]


def measured_table(record: Mapping[str, Any]) -> bytes:
    """The TOML file of `ftcfa.vibration.spectra.standards` with a table for each linear axis.

    Raises:
        ParameterError: If no axis is linear.
    """
    tables = {
        axis["name"]: {
            "points": axis["points"],
            "source": f"measured: {'; '.join(record['notes'])}",
            "verified": (
                f"upper {100 * record['confidence']:g} % confidence limit of the mean density in "
                f"each 1/{BANDS} octave, {record['segments']} segments of Welch's estimate"
            ),
        }
        for axis in record["axes"]
        if axis["points"]
    }
    if not tables:
        raise ParameterError("table of the record", "angular axes only", "an axis in m/s^2")
    return tomli_w.dumps(tables).encode()


def print_measured(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `measured_record`."""
    file, *notes = record["notes"]
    print_line(file, console, "bold")
    rows = (
        [
            axis["name"], f"{axis['rms']:.4g}", f"{axis['peak']:.4g}",
            f"{axis['crest_factor']:.3g}", f"{axis['kurtosis']:.3g}", axis["unit"],
        ]
        for axis in record["axes"]
    )  # fmt: skip
    print_table(["axis", "rms", "peak", "crest", "kurtosis", "unit"], rows, console, "frrrrl")
    console.print()
    error = record["standard_error"]
    facts = [
        (
            "samples",
            f"{record['samples']:,} at {record['rate']:.6g} Hz, {record['duration']:.4g} s",
        ),
        *(("note", note) for note in notes),
        (
            "spectrum",
            f"every {record['resolution']:.3g} Hz, {record['segments']} overlapping segments, "
            f"standard error {100 * error:.2g} %",
        ),
    ]
    if record["table"]:
        names = ", ".join(axis["name"] for axis in record["axes"] if axis["points"])
        facts.append(("table", f"break points of {names} in {record['table']}"))
    print_facts(facts, console)
