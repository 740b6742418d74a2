"""Recorded accelerations: evenly sampled values, detrended and resampled."""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from ftcfa.arrays import Array, positive
from ftcfa.errors import ParameterError

LARGEST_FACTOR = 1000
"""Of up- and downsampling by polyphase filtering; beyond it a spline interpolates."""
RATIO_TOLERANCE = 1e-9
"""Relative difference of a ratio of steps from a fraction that counts as rounding."""
CUTOFF, CUTOFF_ORDER = 0.8, 8
"""Anti-alias filter before the spline: Butterworth, relative to the new Nyquist frequency."""


@dataclass(frozen=True, eq=False)
class Record:
    """An acceleration sampled at even steps.

    Attributes:
        step: h [s].
        values: Shape (samples, axes), two samples or more [m/s^2].
        axes: Names of the axes.
        notes: Where it comes from and what was done to it, in order.
    """

    step: float
    values: Array
    axes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        positive("Record step", self.step, "[s]")
        values = np.array(self.values, dtype=float)
        if values.ndim != 2 or len(values) < 2 or values.shape[1] == 0:
            raise ParameterError(
                "Record values", f"shape {values.shape}", "(samples, axes), two samples or more"
            )
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            sample, axis = bad[0]
            got = f"{values[sample, axis]} in sample {sample + 1}, axis {axis + 1}"
            raise ParameterError("Record values", got, "finite numbers")
        axes = self.axes or tuple(f"axis {k + 1}" for k in range(values.shape[1]))
        if len(axes) != values.shape[1]:
            raise ParameterError("Record axes", repr(axes), f"{values.shape[1]} names")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "axes", tuple(axes))

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.step * (len(self.values) - 1)

    def rms(self) -> Array:
        """Root mean square of each axis, shape (axes,) [m/s^2]."""
        return np.sqrt(np.mean(self.values**2, axis=0))

    def detrended(self, kind: Literal["linear", "constant"] = "linear") -> "Record":
        """Without its straight line or its mean (scipy.signal.detrend): gravity, sensor drift."""
        if kind not in ("linear", "constant"):
            raise ParameterError("Record detrend", repr(kind), '"linear" or "constant"')
        removed = {"linear": "linear trend removed", "constant": "mean removed"}[kind]
        values = signal.detrend(self.values, axis=0, type=kind)
        return replace(self, values=values, notes=(*self.notes, removed))

    def resampled(self, step: float) -> "Record":
        """At another step, without aliasing.

        Where the ratio of the steps is a fraction of integers up to 1000, by polyphase filtering
        (scipy.signal.resample_poly); otherwise by a cubic spline, after a zero-phase Butterworth
        low-pass at 0.8 of the new Nyquist frequency if that is the lower one. The notes say which.

        Args:
            step: The new h [s].

        Raises:
            ParameterError: If the step leaves fewer than two samples.
        """
        positive("Record step", step, "[s]")
        if step > self.duration:
            raise ParameterError(
                "Record step", f"{step:g} s", f"at most the record's length, {self.duration:g} s"
            )
        if step == self.step:
            return self
        ratio = self.step / step
        fraction = Fraction(ratio).limit_denominator(LARGEST_FACTOR)
        exact = fraction > 0 and abs(float(fraction) / ratio - 1.0) <= RATIO_TOLERANCE
        if exact and fraction.numerator <= LARGEST_FACTOR:
            up, down = fraction.numerator, fraction.denominator
            values = signal.resample_poly(self.values, up, down, axis=0, padtype="line")
            count = int(self.duration / step * (1.0 + RATIO_TOLERANCE)) + 1
            values, how = values[:count], f"polyphase filter {up}/{down}"
        else:
            values, how = self._by_spline(step)
        note = f"resampled from {1e3 * self.step:g} ms to {1e3 * step:g} ms ({how})"
        return replace(self, step=step, values=values, notes=(*self.notes, note))

    def _by_spline(self, step: float) -> tuple[Array, str]:
        values, how = self.values, "cubic spline"
        if step > self.step:
            low_pass = signal.butter(CUTOFF_ORDER, CUTOFF * self.step / step, output="sos")
            values = signal.sosfiltfilt(low_pass, values, axis=0)
            how = f"low-pass at {CUTOFF / (2.0 * step):.4g} Hz, cubic spline"
        old = self.step * np.arange(len(values))
        new = step * np.arange(int(self.duration / step * (1.0 + RATIO_TOLERANCE)) + 1)
        return CubicSpline(old, values)(np.minimum(new, old[-1])), how

    def __str__(self) -> str:
        count, axes = self.values.shape
        text = f"{count} samples of {axes} axes at {1e3 * self.step:g} ms"
        return "; ".join([text, *self.notes])
