"""Records: reading what sensors write, refusing what is no even record, detrending."""

import numpy as np
import pytest

from ftcfa.errors import ParameterError, ShapeError, UnknownNameError
from ftcfa.vibration.records.record import Record, read_record

G = 9.80665


@pytest.fixture
def csv(tmp_path):
    def write(text, name="run.csv"):
        file = tmp_path / name
        file.write_text(text, encoding="utf-8")
        return file

    return write


def rows(times, values):
    return "".join(f"{t:.6f},{v}\n" for t, v in zip(times, values, strict=True))


def test_a_csv_with_units_in_its_header(csv):
    record = read_record(csv("time [s], x [g], y [g]\n0.000,1,2\n0.001,3,4\n0.002,5,6\n"))
    assert record.step == pytest.approx(1e-3)
    assert record.axes == ("x", "y")
    np.testing.assert_allclose(record.values, G * np.array([[1, 2], [3, 4], [5, 6]]))
    assert str(record) == "3 samples of 2 axes at 1 ms; run.csv"


@pytest.mark.parametrize("unit", ["m/s^2", "m/s2", "m/s²", "m/s**2"])
def test_si_in_its_spellings(csv, unit):
    record = read_record(csv(f"t [s];a ({unit})\n0;1\n0.5;2\n"))
    np.testing.assert_array_equal(record.values, [[1.0], [2.0]])


def test_an_argument_fills_gaps_and_does_not_go_against_the_header(csv):
    record = read_record(csv("time [s],x,y [g]\n0,1,2\n0.5,2,3\n"), unit=("m/s^2", "g"))
    np.testing.assert_allclose(record.values, [[1.0, 2 * G], [2.0, 3 * G]])
    with pytest.raises(ParameterError, match=r"unit of x: mg in the file, expected g; leave unit"):
        read_record(csv("time [s],x [mg]\n0,1\n0.5,2\n"), unit="g")


SIX = (
    "time [s], x [m/s^2], y [g], z [m/s2], roll [rad/s^2], pitch (deg/s²), yaw [rad/s**2]\n"
    "0.0,1,2,3,4,180,6\n0.1,1,2,3,4,-90,6\n"
)


def test_six_axes_with_a_unit_each(csv):
    record = read_record(csv(SIX))
    assert record.axes == ("x", "y", "z", "roll", "pitch", "yaw")
    exact = [[1, 2 * G, 3, 4, np.pi, 6], [1, 2 * G, 3, 4, -np.pi / 2, 6]]
    np.testing.assert_allclose(record.values, exact, rtol=1e-15)
    turned = read_record(csv(SIX), columns=("pitch", "y"))
    np.testing.assert_allclose(turned.values, [[np.pi, 2 * G], [-np.pi / 2, 2 * G]])


def test_a_unit_an_axis_by_argument(csv):
    file = csv("0,1,180\n0.1,2,90\n")
    record = read_record(file, unit=("g", "deg/s^2"), time_unit="s")
    np.testing.assert_allclose(record.values, [[G, np.pi], [2 * G, np.pi / 2]])
    with pytest.raises(ShapeError, match="unit: 3 units, expected one, or 2"):
        read_record(file, unit=("g", "g", "g"), time_unit="s")
    with pytest.raises(UnknownNameError, match="unit of axis 2 'degree': unknown name"):
        read_record(file, unit=("g", "degree"), time_unit="s")


def test_comments_blank_lines_and_no_header(csv):
    record = read_record(
        csv("# accelerometer 3\n\n0,1,2,4\n1,4,5,6\n"), unit="m/s^2", time_unit="s"
    )
    assert record.axes == ("x", "y", "z")
    assert record.values.shape == (2, 3)


def test_chosen_columns_in_their_order(csv):
    file = csv("time [s],x [g],y [g],z [g]\n0,1,2,3\n1,4,5,6\n")
    record = read_record(file, columns=("z", "x"))
    np.testing.assert_allclose(record.values, G * np.array([[3, 1], [6, 4]]))
    with pytest.raises(
        UnknownNameError, match=r"column 'w': unknown name, expected one of: time, x, y, z"
    ):
        read_record(file, columns=("w",))


def test_a_file_without_times(csv):
    record = read_record(csv("1,2\n3,4\n"), unit="g", step=0.01)
    assert record.step == 0.01
    assert record.values.shape == (2, 2)


def test_numpy_files(tmp_path):
    time, values = 0.25 * np.arange(4), np.arange(8.0).reshape(4, 2)
    np.save(tmp_path / "a.npy", np.column_stack([time, values]))
    np.savez(tmp_path / "a.npz", time=time, acceleration=values, unit="g")
    np.savez(tmp_path / "b.npz", acceleration=values[:, 0])
    one = read_record(tmp_path / "a.npy", unit="m/s^2")
    two = read_record(tmp_path / "a.npz")
    three = read_record(tmp_path / "b.npz", unit="g", step=0.25)
    assert one.step == two.step == three.step == 0.25
    np.testing.assert_array_equal(one.values, values)
    np.testing.assert_allclose(two.values, G * values)
    np.testing.assert_allclose(three.values, G * values[:, :1])


HEAD = "time [s],x [g]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "{file}: empty, expected a header and rows of numbers"),
        ("# nothing\n\n", "{file}: empty, expected a header and rows of numbers"),
        (HEAD, "{file}: no samples, expected two or more"),
        (HEAD + "0,1\n", "{file}: 1 samples, expected two or more"),
        (
            HEAD + "0,1\n1,2\n2,nan\n3,4\n",
            "{file}: row 4, column 2 (x): nan, expected a finite number; cut the record there",
        ),
        (HEAD + "0,1\n1,inf\n", "{file}: row 3, column 2 (x): inf, expected a finite number"),
        (HEAD + "0,1\n1,\n", "{file}: row 3, column 2 (x): nan, expected a finite number"),
        (HEAD + "0,1\n1,high\n", "{file}: row 3, column 2 (x): 'high', expected a number"),
        (HEAD + "0,1\n1,2,3\n", "{file}: row 3: 3 columns, expected 2 columns"),
        (
            HEAD + "0,1\n1,2\n2,3\n5,4\n6,5\n",
            "{file}: row 5: a gap of 3 s before it, where steps are 1 s, expected even time steps; "
            "cut the record there or fill the gap (resample=RATE interpolates)",
        ),
        (
            HEAD + "0,1\n2,2\n1,3\n3,4\n",
            "{file}: row 4: time 1 s after 2 s, expected times that rise; sort the record",
        ),
        (HEAD + "0,1\n1,2\n1,3\n2,4\n", "{file}: row 4: time 1 s after 1 s, expected times that"),
        (
            HEAD + "0,1\n1,2\n2.2,3\n3,4\n4,5\n",
            "{file}: row 4: a time step of 1.2 s, where the mean is 1 s, expected even time steps "
            "to 2 %; give resample=RATE to interpolate, or jitter= if the times are rounded",
        ),
        (
            "time [s],x\n0,1\n1,2\n",
            '{file}: unit of x: not stated, expected unit="g" or unit="m/s^2", or',
        ),
        ("time [s],x [g],y\n0,1,1\n1,2,2\n", "{file}: unit of y: not stated, expected unit="),
        (
            "time [s],x [lb]\n0,1\n1,2\n",
            "{file}: unit of x 'lb': unknown name, expected one of: m/s^2, mm/s^2, g, mg, gal",
        ),
        (
            "time,x [g]\n0,1\n1,2\n",
            "{file}: column of times 'time': no unit, expected s, ms, us or ns; write it in the",
        ),
        ("x [g]\n0\n1\n", "{file}: one column, expected times and one axis or more; name it"),
    ],
)
def test_a_bad_csv_names_file_and_row(csv, text, message):
    file = csv(text)
    with pytest.raises((ParameterError, UnknownNameError)) as refused:
        read_record(file)
    assert str(refused.value).startswith(message.format(file=file))


def test_rounded_times_are_no_gaps(csv):
    times = np.round(np.arange(200) / 1024.0, 6)
    record = read_record(csv(HEAD + rows(times, np.ones(200))))
    assert record.step == pytest.approx(1 / 1024.0, rel=1e-5)
    coarse = np.round(np.arange(200) / 800.0, 3)  # to 1 ms, of steps of 1.25 ms
    record = read_record(csv(HEAD + rows(coarse, np.ones(200))))
    assert record.step == pytest.approx(1 / 800.0, rel=1e-3)
    assert "times rounded to 0.001 s, read as even steps of 0.00125" in str(record)
    with pytest.raises(ParameterError, match=r"a gap of 0\.00\d s before it"):
        read_record(csv(HEAD + rows(np.delete(coarse, 100), np.ones(199))))


def test_other_bad_files(tmp_path):
    with pytest.raises(
        ParameterError, match=r"none.csv: no such file or directory, expected a rea"
    ):
        read_record(tmp_path / "none.csv")
    with pytest.raises(
        UnknownNameError, match=r"kind of file '.mat': unknown name, expected one of"
    ):
        read_record(tmp_path / "run.mat")
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ParameterError, match=r"bytes.csv: "):
        read_record(tmp_path / "bytes.csv")
    (tmp_path / "text.npy").write_text("no array")
    with pytest.raises(
        ParameterError, match=r"text.npy: .*, expected a NumPy array of real numbers"
    ):
        read_record(tmp_path / "text.npy")
    np.save(tmp_path / "words.npy", np.array(["a", "b"]))
    with pytest.raises(ParameterError, match=r"words.npy: an array of <U1, expected real numbers"):
        read_record(tmp_path / "words.npy")
    np.save(tmp_path / "flat.npy", np.zeros(5))
    with pytest.raises(ParameterError, match=r"flat.npy: one column, expected times and one axis"):
        read_record(tmp_path / "flat.npy", unit="g")
    np.savez(tmp_path / "a.npz", accel=np.zeros(5))
    with pytest.raises(ParameterError, match=r"arrays \[\], expected arrays time and accel"):
        read_record(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", time=np.zeros(4), acceleration=np.zeros(5))
    with pytest.raises(ParameterError, match=r"b.npz: shapes \(4, 1\), \(5, 1\), expected"):
        read_record(tmp_path / "b.npz")
    values = np.column_stack([np.arange(4.0), [1, 2, np.nan, 4]])
    np.save(tmp_path / "holes.npy", values)
    with pytest.raises(ParameterError, match=r"holes.npy: row 3, column 2: nan, expected a finite"):
        read_record(tmp_path / "holes.npy", unit="g")


def test_what_is_no_record_is_refused():
    with pytest.raises(
        ParameterError, match=r"Record values: shape \(1, 1\), expected \(samples, a"
    ):
        Record(0.1, np.zeros((1, 1)))
    with pytest.raises(
        ParameterError, match="Record values: nan in sample 2, axis 1, expected fini"
    ):
        Record(0.1, np.array([[0.0], [np.nan]]))
    with pytest.raises(ParameterError, match="Record step: 0, expected a number > 0"):
        Record(0, np.zeros((3, 1)))
    with pytest.raises(ParameterError, match=r"Record axes: \('x',\), expected 2 names"):
        Record(0.1, np.zeros((3, 2)), ("x",))


def test_detrending_takes_gravity_and_drift_away():
    t = np.arange(1000) * 0.01
    tones = np.column_stack([np.sin(2 * np.pi * 3 * t), np.cos(2 * np.pi * 5 * t)])
    drift = np.column_stack([9.81 + 0 * t, 1.0 + 0.3 * t])
    record = Record(0.01, tones + drift, ("z", "x"))
    line = record.detrended()
    assert np.abs(line.values - tones).max() < 0.06  # a sine over whole periods has a small trend
    (note,) = line.notes
    assert note.startswith("linear trend removed (mean of z 9.8")
    mean = record.detrended("constant")
    np.testing.assert_allclose(mean.values.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(mean.values[:, 0], tones[:, 0], atol=1e-12)
    with pytest.raises(ParameterError, match="Record detrend: 'cubic', expected"):
        record.detrended("cubic")
