"""Realisations of a vibration standard, and Welch's estimates of their spectra."""

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from ftcfa.arrays import Array
from ftcfa.checks import positive
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.excitations.random_phase import RandomPhase
from ftcfa.vibration.excitations.shaped_noise import ShapedNoise
from ftcfa.vibration.realisation import realise
from ftcfa.vibration.spectra.filter_fit import FilterFit
from ftcfa.vibration.spectra.spectrum import Spectrum
from ftcfa.vibration.spectra.standards import Standard

OVERLAP = 0.75
"""Share of overlap of neighbouring segments; more gains nothing with a Hann window."""
SHORTEST = 8
"""Smallest number of steps in a segment."""
LINES, MOST_LINES = 200, 1000
"""Smallest and largest number of the estimate's frequencies in the band."""
LINES_BELOW = 4
"""Number of the estimate's frequencies up to the band, as far as `MOST_LINES` allows."""
STEPS_PER_PERIOD = 10
"""Smallest number of integration steps in the shortest period of a band: two more than needed."""
LENGTHS = 64
"""Duration of a realisation of shaped noise, in segments."""
PERIODS = 3
"""Duration of a sum of lines, in its periods; it repeats, so more would not change its estimate."""


@dataclass(frozen=True, eq=False)
class SpectrumEstimate:
    """Welch's estimate of the spectra of a realisation.

    Attributes:
        frequencies: Shape (F,) [Hz].
        densities: One-sided, shape (F, m) [unit of xi squared per Hz].
        rms: Root mean square of the realisation itself, shape (m,) [unit of xi].
        segments: Number of overlapping segments that were averaged.
        standard_error: Relative standard deviation of a density, for Gaussian noise whose
            density is constant over the resolution.
    """

    frequencies: Array
    densities: Array
    rms: Array
    segments: int
    standard_error: float


def estimate_spectrum(
    values: Array, step: float, resolution: float, sampled: bool = False
) -> SpectrumEstimate:
    """Spectra of a realisation of `realise`, by Welch's method with a Hann window.

    The mean over a step has the density S(f) sinc(f h)^2, with sinc(x) = sin(pi x)/(pi x). The
    estimate is divided by sinc(f h)^2, so it holds for an excitation with little power above
    1/(2 h). The relative variance of an average of K segments, D steps apart, of noise is (Welch
    1967, IEEE Trans. Audio and Electroacoustics 15)

        (1 + 2 sum_j (1 - j/K) r_j)/K,   r_j = (sum_n w_n w_{n + j D} / sum_n w_n^2)^2

    Args:
        values: Means of xi over steps, shape (steps, m).
        step: h [s].
        resolution: Distance of the estimate's frequencies [Hz]: one over a segment's length, which
            is rounded to whole steps.
        sampled: Whether the values are samples and no means over steps: there is no sinc then.

    Raises:
        ShapeError: If ``values`` has not two dimensions.
        ParameterError: If the values are fewer than a segment, or a segment fewer than 8 steps.
    """
    positive("step", step, "s")
    positive("resolution", resolution, "Hz")
    values = np.asarray(values, dtype=float)
    if values.ndim != 2:
        raise ShapeError("realised values", f"shape {values.shape}", "(steps, channels)")
    length = round(1.0 / (resolution * step))
    if not SHORTEST <= length <= len(values):
        got = f"{resolution:g} Hz, segments of {length} steps"
        expected = f"segments of {SHORTEST} to {len(values)} steps"
        raise ParameterError("resolution", got, expected)
    overlap = int(OVERLAP * length)
    window = signal.get_window("hann", length)
    f, averaged = signal.welch(values, 1.0 / step, window, noverlap=overlap, detrend=False, axis=0)
    inside = (f > 0) & (f < 0.5 / step)
    f, densities = f[inside], averaged[inside]
    if not sampled:
        densities = densities / np.sinc(f * step)[:, None] ** 2
    segments = (len(values) - overlap) // (length - overlap)
    error = _standard_error(window, length - overlap, segments)
    return SpectrumEstimate(f, densities, _rms(values), segments, error)


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(values**2, axis=0))


def _standard_error(window: Array, distance: int, segments: int) -> float:
    """Relative standard deviation of the average of overlapping periodograms."""
    total = 1.0
    for j in range(1, min(segments, -(-len(window) // distance))):
        shared = np.sum(window[j * distance :] * window[: -j * distance]) / np.sum(window**2)
        total += 2.0 * (1.0 - j / segments) * float(shared) ** 2
    return float(np.sqrt(total / segments))


@dataclass(frozen=True, eq=False)
class RealisedStandard:
    """A standard, the filter fitted to it, and spectra of realisations of two excitations.

    Attributes:
        standard: The standard.
        fit: The shaping filter.
        step: h of the realisations [s].
        duration: Duration of the shaped noise [s].
        seed: Seed of the realisations, which are path 0.
        shaped: Spectrum of a realisation of `ShapedNoise`.
        lines: Number of lines in the sum of sinusoids.
        tones: Spectrum of a realisation of `RandomPhase`.
    """

    standard: Standard
    fit: FilterFit
    step: float
    duration: float
    seed: int
    shaped: SpectrumEstimate
    lines: int
    tones: SpectrumEstimate


def realise_standard(standard: Standard, seed: int = 0) -> RealisedStandard:
    """Fit a filter to a standard, make noise of it and estimate the spectrum of the noise.

    The result holds the report of the fit; there is no warning if the fit is not close.

    Args:
        standard: One of `standards`, or of a file by `read_table`.
        seed: Seed of the realisations.
    """
    spectrum = standard.spectrum
    lines = _lines(spectrum)
    resolution = (spectrum.band[1] - spectrum.band[0]) / lines
    quarters = np.ceil(STEPS_PER_PERIOD * spectrum.band[1] / resolution * (1.0 - OVERLAP))
    step = (1.0 - OVERLAP) / (resolution * float(quarters))  # segments begin at whole steps
    noise = ShapedNoise(standard)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (fit,) = noise.fits
    duration = LENGTHS / resolution
    shaped = estimate_spectrum(realise(noise, 1, duration, step, seed=seed), step, resolution)
    values = realise(RandomPhase(standard, lines), 1, PERIODS / resolution, step, seed=seed)
    last = round((1.0 - OVERLAP) / (resolution * step))  # so segments begin at each phase alike
    estimate = estimate_spectrum(values[:-last], step, resolution)
    tones = replace(estimate, rms=_rms(values))
    return RealisedStandard(standard, fit, step, duration, seed, shaped, lines, tones)


def _lines(spectrum: Spectrum) -> int:
    """Number of the estimate's frequencies in the band: enough for its width and lowest part."""
    low, high = spectrum.band
    return int(np.ceil(np.clip(LINES_BELOW * (high - low) / low, LINES, MOST_LINES)))
