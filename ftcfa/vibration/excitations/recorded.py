"""An accelerometer's record as the excitation, each path from a moment of its own."""

import warnings
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields, positive
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.excitation import EACH, Excitation, Process
from ftcfa.vibration.record import Record
from ftcfa.vibration.spectra.spectrum import SAMPLES_PER_PERIOD, Spectrum, substeps_needed

UNRESOLVED = 0.01
"""Share of a record's power that may lie above what the integration step resolves."""
SWING = 0.5
"""Largest integral of the integral of a record that may turn a base: more is drift [rad]."""
ROUNDING = 1e-9
"""Of a whole number of steps in a record, relative."""


def check_record(subject: str, record: Any) -> None:
    """Raise ParameterError unless a record is a `Record`."""
    if not isinstance(record, Record):
        raise ParameterError(
            subject,
            f"a {type(record).__name__}",
            "a Record",
            "read_record(file) reads one; Record(step, values) holds values of your own",
        )


@dataclass(frozen=True, eq=False)
class RecordedAcceleration(Excitation):
    """A record, detrended and repeated without end.

    Attributes:
        record: From `read_record`, or values of your own in a `Record`; an axis a channel.
        random_start: Whether each path begins at a step of its own, keyed by (seed, path).
        high_pass: Frequency f_c below which the repeated record is damped, without delay, by
            f^4/(f^4 + f_c^4), Butterworth's of second order there and back; None damps nothing.
            The drift of a gyroscope needs it, or a base that it turns tips over [Hz].

    Raises:
        ParameterError: If the record is none, or the frequency not one that it holds.
    """

    record: Annotated[Record, Check(check_record)]
    random_start: bool = True
    high_pass: Annotated[float | None, Check(positive, "Hz")] = None

    def __post_init__(self) -> None:
        check_fields(self)
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

        The integrals are those of a periodic cubic spline, exact for any step: nothing folds back,
        and a tone's mean over a step is a sinc smaller as it should be.

        Raises:
            ParameterError: If the record is shorter than a step.

        Warns:
            UserWarning: If more than 1 % of an axis's power has fewer than 8 steps a period.
        """
        axes = self.record.values.shape[1]
        if axes != channels:
            raise ShapeError("RecordedAcceleration", f"{axes} axes", f"{channels} channels", EACH)
        period = self._period
        steps = int(period / step * (1.0 + ROUNDING))
        if steps == 0:
            expected = f"at most the record's length, {period:g} s"
            raise ParameterError("integration step", f"{step:g} s", expected)
        record = self.record.detrended()
        if self.high_pass is not None:
            record = replace(record, values=_high_passed(record, self.high_pass))
        _check_resolved(record, step)
        t = record.step * np.arange(len(record.values) + 1)
        closed = np.concatenate([record.values, record.values[:1]])
        integral = CubicSpline(t, closed, bc_type="periodic").antiderivative()
        ends = np.minimum(step * np.arange(steps + 1), period)
        return TabulatedProcess(np.diff(integral(ends), axis=0), step, self.random_start)


class TabulatedProcess(Process):
    """Integrals Y of xi over steps, read from rows.

    What repeats must have no mean, or its integral drifts; it is taken away. A row holds Y, and W
    and U at its start, all of mean zero over the table, shape (3 m,):

        W_{k+1} = W_k + Y_k,   U_{k+1} = U_k + h (W_k + Y_k/2)

    Args:
        integrals: Y, shape (R, m).
        step: h [s].
        random_start: Whether each path begins at a row of its own.
    """

    normals = 0

    def __init__(self, integrals: Array, step: float, random_start: bool) -> None:
        Y = integrals - integrals.mean(axis=0)
        W = _sums_before(Y)
        U = _sums_before(step * (W + Y / 2.0))
        self.rows = np.hstack([Y, W, U])
        self.random_start = random_start
        self.channels = Y.shape[1]
        self.swing = np.abs(U).max(axis=0)

    def advance(self, state: tuple[()], normals: Array, row: Array) -> tuple[Array, tuple[()]]:  # noqa: ARG002
        """See `Process.advance`."""
        return row[: self.channels], state

    def obstacle(self, channel: int) -> str:
        """See `Process.obstacle`: a drift that would turn a base far."""
        swing = self.swing[channel]
        return "" if swing <= SWING else f"a record that turns the base by up to {swing:.3g} rad"

    def integrals(self, state: tuple[()], row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """See `Process.integrals`."""
        m = self.channels
        return row[m : 2 * m], row[2 * m :]


def _high_passed(record: Record, frequency: float) -> Array:
    """The repeated record without what lies below a frequency [Hz], shape (samples, axes)."""
    count = len(record.values)
    ratio = np.fft.rfftfreq(count, record.step) / frequency
    gain = ratio**4 / (ratio**4 + 1.0)
    lines = np.fft.rfft(record.values, axis=0)
    return np.fft.irfft(lines * gain[:, None], count, axis=0)


def _sums_before(x: Array) -> Array:
    """Sums of the rows before each row, less their mean, shape of x."""
    sums = np.cumsum(x, axis=0) - x
    return sums - sums.mean(axis=0)


def _check_resolved(record: Record, step: float) -> None:
    """Warn of a step too long for a relevant share of a record's power."""
    f, S = signal.periodogram(record.values, 1.0 / record.step, "hann", detrend=False, axis=0)
    powers = np.cumsum(S, axis=0)
    above = 1.0 - powers / np.where(powers[-1] > 0, powers[-1], 1.0)  # share above f, (F, axes)
    limit = 1.0 / (SAMPLES_PER_PERIOD * step)
    shares = above[np.searchsorted(f, limit, "right") - 1] * (powers[-1] > 0)
    if shares.max() <= UNRESOLVED:
        return
    axis = int(np.argmax(shares))
    highest = f[np.argmax(np.all((above <= UNRESOLVED) | (powers[-1] == 0), axis=1))]
    needed = substeps_needed(Spectrum(np.array([0.5, 1.0]) * highest, np.ones(2)), step)
    warnings.warn(
        f"integration step: {1e3 * step:.4g} ms, where {100 * shares[axis]:.0f} % of the power of "
        f"the record's {record.axes[axis]} lies above {limit:.4g} Hz, with fewer than "
        f"{SAMPLES_PER_PERIOD} steps a period; take substeps={needed} of the period "
        f"{1e3 * step:.4g} ms, or a shorter period",
        stacklevel=3,
    )
