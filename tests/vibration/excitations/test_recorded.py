"""Records in loops: exact integrals over any step, no folding back, drift, steps too long."""

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import quad

from ftcfa import ParameterError, Record, RecordedAcceleration

from ..masses import run_process

SAMPLING = 8000.0
"""Of the records [Hz]."""
SPLINE = 1e-3
"""Error of a cubic spline with 11 samples a period or more, relative."""


def record_of(tone, seconds=0.5):
    t = np.arange(round(seconds * SAMPLING)) / SAMPLING
    return Record(1 / SAMPLING, tone(t)[:, None])


def table(excitation, step):
    process = excitation.process(excitation.record.values.shape[1], step)
    return run_process(process, len(process.rows))


@pytest.mark.filterwarnings("ignore:integration step")
@pytest.mark.parametrize("step", [1e-4, 1e-3, 1e-3 / 3, 0.7e-3, 1e-3 / np.pi])
@pytest.mark.parametrize("f", [30.0, 124.0, 200.0, 350.0, 700.0])
def test_the_integrals_of_a_tone_are_exact(f, step):
    """Over every step but the last, where the record begins anew; its tone may be above Nyquist's
    frequency of the steps."""
    record = record_of(lambda t: np.sin(2 * np.pi * f * t + 0.4))
    Y, *_ = table(RecordedAcceleration(record), step)
    w, ends = 2 * np.pi * f, step * np.arange(len(Y) + 1)
    slope, _ = np.polyfit(np.arange(4000) / SAMPLING, record.values[:, 0], 1)
    exact = np.diff(-np.cos(w * ends + 0.4) / w - slope * ends**2 / 2)
    exact -= exact.mean()
    np.testing.assert_allclose(Y[:-1, 0], exact[:-1], rtol=0, atol=SPLINE / w)


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
