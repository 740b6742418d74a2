"""Records of accelerometers as excitations; each path begins at a moment of its own."""

import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np
from scipy import signal

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, of_type, positive
from ftcfa.errors import ParameterError
from ftcfa.vibration.excitation import Excitation, Process, check_channels
from ftcfa.vibration.records.record import Record
from ftcfa.vibration.spectra.spectrum import SAMPLES_PER_PERIOD, substeps_needed

GRID = 2.0**-30
"""Grid of the means of a record, as a share of the next power of two of the largest: 180 dB below
it."""
UNRESOLVED = 0.01
"""Share of a record's power that may lie above what the integration step resolves."""
SWING = 0.5
"""Largest U, the second integral of a record, that may turn a base; more is drift [rad]."""


A_RECORD = "a Record; read_record(file) reads one; Record(step, values) holds values of your own"


@dataclass(frozen=True, eq=False)
class RecordedAcceleration(Excitation):
    """A record, detrended and repeated without end.

    Attributes:
        record: From `read_record`, or values of your own in a `Record`; one axis for each channel.
        random_start: Whether each path begins at a step of its own, keyed by (seed, path).
        high_pass: Frequency f_c below which the repeated record is damped, without delay, by
            f^4/(f^4 + f_c^4), a Butterworth filter of second order run forwards and backwards;
            None damps nothing. A base that turns needs it where a gyroscope drifts [Hz].

    Raises:
        ParameterError: If ``record`` is no `Record`, or does not resolve ``high_pass``.
    """

    record: Annotated[Record, Check(of_type(Record, A_RECORD))]
    random_start: bool = True
    high_pass: Annotated[float | None, Check(positive, "Hz")] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.high_pass is not None:
            low, high = 1.0 / self._period, 0.5 / self.record.step
            if not low <= self.high_pass < high:
                raise ParameterError(
                    "RecordedAcceleration high_pass",
                    f"{self.high_pass:g} Hz",
                    f"at least {low:.4g} Hz, a period of it in the record, and below {high:.4g} Hz",
                    field="high_pass",
                )

    @property
    def _period(self) -> float:
        """Time after which the record repeats [s]."""
        return self.record.step * len(self.record.values)

    def process(self, channels: int, step: float) -> "TabulatedProcess":
        """See `Excitation.process`; the last sample is followed by the first.

        The repeated record is the sum of its Fourier series, which has nothing above half of its
        own sampling rate, and the series is integrated over each step exactly: a tone of f Hz keeps
        its amplitude but for the factor sinc(f h) of a mean over a step. A tone above 1/(2 h), the
        step's own Nyquist frequency, folds back, damped by that factor: with steps of 1 ms one of
        700 Hz acts as one of 300 Hz, with 0.37 of its amplitude.

        The record is played faster or slower by at most half a step over its length, so that it
        repeats after a whole number of steps.

        Raises:
            ParameterError: If the record is shorter than a step.

        Warns:
            UserWarning: If more than 1 % of an axis's power has fewer than 8 steps in a period; it
                also says how much lies above the step's own Nyquist frequency.
        """
        axes = self.record.values.shape[1]
        check_channels("RecordedAcceleration", axes, channels, word="axes")
        steps = round(self._period / step)
        if steps == 0:
            expected = f"at most the record's length, {self._period:g} s"
            raise ParameterError("integration step", f"{step:g} s", expected)
        record = self.record.detrended()
        if self.high_pass is not None:
            record = replace(record, values=_high_passed(record, self.high_pass))
        _check_resolved(record, step)
        means = _means_over_steps(record.values, steps)
        return TabulatedProcess(step * means, step, self.random_start)


@dataclass(frozen=True, eq=False)
class TabulatedProcess(Process):
    """Integrals Y of xi over steps, read from rows.

    A row holds Y, and W and U at its start, shape (3 m,). All have mean zero over the table, or
    the integrals of the repeated table would drift:

        W_{k+1} = W_k + Y_k,   U_{k+1} = U_k + h (W_k + Y_k/2)

    Attributes:
        increments: Y, shape (R, m); its mean is removed.
        step: h [s].
        random: Whether each path begins at a row of its own.
    """

    increments: Array
    step: float
    random: bool

    normals = 0

    @property
    def random_start(self) -> bool:
        """See `Process.random_start`."""
        return self.random

    @cached_property
    def rows(self) -> Array:
        """Y, W and U side by side, shape (R, 3 m)."""
        Y = self.increments - self.increments.mean(axis=0)
        W = _sums_before(Y)
        U = _sums_before(self.step * (W + Y / 2.0))
        return np.hstack([Y, W, U])

    @property
    def channels(self) -> int:
        """Number m of channels."""
        return int(self.increments.shape[1])

    def advance(
        self, state: tuple[()], normals: Traceable, row: Traceable
    ) -> tuple[Traceable, tuple[()]]:
        """See `Process.advance`."""
        return row[: self.channels], state

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`: a drift that would turn a base too far."""
        swing = np.abs(self.rows[:, 2 * self.channels + channel]).max()
        return "" if swing <= SWING else f"a record that turns the base by up to {swing:.3g} rad"

    def integrals(self, state: tuple[()], row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        m = self.channels
        return row[m : 2 * m], row[2 * m :]


def _means_over_steps(values: Array, steps: int) -> Array:
    """Means of a repeated record's Fourier series over steps that divide its period evenly.

        x(t) = sum_m w_m Re{ c_m exp(2 pi i m t/T) },   m = 0 .. N/2

    with c_m the lines of the discrete Fourier transform over N, w_m = 1 for the mean and for
    m = N/2, which has no sine, else 2. The mean of a line over the step from k T/K on is its value
    in the step's middle times sinc(m/K). The means are rounded to GRID, because the last digits of
    a Fourier transform depend on the processor.

    Args:
        values: Samples of one period, shape (N, axes).
        steps: K.

    Returns:
        The means, shape (K, axes).
    """
    count = len(values)
    lines = np.fft.rfft(values, axis=0) / count
    m = np.arange(len(lines))
    weight = np.where((m == 0) | (2 * m == count), 1.0, 2.0)
    gain = weight * np.sinc(m / steps) * np.exp(1j * np.pi * m / steps)
    folded = np.zeros((steps, values.shape[1]), dtype=complex)
    np.add.at(folded, m % steps, gain[:, None] * lines)
    means = np.real(np.fft.ifft(folded, axis=0)) * steps
    _, exponents = np.frexp(np.abs(means).max(axis=0))
    grid = np.ldexp(GRID, exponents)
    return np.round(means / grid) * grid


def _high_passed(record: Record, frequency: float) -> Array:
    """The repeated record, damped below a frequency [Hz], shape (samples, axes)."""
    count = len(record.values)
    ratio = np.fft.rfftfreq(count, record.step) / frequency
    gain = ratio**4 / (ratio**4 + 1.0)
    lines = np.fft.rfft(record.values, axis=0)
    return np.fft.irfft(lines * gain[:, None], count, axis=0)


def _sums_before(x: Array) -> Array:
    """Sums of the rows above each row, less their mean, shape of x."""
    sums = np.cumsum(x, axis=0) - x
    return sums - sums.mean(axis=0)


def _check_resolved(record: Record, step: float) -> None:
    """Warn if the step is too long for more than `UNRESOLVED` of a record's power."""
    f, S = signal.periodogram(record.values, 1.0 / record.step, "hann", detrend=False, axis=0)
    powers = np.cumsum(S, axis=0)
    above = 1.0 - powers / np.where(powers[-1] > 0, powers[-1], 1.0)  # share above f, (F, axes)
    limit = 1.0 / (SAMPLES_PER_PERIOD * step)
    shares = above[np.searchsorted(f, limit, "right") - 1] * (powers[-1] > 0)
    if shares.max() <= UNRESOLVED:
        return
    axis = int(np.argmax(shares))
    highest = f[np.argmax(np.all((above <= UNRESOLVED) | (powers[-1] == 0), axis=1))]
    needed = substeps_needed(float(highest), step)
    nyquist = 0.5 / step
    beyond = (above[np.searchsorted(f, nyquist, "right") - 1] * (powers[-1] > 0))[axis]
    folds = (
        f" ({100 * beyond:.3g} % above {nyquist:.4g} Hz, which folds back)" if beyond > 0 else ""
    )
    warnings.warn(
        f"integration step: {1e3 * step:.4g} ms, where {100 * shares[axis]:.0f} % of the power of "
        f"the record's {record.axes[axis]} lies above {limit:.4g} Hz, with fewer than "
        f"{SAMPLES_PER_PERIOD} steps in a period{folds}; take substeps={needed} of the period "
        f"{1e3 * step:.4g} ms, or a shorter period",
        stacklevel=3,
    )
