"""From a record to a table to noise: the spectra agree with the one that was put in."""

import json

import numpy as np
import pytest

from ftcfa import ShapedNoise
from ftcfa.cli import main
from ftcfa.errors import ParameterError
from ftcfa.study.measured_spectrum import measured_vibration
from ftcfa.study.realised_spectrum import estimate_spectrum
from ftcfa.vibration.realisation import realise
from ftcfa.vibration.records.record import Record
from ftcfa.vibration.spectra.standards import read_table

G = 9.80665
RATE = 2000.0
KNOWN = np.array([[5, 0.0005], [20, 0.02], [80, 0.02], [200, 0.001], [400, 0.001]])
"""Break points of the spectrum that is put in [Hz, g^2/Hz]."""
CLOSE_DB, WITHIN_DB = 1.0, 1.5


def density(f):
    """The known spectrum, straight lines in log-log, zero outside [g^2/Hz]."""
    inside = (f >= KNOWN[0, 0]) & (f <= KNOWN[-1, 0])
    line = np.interp(np.log(np.maximum(f, 1e-9)), np.log(KNOWN[:, 0]), np.log(KNOWN[:, 1]))
    return np.where(inside, np.exp(line), 0.0)


def noise(seconds, seed=0):
    """Gaussian noise of the known spectrum: a sum of lines with random amplitudes [g]."""
    count = int(seconds * RATE)
    f = np.fft.rfftfreq(count, 1 / RATE)
    rng = np.random.default_rng(seed)
    lines = rng.standard_normal((2, len(f)))
    amplitude = np.sqrt(density(f) * RATE * count / 2 / 2)
    return np.fft.irfft(amplitude * (lines[0] + 1j * lines[1]), count)


@pytest.fixture(scope="module")
def floor(tmp_path_factory):
    file = tmp_path_factory.mktemp("record") / "floor.csv"
    values = noise(300.0)
    t = np.arange(len(values)) / RATE
    rows = np.column_stack([t, values + 1.0])
    np.savetxt(file, rows, delimiter=",", header="time [s],z [g]", comments="", fmt="%.8g")
    return file


def decibels(a, b):
    return 10 * np.log10(a / b)


def test_measured_to_specified_in_one_command(floor, tmp_path, capsys):
    table = tmp_path / "floor.toml"
    with pytest.raises(SystemExit) as caught:
        main([
            "vibration", "--record", str(floor), "--to-table", str(table), "--json",
            "--out", str(tmp_path / "out"),
        ])  # fmt: skip
    assert caught.value.code in (0, None)
    said = json.loads(capsys.readouterr().out)
    (axis,) = said["axes"]
    level = np.sqrt(np.trapezoid(density(f := np.linspace(1, 500, 100_000)), f))
    assert axis["rms"] == pytest.approx(G * level, rel=0.02)
    assert axis["kurtosis"] == pytest.approx(3.0, abs=0.1)
    assert axis["crest_factor"] == pytest.approx(axis["peak"] / axis["rms"])
    assert "mean of z 9.8" in said["notes"][-1]  # gravity, removed and said
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "spectrum.png", "spectrum.svg", "summary.json"
    }  # fmt: skip
    standard = read_table(table)["z"]
    inside = np.geomspace(8, 350, 200)
    envelope = standard.spectrum.density(inside) / G**2
    assert np.max(np.abs(decibels(envelope, density(inside)))) < CLOSE_DB

    step = 2.5e-4
    values = realise(ShapedNoise(standard), 1, 400.0, step, seed=1)
    estimate = estimate_spectrum(values, step, 4.0)
    f = estimate.frequencies
    kept = (f > 10) & (f < 350)
    realised = estimate.densities[kept, 0] / G**2
    assert np.max(np.abs(decibels(realised, density(f[kept])))) < WITHIN_DB + 1.0
    banded = [decibels(a.mean(), b.mean()) for a, b in zip(
        np.array_split(realised, 20), np.array_split(density(f[kept]), 20), strict=True
    )]  # fmt: skip
    assert np.max(np.abs(banded)) < WITHIN_DB


def test_a_tone_has_the_crest_factor_and_kurtosis_of_a_sine():
    t = np.arange(20_000) / 1000.0
    found = measured_vibration(Record(1e-3, np.sin(2 * np.pi * 50 * t)[:, None]))
    assert found.crest_factor[0] == pytest.approx(np.sqrt(2), rel=1e-3)
    assert found.kurtosis[0] == pytest.approx(1.5, rel=1e-3)


def test_the_limit_covers_as_often_as_it_says():
    # White noise: of all bands' upper limits some 95 % lie above the true density.
    above = []
    for seed in range(10):
        values = np.random.default_rng(seed).standard_normal((20_000, 1))
        (envelope,) = measured_vibration(Record(1e-3, values), 0.95).envelopes
        above += (envelope.densities > 2e-3).tolist()
    assert np.mean(above) > 0.85  # the points kept are the extreme ones


def test_too_short_and_constant_records():
    with pytest.raises(ParameterError, match="60 samples, expected 64 or more"):
        measured_vibration(Record(1e-3, np.ones((60, 1))))
    with pytest.raises(ParameterError, match="axis 1 of the record: constant"):
        measured_vibration(Record(1e-3, np.zeros((1000, 1))))
