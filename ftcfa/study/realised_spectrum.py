"""What a specification becomes: noise made of it, and the spectrum that this noise has."""

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
"""Of neighbouring segments; more gains nothing with a Hann window."""
SHORTEST = 8
"""Steps that a segment must have."""
LINES, MOST_LINES, LINES_BELOW = 200, 1000, 4
"""Frequencies of the estimate in the band, at least and at most, and below it, where the most
allow."""
STEPS_PER_PERIOD = 10
"""Integration steps in the shortest period of a band, at least: two more than needed."""
LENGTHS = 64
"""Duration of a realisation of shaped noise, in segments."""
PERIODS = 3
"""Of a sum of lines, which repeats: more would not change its estimate."""


@dataclass(frozen=True, eq=False)
class SpectrumEstimate:
    """Welch's estimate of the spectra of a realisation.

    Attributes:
        frequencies: Shape (F,) [Hz].
        densities: One-sided, shape (F, m) [unit of xi squared per Hz].
        rms: Root mean square of the realisation itself, shape (m,) [unit of xi].
        segments: How many overlapping segments were averaged.
        standard_error: Relative standard deviation of a density, for Gaussian noise whose
            density is even over the resolution.
    """

    frequencies: Array
    densities: Array
    rms: Array
    segments: int
    standard_error: float


def estimate_spectrum(values: Array, step: float, resolution: float) -> SpectrumEstimate:
    """Spectra of what `realise` returns, by Welch's method with a Hann window.

    The mean over a step has the density S(f) sinc(f h)^2, with sinc(x) = sin(pi x)/(pi x), which
    is divided by; so the estimate holds for an excitation with little power above 1/(2 h).
    The relative variance of an average of K segments, D apart, of noise is (Welch 1967, IEEE
    Trans. Audio and Electroacoustics 15)

        (1 + 2 sum_j (1 - j/K) r_j)/K,   r_j = (sum_n w_n w_{n + j D} / sum_n w_n^2)^2

    Args:
        values: Means of xi over steps, shape (steps, m).
        step: h [s].
        resolution: Distance of the estimate's frequencies, one over a segment's length; rounded
            to whole steps [Hz].

    Raises:
        ShapeError: If ``values`` has other than two dimensions.
        ParameterError: If the values are fewer than a segment, or a segment fewer than 8 steps.
    """
    positive("step", step, "s")
    positive("resolution", resolution, "Hz")
    values = np.asarray(values, dtype=float)
    if values.ndim != 2:
        raise ShapeError("realised values", f"shape {values.shape}", "(steps, channels)")
    length = round(1.0 / (resolution * step))
    if not SHORTEST <= length <= len(values):
        raise ParameterError(
            "resolution",
            f"{resolution:g} Hz, segments of {length} steps",
            f"segments of {SHORTEST} to {len(values)} steps",
        )
    overlap = int(OVERLAP * length)
    window = signal.get_window("hann", length)
    f, averaged = signal.welch(values, 1.0 / step, window, noverlap=overlap, detrend=False, axis=0)
    inside = (f > 0) & (f < 0.5 / step)
    f = f[inside]
    segments = (len(values) - overlap) // (length - overlap)
    return SpectrumEstimate(
        f,
        averaged[inside] / np.sinc(f * step)[:, None] ** 2,
        np.sqrt(np.mean(values**2, axis=0)),
        segments,
        _standard_error(window, length - overlap, segments),
    )


def _standard_error(window: Array, distance: int, segments: int) -> float:
    """Relative standard deviation of the average of overlapping periodograms."""
    total = 1.0
    for j in range(1, min(segments, -(-len(window) // distance))):
        shared = np.sum(window[j * distance :] * window[: -j * distance]) / np.sum(window**2)
        total += 2.0 * (1.0 - j / segments) * float(shared) ** 2
    return float(np.sqrt(total / segments))


@dataclass(frozen=True, eq=False)
class RealisedSpecification:
    """A specification, the filter fitted to it, and estimates of what either excitation makes.

    Attributes:
        standard: What is specified.
        fit: The shaping filter.
        step: h of the realisations [s].
        duration: Of the shaped noise [s].
        seed: Of the realisations, path 0.
        shaped: Spectrum of a realisation of `ShapedNoise`.
        lines: How many lines its sum of sinusoids has.
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


def realise_specification(standard: Standard, seed: int = 0) -> RealisedSpecification:
    """Fit a filter to a specification, make noise of it and estimate the noise's spectrum.

    The report of the fit comes with it; no warning is given of one that is not close.

    Args:
        standard: Of `standards` or `read_table`.
        seed: Of the realisations.
    """
    spectrum = standard.spectrum
    lines = _lines(spectrum)
    resolution = (spectrum.band[1] - spectrum.band[0]) / lines
    quarters = np.ceil(STEPS_PER_PERIOD * spectrum.band[1] / resolution * (1.0 - OVERLAP))
    step = (1.0 - OVERLAP) / (resolution * float(quarters))  # segments begin at whole steps
    noise, tones = ShapedNoise(standard), RandomPhase(standard, lines)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (fit,) = noise.fits
    duration = LENGTHS / resolution
    shaped = estimate_spectrum(realise(noise, 1, duration, step, seed=seed), step, resolution)
    values = realise(tones, 1, PERIODS / resolution, step, seed=seed)
    return RealisedSpecification(
        standard, fit, step, duration, seed, shaped, lines, _of_lines(values, step, resolution)
    )


def _of_lines(values: Array, step: float, resolution: float) -> SpectrumEstimate:
    """Estimate of whole periods of lines, from as many segments of every phase of a period."""
    last = round((1.0 - OVERLAP) / (resolution * step))
    estimate = estimate_spectrum(values[:-last], step, resolution)
    return replace(estimate, rms=np.sqrt(np.mean(values**2, axis=0)))


def _lines(spectrum: Spectrum) -> int:
    """Frequencies of the estimate in the band: enough for its width and for its lowest part."""
    low, high = spectrum.band
    return int(np.ceil(np.clip(LINES_BELOW * (high - low) / low, LINES, MOST_LINES)))
