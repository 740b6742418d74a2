"""Records as loggers and spreadsheets write them."""

import gc
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ftcfa.errors import FtcfaError, ParameterError, UnknownNameError
from ftcfa.files import read_bounded
from ftcfa.vibration.records import array_file
from ftcfa.vibration.records.record import read_record

G = 9.80665
N = 40
X = 0.3 * np.sin(np.arange(N) * 0.3)


def table(head, *columns, separator=",", decimal="."):
    lines = [
        separator.join(str(x).replace(".", decimal) for x in cells)
        for cells in zip(*columns, strict=True)
    ]
    return "\n".join([head, *lines]) + "\n"


@pytest.fixture
def write(tmp_path):
    def write(content, name="run.csv"):
        file = tmp_path / name
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return file

    return write


MS = np.arange(N) * 10
S = [f"{t:.2f}" for t in MS / 1000]
DATES = [f"2025-01-02T10:00:00.{t:03d}Z" for t in MS]
EPOCH = [1_760_000_000_000 + int(t) for t in MS]
COUNT = range(N)
SAME = {
    "milliseconds by name": table("time_ms,x [g]", MS, X),
    "milliseconds in brackets": table("t [ms],x [g]", MS, X),
    "microseconds": table("timestamp (us),x [g]", MS * 1000, X),
    "nanoseconds": table("time [ns],x [g]", MS * 10**6, X),
    "epoch in milliseconds": table("timestamp [ms],x [g]", EPOCH, X),
    "ISO 8601": table("when,x [g]", DATES, X),
    "an index of pandas": table(",time [s],x [g]", COUNT, S, X),
    "a count": table("count,x [g],time [s]", COUNT, X, S),
    "a column of words": table("time [s],x [g],mode", S, X, ["idle"] * N),
    "semicolons and decimal commas": table("time [s];x [g]", S, X, separator=";", decimal=","),
    "tabs": table("time [s]\tx [g]", S, X, separator="\t"),
    "tabs and decimal commas": table("time [s]\tx [g]", S, X, separator="\t", decimal=","),
    "blanks": table("time_s x[g]", S, X, separator="  "),
    "a row of units": table("time,x\ns,g", S, X),
    "a row of units in brackets": table("time;x\n[s];[g]", S, X, separator=";"),
    "a quoted line break": table('"time\n[s]","x [g]"', S, X),
    "comments": "% made by hand\n// and more\n# and more\n" + table("time [s],x [g]", S, X),
    "Latin-1": table("time [s],x [g]", S, X).encode() + "# Gr\xf6\xdfe\n".encode("latin-1"),
    "UTF-16": table("time [s],x [g]", S, X).encode("utf-16"),
    "line ends of Windows": table("time [s],x [g]", S, X).replace("\n", "\r\n"),
    "quoted cells": table("time [s],x [g]", [f'"{t}"' for t in S], X),
}


@pytest.mark.parametrize("name", SAME)
def test_every_dialect_reads_as_the_same_record(write, name):
    columns = ("x",) if name == "a column of words" else None
    record = read_record(write(SAME[name]), columns=columns)
    assert record.step == pytest.approx(0.01, rel=1e-9)
    assert record.axes == ("x",)
    np.testing.assert_allclose(record.values[:, 0], G * X, rtol=1e-12)


def test_columns_that_are_left_out_are_said(write):
    file = write(table("count,x [g],time [s]", COUNT, X, S))
    assert "left out: count" in read_record(file).notes
    assert "left out: count, time" in read_record(file, rate=100.0).notes


@pytest.mark.parametrize("unit", ["mg", "mm/s^2", "m/s/s", "m/s²", "m s^-2", "gal", "G", "m·s⁻²"])
def test_units_of_acceleration(write, unit):
    size = {"mg": 1e-3 * G, "mm/s^2": 1e-3, "gal": 1e-2, "G": G}.get(unit, 1.0)
    record = read_record(write(table(f"time [s],x [{unit}]", S, X)))
    np.testing.assert_allclose(record.values[:, 0], size * X, rtol=1e-12)


REFUSED = {
    "no unit of time": (table("time,x [g]", S, X), "column of times 'time': no unit"),
    "a count is no time": (table("count,x [g]", COUNT, X), "no column of times"),
    "an index is no time": (table(",x [g]", COUNT, X), "no column of times"),
    "numbers of columns": (table("0,1", S, X), "the first row is 0, 1, expected a header or"),
    "an underscore": (table("time [s],x [g]", S, ["1_05"] * N), "'1_05', expected a number"),
    "digits of another script": (table("time [s],x [g]", S, ["\uff11"] * N), "expected a number"),
    "an open quote": (table("time [s],x [g]", S, X) + '9,"1\n', ""),
    "a null byte": (b"time [s],x [g]\n0,1\n\x00,2\n", ""),
    "times that are words": (table("time [s],x [g]", ["True", "False"] * 20, X), "a number"),
    "a wrong date": (table("when,x [g]", [*DATES[:-1], "later"], X), "a time of ISO 8601"),
    "a date that is none": (table("when,x [g]", ["2025-99-99", *DATES[1:]], X), "ISO 8601"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_would_be_a_guess_is_refused(write, name):
    content, message = REFUSED[name]
    with pytest.raises(FtcfaError) as caught:
        read_record(write(content))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_arguments_fill_what_the_file_does_not_say(write):
    file = write("exported 2025\nby a logger\n" + table("x,y", X, X))
    record = read_record(file, unit="g", rate=100.0, skip=2)
    assert (record.step, record.axes) == (0.01, ("x", "y"))
    file = write(table("time,x [g]", MS, X))
    assert read_record(file, time_unit="ms").step == pytest.approx(0.01)
    with pytest.raises(ParameterError, match="step and rate"):
        read_record(file, rate=1.0, step=1.0)
    with pytest.raises(ParameterError, match="unit ms, expected time_unit s"):
        read_record(write(table("time [ms],x [g]", MS, X)), time_unit="s")
    with pytest.raises(UnknownNameError):
        read_record(write(table("time,x [g]", S, X)), time_unit="h")


def test_a_rate_must_not_contradict_the_times(write):
    file = write(table("time [ms],x [g]", MS, X))
    assert read_record(file, rate=100.5).step == pytest.approx(1 / 100.5)
    with pytest.raises(ParameterError, match=r"steps of 0[.]01 s on average, expected .* 0[.]05 s"):
        read_record(file, rate=20.0)
    assert read_record(write(table("time,x [g]", MS, X)), rate=20.0).step == 0.05  # no unit


def test_uneven_times_are_interpolated_on_request(write):
    rng = np.random.default_rng(0)
    times = np.sort(rng.uniform(0, 10, 4000))
    file = write(table("time [s],x [g]", times, np.sin(times)))
    with pytest.raises(ParameterError, match="resample=RATE"):
        read_record(file, jitter=0.5)
    record = read_record(file, resample=100.0)
    even = times[0] + 0.01 * np.arange(len(record.values))
    assert np.max(np.abs(record.values[:, 0] / G - np.sin(even))) < 1e-3
    assert "interpolated linearly to 100 Hz" in record.notes


def test_angles_rates_and_displacements_become_accelerations(write):
    h, w = 0.01, 2 * np.pi * 2.0
    t = np.arange(400) * h
    wave = np.sin(w * t)
    head = "time [s],roll [deg],pitch [deg/s],heave [m],surge [mm/s]"
    file = write(table(head, t, wave, wave, wave, 1000 * wave))
    record = read_record(file)
    degree = np.pi / 180
    exact = np.column_stack([
        -degree * w**2 * wave, degree * w * np.cos(w * t), -(w**2) * wave, w * np.cos(w * t)
    ])  # fmt: skip
    inside = slice(9, -9)
    error = np.abs(record.values - exact)[inside].max(axis=0) / np.abs(exact).max(axis=0)
    assert error.max() < 2e-3
    note = "roll: second derivative by polynomials of degree 4 over 9 samples"
    assert note in record.notes


def test_a_million_rows(write):
    times = np.arange(10**6) * 1e-3
    buffer = io.StringIO("time [s],x [g],y [g],z [g]\n")
    buffer.seek(0, io.SEEK_END)
    np.savetxt(buffer, np.column_stack([times, times, times, times]), fmt="%.6g", delimiter=",")
    gc.collect()
    assert read_record(write(buffer.getvalue())).values.shape == (10**6, 3)


def npz(**members):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def test_an_archive_that_unpacks_to_more_than_the_limit(write, monkeypatch):
    monkeypatch.setattr(array_file, "MAX_BYTES", 10**6)
    with pytest.raises(ParameterError, match="8 MiB when unpacked"):
        read_record(write(npz(acceleration=npy(np.zeros(10**6))), "a.npz"))


def test_an_array_that_says_to_be_larger_than_it_is(write):
    content = npy(np.zeros((10, 2))).replace(b"(10, 2)", b"(10**9,2)"[:7])
    with pytest.raises(ParameterError, match=r"a\.npy: unreadable"):
        read_record(write(content, "a.npy"), unit="g")


@pytest.mark.parametrize("kept", [0.0, 0.01, 0.1, 0.5, 0.9, 0.99])
def test_truncated_files(write, kept):
    whole = npz(time=npy(np.arange(50.0)), acceleration=npy(np.zeros((50, 3))))
    for content, name in ((whole, "a.npz"), (npy(np.zeros((50, 2))), "a.npy")):
        with pytest.raises(FtcfaError) as caught:
            read_record(write(content[: int(kept * len(content))], name), unit="g")
        assert "\n" not in str(caught.value)


def test_an_endless_file_is_not_read_to_its_end():
    with pytest.raises(FtcfaError, match="more than 1 MiB, expected a file of at most 1 MiB"):
        read_bounded(Path("/dev/zero"), 2**20)
