"""A record's statistics and spectrum, and the table of break points that stands for it."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from ftcfa.arrays import Array
from ftcfa.checks import probability
from ftcfa.errors import ParameterError
from ftcfa.study.realised_spectrum import SpectrumEstimate, estimate_spectrum
from ftcfa.vibration.records.record import Record
from ftcfa.vibration.spectra.spectrum import Spectrum

SEGMENTS, FEWEST = 32, 4
"""Number of segments without overlap into which a record is cut, and their smallest number."""
SHORTEST = 16
"""Smallest number of samples of a segment."""
MOST_LINES = 2000
"""Largest number of frequencies of the estimate."""
BANDS = 12
"""Number of bands in an octave whose means make the envelope."""
HIGHEST = 0.8
"""End of the envelope as a share of the Nyquist frequency, where sensors' filters begin."""
LOWEST = 2
"""Begin of the envelope in units of the resolution: below, a trend was removed."""
NEGLIGIBLE = 5e-4
"""Share of the power that may lie below the envelope's begin, and above its end."""
SHARED = 1.5
"""Neighbouring frequencies that a Hann window makes one."""
TOLERANCE_DB = 0.25
"""Largest distance of the envelope from the straight lines that stand for it [dB]."""


@dataclass(frozen=True, eq=False)
class MeasuredVibration:
    """What a record is, and the envelope of its spectrum.

    Attributes:
        record: The record without its linear trend.
        peak: Largest size of each axis, shape (axes,) [m/s^2 or rad/s^2].
        kurtosis: Fourth moment over the squared variance of each axis, shape (axes,); 3 for
            Gaussian noise.
        estimate: Welch's estimate of the spectra.
        confidence: Confidence of the envelope.
        envelopes: Break points of each axis: an upper confidence limit of the mean density in
            each twelfth of an octave, by straight lines in log-log.
    """

    record: Record
    peak: Array
    kurtosis: Array
    estimate: SpectrumEstimate
    confidence: float
    envelopes: tuple[Spectrum, ...]

    @property
    def crest_factor(self) -> Array:
        """Peak over root mean square, shape (axes,)."""
        return self.peak / self.record.rms()


def measured_vibration(record: Record, confidence: float = 0.95) -> MeasuredVibration:
    """Statistics, spectrum and envelope of a record.

    Raises:
        ParameterError: If the record is shorter than 4 segments of 16 samples, or an axis is
            constant.
    """
    probability("measured_vibration confidence", confidence)
    detrended = record.detrended()
    length = min(max(len(record.values) // SEGMENTS, SHORTEST), 2 * MOST_LINES)
    if len(record.values) < FEWEST * length:
        got, expected = f"{len(record.values)} samples", f"{FEWEST * SHORTEST} or more"
        raise ParameterError("record for a spectrum", got, expected)
    for name, rms in zip(record.axes, detrended.rms(), strict=True):
        if not rms > 0:
            raise ParameterError(f"axis {name} of the record", "constant", "a vibration")
    resolution = 1.0 / (length * record.step)
    estimate = estimate_spectrum(detrended.values, record.step, resolution, sampled=True)
    envelopes = tuple(_envelope(estimate, S, record.step, confidence) for S in estimate.densities.T)
    return MeasuredVibration(
        detrended, np.abs(detrended.values).max(axis=0),
        stats.kurtosis(detrended.values, axis=0, fisher=False), estimate, confidence, envelopes,
    )  # fmt: skip


def _envelope(estimate: SpectrumEstimate, S: Array, step: float, confidence: float) -> Spectrum:
    """Upper confidence limits of the mean densities in bands, as few break points as will do."""
    f = estimate.frequencies
    usable = (f >= LOWEST * f[0]) & (f <= HIGHEST * 0.5 / step)
    below = np.cumsum(np.where(usable, S, 0.0))
    first, last = np.searchsorted(below, np.array([NEGLIGIBLE, 1.0 - NEGLIGIBLE]) * below[-1])
    low, high = f[first], f[max(last, first + 1)]
    edges = low * 2.0 ** (np.arange(np.ceil(BANDS * np.log2(high / low)) + 1) / BANDS)
    band = np.digitize(f, edges) - 1
    centres, limits = [], []
    for k in range(len(edges) - 1):
        inside = (band == k) & (f <= high)
        if inside.any():
            freedom = 2.0 / estimate.standard_error**2 * max(1.0, inside.sum() / SHARED)
            centres.append(float(np.exp(np.mean(np.log(f[inside])))))
            limits.append(
                float(np.mean(S[inside])) * freedom / stats.chi2.ppf(1 - confidence, freedom)
            )
    densities = np.maximum(limits, np.max(limits) * np.finfo(float).eps)
    kept = _corners(np.log(centres), 10.0 * np.log10(densities))
    return Spectrum(np.array(centres)[kept], densities[kept])


def _corners(x: Array, decibels: Array) -> list[int]:
    """Numbers of the points whose straight lines are within TOLERANCE_DB of all points.

    The farthest point is kept, on both sides of it likewise (Ramer 1972; Douglas, Peucker 1973).
    """
    kept, pending = {0, len(x) - 1}, [(0, len(x) - 1)]
    while pending:
        a, b = pending.pop()
        line = np.interp(x[a : b + 1], x[[a, b]], decibels[[a, b]])
        distance = np.abs(decibels[a : b + 1] - line)
        farthest = a + int(np.argmax(distance))
        if distance.max() > TOLERANCE_DB:
            kept.add(farthest)
            pending += [(a, farthest), (farthest, b)]
    return sorted(kept)
