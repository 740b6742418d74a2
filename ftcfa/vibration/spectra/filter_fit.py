"""Shaping filter of a break-point spectrum, of the lowest order that fits, and how well it fits.

Its `Sections` have two pole pairs more than zero pairs. The double zero at s = 0 keeps velocity and
displacement of the shaken base bounded; the two further poles let the density fall above the band.
Where the largest deviation stays too large, a pole pair and a zero pair that cancel are added
there, which changes nothing, and the fit goes on with the higher order.
"""

from dataclasses import dataclass, replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_integer
from ftcfa.errors import ParameterError
from ftcfa.portable import exp
from ftcfa.vibration.spectra.linear_filter import LinearFilter
from ftcfa.vibration.spectra.section_fit import (
    DB,
    DB_TOLERANCE,
    PATIENCE,
    RMS_TOLERANCE,
    WORTHWHILE,
    Target,
    fit_sections,
    grid,
    to_grid,
    widths,
)
from ftcfa.vibration.spectra.sections import Sections
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY, Spectrum

EDGE_TOLERANCE = 0.02
"""Relative uncertainty of frequency that the lenient deviation grants at a steep edge."""
MIN_ORDER, MAX_ORDER = 4, 24
NEW_DAMPING = 0.05
"""Damping of an added pole and zero."""
NUDGE = 0.005
"""Relative distance of the added pole and zero: at the same place the fit could not move them."""


@dataclass(frozen=True, eq=False)
class FilterFit:
    """A fitted shaping filter, and how well it fits.

    Attributes:
        filter: The filter; its output is an acceleration [m/s^2].
        spectrum: The spectrum that it was fitted to.
        worst_db: Largest deviation of the density over the band, with its sign [dB].
        worst_frequency: Frequency of that deviation [Hz].
        edge_db: Largest deviation if frequencies may be off by 2 %, as a steep edge needs [dB].
        edge_frequency: Frequency of that deviation [Hz].
        rms_error: Relative error of the overall stationary rms, all frequencies.
        outside: Share of the filter's variance that lies outside the band.
    """

    filter: LinearFilter
    spectrum: Spectrum
    worst_db: float
    worst_frequency: float
    edge_db: float
    edge_frequency: float
    rms_error: float
    outside: float

    @property
    def within_tolerance(self) -> bool:
        """Whether the fit is within 1.5 dB all over the band and 3 % of the overall rms."""
        return abs(self.worst_db) <= DB_TOLERANCE and self._level_fits

    @property
    def within_edge_tolerance(self) -> bool:
        """Whether the fit is within tolerance if frequencies may be off by 2 %."""
        return abs(self.edge_db) <= DB_TOLERANCE and self._level_fits

    @property
    def _level_fits(self) -> bool:
        return abs(self.rms_error) <= RMS_TOLERANCE

    def __str__(self) -> str:
        target, reached = self.spectrum.g_rms(), float(self.filter.rms()[0]) / STANDARD_GRAVITY
        verdict = "NOT within"
        if self.within_tolerance:
            verdict = "within"
        elif self.within_edge_tolerance:
            verdict = f"within, if frequency may be off by {100 * EDGE_TOLERANCE:g} %,"
        return (
            f"shaping filter of order {self.filter.order}: {reached:.4g} g rms against "
            f"{target:.4g} ({100 * self.rms_error:+.1f} %), {100 * self.outside:.1f} % of the "
            f"variance outside the band, largest deviation {self.worst_db:+.2f} dB at "
            f"{self.worst_frequency:.4g} Hz ({self.edge_db:+.2f} dB at {self.edge_frequency:.4g} "
            f"Hz if frequency may be off by {100 * EDGE_TOLERANCE:g} %): {verdict} the "
            f"tolerance of {DB_TOLERANCE:g} dB and {100 * RMS_TOLERANCE:g} %"
        )


def fit_filter(
    spectrum: Spectrum, order: int | None = None, max_order: int = MAX_ORDER
) -> FilterFit:
    """A shaping filter whose output has a given spectrum, and the report of its fit.

    Args:
        spectrum: Break points.
        order: Number of states, even, 4 or more; None takes the lowest order that fits.
        max_order: Highest order to try; the best fit so far is returned if none fits.

    Returns:
        The fit: `within_tolerance` says whether it is good, and its text how good.

    Raises:
        ParameterError: If an order is odd or below 4.
    """
    for name, value in (("order", max_order if order is None else order), ("max_order", max_order)):
        if not is_integer(value) or value < MIN_ORDER or value % 2:
            raise ParameterError(f"fit_filter {name}", repr(value), "an even integer >= 4")
    target = Target.of(spectrum)
    sections = fit_sections(target, _first_guess(spectrum, target))
    best, idle = _measure(spectrum, sections), 0
    while sections.order != order and not (order is None and best.within_tolerance):
        if order is None and (sections.order >= max_order or idle == PATIENCE):
            break
        sections = fit_sections(target, _with_neutral_pair(target, sections))
        fit = _measure(spectrum, sections)
        idle = 0 if _misfit(fit) < WORTHWHILE * _misfit(best) else idle + 1
        if order is not None or _misfit(fit) < _misfit(best):
            best = fit
    return best


def _first_guess(spectrum: Spectrum, target: Target) -> Sections:
    """Sections of order 4: a pole pair at either end of the band."""
    w = 2.0 * np.pi * np.array(spectrum.band)
    guess = Sections(float(w[0]), 0.0, np.log(np.array([w, np.full(2, 0.5)])), np.zeros((2, 0)))
    gain = -float(np.mean(target.deviation(guess))) / DB
    return replace(guess, log_gain=gain)


def _with_neutral_pair(target: Target, sections: Sections) -> Sections:
    """Sections with a pole pair and a zero pair more that almost cancel, at the worst place."""
    deviation = target.deviation(sections)
    at = int(np.argmax(np.abs(deviation)))
    place, nudge = np.log(2.0 * np.pi * target.f[at]), NUDGE * np.sign(deviation[at])
    pole = np.array([[place], [np.log(NEW_DAMPING) + nudge]])
    zero = np.array([[place], [np.log(NEW_DAMPING) - nudge]])
    poles, zeros = np.hstack([sections.poles, pole]), np.hstack([sections.zeros, zero])
    return replace(sections, poles=poles, zeros=zeros)


def _measure(spectrum: Spectrum, sections: Sections) -> FilterFit:
    """The filter with the gain that gives the band the power of the spectrum, and its errors."""
    raw = sections.realised()
    f = np.union1d(grid(spectrum, per_octave=60, per_segment=20), sections.features(spectrum.band))
    density = raw.density(f)[:, 0]
    in_band = float(density @ widths(f))
    gain = float(exp(to_grid(np.log(spectrum.rms() / np.sqrt(in_band)))))
    total = float(raw.rms()[0])
    logs = np.log(density * gain**2)
    strict = DB * (logs - np.log(spectrum.density(f)))
    lowest, highest = _range(spectrum, f)
    lenient = DB * (np.maximum(logs - np.log(highest), 0.0) + np.minimum(logs - np.log(lowest), 0))
    worst, edge = int(np.argmax(np.abs(strict))), int(np.argmax(np.abs(lenient)))
    return FilterFit(
        raw.scaled(gain),
        spectrum,
        worst_db=float(strict[worst]),
        worst_frequency=float(f[worst]),
        edge_db=float(lenient[edge]),
        edge_frequency=float(f[edge]),
        rms_error=total * gain / spectrum.rms() - 1.0,
        outside=1.0 - in_band / total**2,
    )


def _range(spectrum: Spectrum, f: Array) -> tuple[Array, Array]:
    """Least and largest density within the frequency uncertainty of each f, two of shape (F,)."""
    points = spectrum.frequencies
    near = np.abs(points / f[:, None] - 1.0) <= EDGE_TOLERANCE  # (F, k)
    ends = np.clip(f[:, None] * (1.0 + EDGE_TOLERANCE * np.array([-1, 0, 1])), *spectrum.band)
    candidates = np.hstack([ends, np.where(near, points, f[:, None])])
    density = spectrum.density(candidates)
    return density.min(axis=1), density.max(axis=1)


def _misfit(fit: FilterFit) -> float:
    """Larger of the two errors, each relative to its tolerance."""
    return max(abs(fit.worst_db) / DB_TOLERANCE, abs(fit.rms_error) / RMS_TOLERANCE)
