"""Recorded accelerations: evenly sampled values."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy import signal

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.errors import ParameterError


@dataclass(frozen=True, eq=False)
class Record:
    """Linear or angular accelerations sampled at even steps.

    Attributes:
        step: h [s].
        values: Shape (samples, axes), two samples or more [m/s^2 or rad/s^2].
        axes: Names of the axes.
        notes: Where it comes from and what was done to it, in order.
    """

    step: float
    values: Array
    axes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        positive("Record step", self.step, "s")
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
        """Root mean square of each axis, shape (axes,) [m/s^2 or rad/s^2]."""
        return np.sqrt(np.mean(self.values**2, axis=0))

    def detrended(self, kind: Literal["linear", "constant"] = "linear") -> "Record":
        """Without its straight line or its mean (scipy.signal.detrend): gravity, sensor drift."""
        if kind not in ("linear", "constant"):
            raise ParameterError("Record detrend", repr(kind), '"linear" or "constant"')
        removed = {"linear": "linear trend removed", "constant": "mean removed"}[kind]
        values = signal.detrend(self.values, axis=0, type=kind)
        return replace(self, values=values, notes=(*self.notes, removed))

    def __str__(self) -> str:
        count, axes = self.values.shape
        text = f"{count} samples of {axes} axes at {1e3 * self.step:g} ms"
        return "; ".join([text, *self.notes])
