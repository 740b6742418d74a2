"""Random vibration by random phases: a spectrum as a sum of lines (Rice 1944, Shinozuka 1971)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, counting
from ftcfa.vibration.excitation import Excitation, check_channels
from ftcfa.vibration.excitations.harmonic import TonesProcess
from ftcfa.vibration.spectra.spectrum import Spectrum, check_step
from ftcfa.vibration.spectra.standards import SpectrumLike, several, spectrum_of

NEAR = 1e-9
"""Share of the distance of lines by which an edge of the band may miss one, by rounding."""


class SpectralLines(NamedTuple):
    """A sum of sinusoids, the lines of a spectrum.

        y(t) = sum_k A_k cos(2 pi f_k t + phi_k),   variance sum_k A_k^2/2

    With phases independent and uniform on [0, 2 pi) it is stationary, and by the central limit
    theorem close to Gaussian for many lines of similar size. Its peaks stay below sum_k A_k, and
    its average power over a period is the same for any phases.
    """

    frequencies: Array
    """f_k, shape (N,) [Hz]."""
    amplitudes: Array
    """A_k, shape (N,) [m/s^2]."""
    period: float
    """Time after which y repeats [s]."""


def spectral_lines(spectrum: Spectrum, lines: int) -> SpectralLines:
    """Lines at multiples of one distance df that carry the power of a spectrum, none of it lost.

    Each line has the power between the midpoints to its neighbours: A_k^2/2 = integral of S over
    that interval. The sum repeats after 1/df.

    Args:
        spectrum: Spectrum of the sum [(m/s^2)^2/Hz].
        lines: N; the result has one more or less, as the multiples fall into the band.
    """
    counting("spectral_lines lines", lines)
    low, high = spectrum.band
    distance = (high - low) / lines
    multiples = np.array([low, high]) / distance
    first, last = int(np.ceil(multiples[0] - NEAR)), int(np.floor(multiples[1] + NEAR))
    frequencies = np.minimum(np.arange(max(first, 1), last + 1) * distance, high)
    between = 0.5 * (frequencies[1:] + frequencies[:-1])
    powers = np.diff(spectrum.power(np.concatenate([[low], between, [high]])))
    some = powers > 0
    return SpectralLines(frequencies[some], np.sqrt(2.0 * powers[some]), 1.0 / distance)


def spectra_of(subject: str, axes: SpectrumLike | Sequence[SpectrumLike]) -> tuple[Spectrum, ...]:
    """The spectrum of each axis; raises UnknownNameError or ParameterError if one has none."""
    return tuple(spectrum_of(axis) for axis in several(subject, axes))


@dataclass(frozen=True, eq=False)
class RandomPhase(Excitation):
    """Random vibration as sums of lines whose phases are drawn for each path.

    Each channel is a sum of `spectral_lines`: it carries the power of its spectrum exactly, is
    bounded, and close to Gaussian for many lines; it repeats after a `period`. The phases are
    independent of each other and uniform on [0, 2 pi), so the excitation is stationary.
    `ShapedNoise` never repeats, but meets its spectrum only as closely as its filter fits.

    Attributes:
        axes: A spectrum for each channel: the name of a table of `standards()`, a `Standard`, or
            a `Spectrum`. A single one needs no brackets.
        lines: Lines of each channel, one more or less. The period is lines/(width of the band), so
            a run without repetition takes lines > width times duration. Compilation and the cost
            of a step grow with them: 200 on each of three axes take ten seconds to compile, once
            in a process, and 0.8 us for a step of a path, seven times as much as 20.

    Raises:
        UnknownNameError: If there is no table of a name; it lists the known ones.
        ParameterError: If an axis is no spectrum, or ``lines`` no number of lines.
    """

    axes: Annotated[SpectrumLike | Sequence[SpectrumLike], Check(spectra_of)]
    lines: Annotated[int, Check(counting)] = 200

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "axes", several("RandomPhase axes", self.axes))

    @cached_property
    def spectra(self) -> tuple[Spectrum, ...]:
        """The spectrum of each channel."""
        return spectra_of("RandomPhase axes", self.axes)

    @cached_property
    def sums(self) -> tuple[SpectralLines, ...]:
        """The lines of each channel."""
        return tuple(spectral_lines(spectrum, self.lines) for spectrum in self.spectra)

    @property
    def period(self) -> Array:
        """Time after which each channel repeats, shape (m,) [s]."""
        return np.array([one.period for one in self.sums])

    def process(self, channels: int, step: float) -> TonesProcess:
        """See `Excitation.process`; the step must resolve the band of every spectrum."""
        check_channels("RandomPhase", len(self.spectra), channels)
        for spectrum in self.spectra:
            check_step(spectrum.band[1], step)
        amplitudes = np.concatenate([one.amplitudes for one in self.sums])
        frequencies = np.concatenate([one.frequencies for one in self.sums])
        counts = tuple(len(one.frequencies) for one in self.sums)
        return TonesProcess(amplitudes, frequencies, counts, step)
