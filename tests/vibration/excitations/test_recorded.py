"""Records in loops: exact integrals over any step, no folding back, drift, steps too long."""

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import quad

from ftcfa import ParameterError, Record, RecordedAcceleration
from ftcfa.vibration.excitations.recorded import GRID

from ..masses import run_process

SAMPLING = 8000.0
"""Of the records [Hz]."""


def record_of(tone, seconds=0.5):
    t = np.arange(round(seconds * SAMPLING)) / SAMPLING
    return Record(1 / SAMPLING, tone(t)[:, None])


def table(excitation, step):
    process = excitation.process(excitation.record.values.shape[1], step)
    return run_process(process, len(process.rows))


@pytest.mark.filterwarnings("ignore:integration step")
@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-3 / 3, 0.7e-3, 1e-3 / np.pi, 13e-3])
@pytest.mark.parametrize(
    ("sampling", "f"),
    [(r, f) for r in (100.0, 1600.0, 8000.0) for f in (6.0, 40.0, 350.0, 700.0) if f < r / 2],
)
def test_the_integrals_of_a_tone_are_exact(f, sampling, step):
    """But for the grid, up to half the record's rate; the tone may be above Nyquist's of the steps.

    The tone is even about the record's middle, so that no trend is taken from it.
    """
    count, w = round(0.5 * sampling), 2 * np.pi * f
    middle = (count - 1) / 2 / sampling
    record = Record(1 / sampling, np.cos(w * (np.arange(count) / sampling - middle))[:, None])
    Y, *_ = table(RecordedAcceleration(record), step)
    w_played = w * 0.5 / (len(Y) * step)  # it repeats after a whole number of steps
    ends = step * np.arange(len(Y) + 1)
    exact = np.diff(np.sin(w_played * ends - w * middle)) / w_played
    np.testing.assert_allclose(Y[:, 0], exact - exact.mean(), rtol=0, atol=1e-9 / w + GRID * step)


@pytest.mark.filterwarnings("error")
def test_a_record_near_its_nyquist_frequency_has_no_images():
    """40 Hz at 100 Hz, played at 1 ms: one line, of the full amplitude, and nothing else."""
    count = 500
    values = np.cos(2 * np.pi * 40 * (np.arange(count) - (count - 1) / 2) / 100)[:, None]
    Y, *_ = table(RecordedAcceleration(Record(0.01, values)), 1e-3)
    lines = 2 * np.abs(np.fft.rfft(Y[:, 0])) / len(Y) / 1e-3
    assert lines[200] == pytest.approx(np.sinc(0.04), rel=1e-9)
    assert np.max(np.delete(lines, 200)) < 1e-9


def test_power_above_the_steps_own_nyquist_frequency_is_named():
    """Of a tone of 700 Hz all; it folds back to 300 Hz with the amplitude sinc(0.7)."""
    record = record_of(lambda t: np.cos(2 * np.pi * 700 * t))
    with pytest.warns(UserWarning, match=r"\(100 % above 500 Hz, which folds back\)"):
        Y, *_ = table(RecordedAcceleration(record), 1e-3)
    lines = 2 * np.abs(np.fft.rfft(Y[:, 0])) / len(Y) / 1e-3
    assert np.argmax(lines) == 150
    assert lines[150] == pytest.approx(np.sinc(0.7), rel=1e-3)


def test_the_mean_over_a_step_is_a_sinc_smaller():
    """200 Hz at a millisecond: neither a low-pass nor a straight line takes anything besides."""
    with pytest.warns(UserWarning, match="100 % of the power"):
        Y, *_ = table(RecordedAcceleration(record_of(lambda t: np.sin(2 * np.pi * 200 * t))), 1e-3)
    rms = np.sqrt(np.mean(Y**2)) / 1e-3
    assert rms == pytest.approx(np.sqrt(0.5) * np.sinc(0.2), rel=1e-3)


def test_the_last_sample_is_followed_by_the_first():
    """A period between them: the integral over it by quadrature of a periodic tone."""
    count, h = 400, 1e-3
    w = 2 * np.pi * 5 / (count * h)
    values = np.cos(w * h * np.arange(count))[:, None]
    Y, *_ = table(RecordedAcceleration(Record(h, values)), h)
    assert len(Y) == count
    last = quad(lambda t: np.cos(w * t), (count - 1) * h, count * h)[0]
    assert Y[-1, 0] == pytest.approx(last, abs=1e-3 * h)


def test_power_above_what_the_step_resolves_warns():
    """A fifth of y's power is at 300 Hz, which takes three steps a millisecond."""
    t = np.arange(4000) / SAMPLING
    low, high = np.sin(2 * np.pi * 40 * t), np.sin(2 * np.pi * 300 * t)
    record = Record(1 / SAMPLING, np.column_stack([low, low + high / 2]), ("x", "y"))
    excitation = RecordedAcceleration(record)
    message = (
        r"integration step: 1 ms, where 20 % of the power of the record's y lies above 125 Hz, "
        r"with fewer than 8 steps in a period; take substeps=3 of the period 1 ms, or a shorter"
    )
    with pytest.warns(UserWarning, match=message):
        excitation.process(2, 1e-3)


@pytest.mark.filterwarnings("error")
def test_a_step_that_resolves_the_record_does_not_warn():
    noise = np.random.default_rng(0).standard_normal((8000, 1))
    sections = signal.butter(6, 80.0, fs=SAMPLING, output="sos")
    record = Record(1 / SAMPLING, signal.sosfilt(sections, noise, axis=0))
    RecordedAcceleration(record).process(1, 1e-3)
    RecordedAcceleration(Record(0.1, np.zeros((10, 2)))).process(2, 0.1)


def test_a_high_pass_damps_as_butterworth_there_and_back():
    """Of two tones in the record, one at the filter's frequency and one above it."""
    tones = record_of(lambda t: np.sin(2 * np.pi * 10 * t) + np.sin(2 * np.pi * 40 * t), 2.0)
    Y, *_ = table(RecordedAcceleration(tones, high_pass=10.0), 1e-3)
    lines = np.abs(np.fft.rfft(Y[:, 0])) / 1000 / 1e-3
    response = signal.butter(2, 10.0, "highpass", analog=True, output="ba")
    for f in (10.0, 40.0):
        gain = abs(signal.freqs(*response, worN=[f])[1][0]) ** 2  # 10 Hz as 10 rad/s
        assert lines[round(2 * f)] == pytest.approx(gain * np.sinc(f * 1e-3), rel=0.02)


@pytest.mark.parametrize("high_pass", [0.0, 1.9, 4000.0, -1.0, "low"])
def test_a_high_pass_that_the_record_does_not_hold(high_pass):
    with pytest.raises(ParameterError, match=r"RecordedAcceleration high_pass: .*, expected a"):
        RecordedAcceleration(record_of(np.sin), high_pass=high_pass)


def test_a_step_longer_than_the_record():
    record = Record(0.1, np.arange(10.0)[:, None])
    message = r"integration step: 2 s, expected at most the record's length, 1 s"
    with pytest.raises(ParameterError, match=message):
        RecordedAcceleration(record).process(1, 2.0)
