"""Acceleration spectra as standards state them: break points joined by straight lines in log-log.

A spectrum is that of one axis, one-sided, per hertz. Densities are in (m/s^2)^2/Hz within the
package; most standards print them in g^2/Hz.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.special import exprel

from ftcfa.arrays import Array
from ftcfa.checks import numbers, positive
from ftcfa.errors import ParameterError

STANDARD_GRAVITY = 9.80665
"""g0 of the unit g [m/s^2]."""
PLAUSIBLE_G_RMS = 60.0
"""Overall level above which a table counts as one in the wrong unit [g]. The qualification levels
of launcher equipment are lower. A table in the wrong unit whose level is still lower is not
noticed: state ``nominal_g_rms`` in it."""
SAMPLES_PER_PERIOD = 8
"""Smallest number of integration steps in the shortest period of a band."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided power spectral density of an acceleration, by break points.

        S(f) = S_i (f/f_i)^b_i,   b_i = log(S_{i+1}/S_i) / log(f_{i+1}/f_i),   f_i <= f <= f_{i+1}

    and zero outside the band.

    Attributes:
        frequencies: f_i, rising, shape (k,), k >= 2 [Hz].
        densities: S_i, shape (k,) [(m/s^2)^2/Hz].

    Raises:
        ParameterError: If frequencies or densities are not positive and finite, or the
            frequencies do not rise.
    """

    frequencies: Array
    densities: Array

    def __post_init__(self) -> None:
        for name in ("frequencies", "densities"):
            values = numbers(f"Spectrum {name}", getattr(self, name), field=name)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        _check_points(self.frequencies, self.densities)

    @classmethod
    def from_g(
        cls,
        frequencies: npt.ArrayLike,
        g2_per_hz: npt.ArrayLike,
        plausible_g_rms: float = PLAUSIBLE_G_RMS,
    ) -> "Spectrum":
        """Spectrum from densities in g^2/Hz, as standards print them.

        Args:
            frequencies: f_i, shape (k,) [Hz].
            g2_per_hz: S_i, shape (k,) [g^2/Hz].
            plausible_g_rms: Overall level above which the densities are refused, as they are
                probably not in g^2/Hz [g].

        Raises:
            ParameterError: For the reasons of the class, or if the level is not plausible.
        """
        positive("Spectrum plausible_g_rms", plausible_g_rms, "g", field="plausible_g_rms")
        f = numbers("Spectrum frequencies", frequencies, field="frequencies")
        S = numbers("Spectrum densities", g2_per_hz, field="g2_per_hz")
        _check_points(f, S, "g2_per_hz")  # in the unit that the user sees
        spectrum = cls(f, S * STANDARD_GRAVITY**2)
        level = spectrum.g_rms()
        if level > plausible_g_rms:
            raise ParameterError(
                "Spectrum densities",
                f"{level:.4g} g rms overall when read as g^2/Hz",
                f"at most {plausible_g_rms:g} g rms",
                "if they are in (m/s^2)^2/Hz, build Spectrum(frequencies, densities) or state "
                'unit = "(m/s^2)^2/Hz" in a table; if the level is meant, give '
                f"plausible_g_rms = {10 ** math.ceil(math.log10(level)):g}",
                field="g2_per_hz",
            )
        return spectrum

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]."""
        return float(self.frequencies[0]), float(self.frequencies[-1])

    def density(self, f: npt.ArrayLike) -> Array:
        """S(f), zero outside the band, shape of f [(m/s^2)^2/Hz]."""
        x = np.asarray(f, dtype=float)
        inside = (x >= self.frequencies[0]) & (x <= self.frequencies[-1])
        log_f = np.log(np.where(inside, x, self.frequencies[0]))
        line = np.interp(log_f, np.log(self.frequencies), np.log(self.densities))
        return np.where(inside, np.exp(line), 0.0)

    def power(self, f: npt.ArrayLike) -> Array:
        """Integral of S from the lowest frequency up to f, exact, shape of f [(m/s^2)^2].

        On the segment from f_i, with L = log(f/f_i) and a = b_i + 1:

            integral of S from f_i to f = S_i f_i (e^(a L) - 1)/a
        """
        x = np.clip(np.asarray(f, dtype=float), *self.band)
        a, below = self._segments
        i = np.clip(np.searchsorted(self.frequencies, x, side="right") - 1, 0, len(a) - 1)
        L = np.log(x / self.frequencies[i])
        return below[i] + (self.frequencies * self.densities)[i] * L * exprel(a[i] * L)

    def rms(self) -> float:
        """Root of the integral of S over the band, exact for straight lines in log-log [m/s^2]."""
        return math.sqrt(float(self.power(self.frequencies[-1])))

    def g_rms(self) -> float:
        """Overall level `rms` in the unit of the standards [g]."""
        return self.rms() / STANDARD_GRAVITY

    def scaled(self, factor: float) -> "Spectrum":
        """Spectrum of the acceleration times a factor: densities times the square of the factor."""
        positive("Spectrum factor", factor)
        return Spectrum(self.frequencies, self.densities * factor**2)

    def __str__(self) -> str:
        low, high = self.band
        return f"{self.g_rms():.3g} g rms from {low:g} to {high:g} Hz"

    @cached_property
    def _segments(self) -> tuple[Array, Array]:
        """a_i = b_i + 1 of each segment, (k - 1,), and the power below each f_i, (k,)."""
        L = np.diff(np.log(self.frequencies))
        a = np.diff(np.log(self.densities)) / L + 1.0
        powers = (self.frequencies * self.densities)[:-1] * L * exprel(a * L)
        return a, np.concatenate([[0.0], np.cumsum(powers)])


def step_limit(highest: float) -> float:
    """Largest integration step for frequencies up to the highest [Hz]: 1/(8 f_max) [s].

    Eight steps in a period keep the phase of a sampled force within 1/16 of the shortest period.
    """
    return 1.0 / (SAMPLES_PER_PERIOD * highest)


def substeps_needed(highest: float, period: float) -> int:
    """Smallest number of integration steps in a period [s] for frequencies up to the highest."""
    positive("period", period, "s")
    return math.ceil(period / step_limit(highest) * (1.0 - 1e-12))  # 0.25 ms of 1 ms is 4


def check_step(highest: float, step: float) -> None:
    """Refuse an integration step [s] that is too long for frequencies up to the highest [Hz].

    Raises:
        ParameterError: Naming the highest frequency, the step and the substeps needed.
    """
    needed = substeps_needed(highest, step)
    if needed > 1:
        raise ParameterError(
            "integration step",
            f"{1e3 * step:.4g} ms, for frequencies up to {highest:g} Hz",
            f"at most {1e3 * step_limit(highest):.4g} ms "
            f"({SAMPLES_PER_PERIOD} steps in the shortest period)",
            f"take substeps={needed} of the period {1e3 * step:.4g} ms, or a shorter period",
        )


def _check_points(f: Array, S: Array, field: str = "densities") -> None:
    """Refuse break points that make no spectrum; ``field`` holds the densities."""
    if f.ndim != 1 or f.shape != S.shape or len(f) < 2:
        got = f"frequencies of shape {f.shape}, densities of shape {S.shape}"
        expected = "two break points or more, one density for each frequency"
        remedy = "a single tone is a harmonic excitation, not a spectrum" if f.size == 1 else ""
        raise ParameterError("Spectrum", got, expected, remedy)
    for name, values, expected, key, remedy in (
        ("frequency", f, "a number > 0 Hz", "frequencies", _NO_ZERO),
        ("density", S, "a number > 0", field, _NO_SILENCE),
    ):
        bad = np.flatnonzero(~(np.isfinite(values) & (values > 0)))
        if bad.size:
            subject, got = f"Spectrum {name} {bad[0] + 1}", f"{values[bad[0]]:g}"
            raise ParameterError(subject, got, expected, remedy, field=key)
    falls = np.flatnonzero(np.diff(f) <= 0)
    if falls.size:
        k = falls[0]
        duplicate = f[k] == f[k + 1]
        raise ParameterError(
            f"Spectrum frequencies {k + 1} and {k + 2}",
            f"{f[k]:g} then {f[k + 1]:g} Hz" + (" (duplicate)" if duplicate else ""),
            "rising frequencies",
            "part the two sides of a step by a small difference" if duplicate else "sort them",
            field="frequencies",
        )


_NO_ZERO = "the logarithmic axis has no zero; begin the band above it"
_NO_SILENCE = (
    "outside the band the density is zero anyway: leave such points out; or check the sign: a "
    "density is a square"
)
