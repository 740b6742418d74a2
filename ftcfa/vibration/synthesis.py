"""Synthesis by random phases: a spectrum as a sum of lines (Rice 1944, Shinozuka 1971)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import counting
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.spectra.spectrum import Spectrum

Spacing = Literal["uniform", "equal_power"]

NEAR = 1e-9
"""Share of the distance of lines by which an edge of the band may miss one, by rounding."""
BLOCK = 500_000
"""Cosines evaluated at a time: some megabytes."""


@dataclass(frozen=True, eq=False)
class SpectralLines:
    """A sum of lines; with phases independent and uniform on [0, 2 pi) it is stationary.

        y(t) = sum_k A_k cos(2 pi f_k t + phi_k),   variance sum_k A_k^2/2

    By the central limit theorem y(t) is close to Gaussian for many lines of like size; its peaks
    stay below sum_k A_k, and its average power over a period is the same for any phases.

    Attributes:
        frequencies: f_k, shape (N,) [Hz].
        amplitudes: A_k, shape (N,) [m/s^2].
        period: Time after which y repeats; inf where the frequencies have no common measure [s].
    """

    frequencies: Array
    amplitudes: Array
    period: float

    def __len__(self) -> int:
        return len(self.frequencies)

    def rms(self) -> float:
        """Root of the sum of A_k^2/2 [m/s^2]."""
        return float(np.sqrt(0.5 * np.sum(self.amplitudes**2)))

    def evaluate(self, t: npt.ArrayLike, phases: Array) -> Array:
        """y(t), shape of t.

        Args:
            t: Times [s].
            phases: phi_k, shape (N,) [rad].
        """
        return self._sum(np.asarray(t, dtype=float), phases, self.amplitudes)

    def integrate(self, start: npt.ArrayLike, step: float, phases: Array) -> Array:
        """Integral of y from t to t + h, exact, shape of t.

            integral = sum_k A_k h sinc(f_k h) cos(2 pi f_k (t + h/2) + phi_k)

        Args:
            start: Times t [s].
            step: h [s].
            phases: phi_k, shape (N,) [rad].
        """
        held = self.amplitudes * step * np.sinc(self.frequencies * step)
        return self._sum(np.asarray(start, dtype=float) + 0.5 * step, phases, held)

    def _sum(self, t: Array, phases: Array, amplitudes: Array) -> Array:
        """Sum of amplitude_k cos(2 pi f_k t + phi_k), shape of t."""
        phases = np.asarray(phases, dtype=float)
        if phases.shape != self.frequencies.shape:
            raise ShapeError(
                "SpectralLines phases", f"shape {phases.shape}", f"shape {self.frequencies.shape}"
            )
        parts = np.array_split(t.ravel(), max(1, t.size * len(self) // BLOCK))
        sums = [self._cosines(part, phases) @ amplitudes for part in parts]
        return np.concatenate(sums).reshape(t.shape)

    def _cosines(self, t: Array, phases: Array) -> Array:
        """cos(2 pi f_k t + phi_k), whole turns taken off first, shape (T, N)."""
        turns = t[:, None] * self.frequencies
        return np.cos(2.0 * np.pi * (turns - np.floor(turns)) + phases)


def spectral_lines(spectrum: Spectrum, lines: int, spacing: Spacing = "uniform") -> SpectralLines:
    """Lines that carry the power of a spectrum, none of it lost.

    Args:
        spectrum: What the sum shall have, (m/s^2)^2/Hz.
        lines: N.
        spacing: ``"uniform"`` puts them at multiples of one distance df, each with the power
            between the midpoints to its neighbours, A_k^2/2 = integral of S over that interval;
            the sum is periodic with 1/df. ``"equal_power"`` cuts the band into N intervals of
            equal power and puts a line at each one's median: crowded where the spectrum is
            high, and not periodic.

    Returns:
        For uniform spacing one line more or less than N, as the multiples fall into the band.
    """
    counting("spectral_lines lines", lines)
    low, high = spectrum.band
    if spacing == "equal_power":
        share = (np.arange(lines) + 0.5) / lines
        frequencies = spectrum.frequency_at(share * spectrum.power(high))
        amplitude = np.sqrt(2.0 / lines) * spectrum.rms()
        return SpectralLines(frequencies, np.full(lines, amplitude), np.inf)
    if spacing != "uniform":
        raise ParameterError("spectral_lines spacing", repr(spacing), '"uniform" or "equal_power"')
    distance = (high - low) / lines
    multiples = np.array([low, high]) / distance
    first, last = int(np.ceil(multiples[0] - NEAR)), int(np.floor(multiples[1] + NEAR))
    frequencies = np.minimum(np.arange(max(first, 1), last + 1) * distance, high)
    between = 0.5 * (frequencies[1:] + frequencies[:-1])
    powers = np.diff(spectrum.power(np.concatenate([[low], between, [high]])))
    some = powers > 0
    return SpectralLines(frequencies[some], np.sqrt(2.0 * powers[some]), 1.0 / distance)
