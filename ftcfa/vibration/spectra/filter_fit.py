"""Fitting a shaping filter to a break-point spectrum.

    H(s) = g s^2 prod_j (s^2 + 2 xi_j w_j s + w_j^2) / prod_i (s^2 + 2 zeta_i w_i s + w_i^2)

with two pole pairs more than zero pairs. The double zero at s = 0 keeps velocity and displacement
of the shaken base bounded; the two further poles let the density fall above the band. Poles and
zeros are fitted in log frequency and log damping, so the filter is stable and minimum-phase by
construction, to the density in dB, by non-linear least squares reweighted towards the largest
deviation (Lawson 1961). Where the largest deviation stays too large, a pole pair and a zero pair
that cancel are put there, which changes nothing, and the fit goes on with the higher order.
Nothing in it is random.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError
from ftcfa.vibration.spectra.linear_filter import LinearFilter
from ftcfa.vibration.spectra.sections import Sections
from ftcfa.vibration.spectra.spectrum import STANDARD_GRAVITY, Spectrum

DB_TOLERANCE = 1.5
"""Allowed deviation of the density over the band [dB]."""
RMS_TOLERANCE = 0.03
"""Allowed relative error of the overall rms."""
EDGE_TOLERANCE = 0.02
"""Relative uncertainty of frequency that the lenient deviation grants at a steep edge."""
MIN_ORDER, MAX_ORDER = 4, 24

DB = 10.0 / np.log(10.0)
"""Decibels of a unit of the natural logarithm of a density."""
NEW_DAMPING = 0.05
"""Damping of a pole and a zero that are put in where the deviation is largest."""
NUDGE = 0.005
"""How far apart, relatively, they are put: at the very same place the fit could not tell."""
TARGET = 0.85
"""Share of the tolerance at which reweighting stops."""
WORTHWHILE, PATIENCE = 0.97, 3
"""Reweighting, and growing, end after three rounds that do not improve the score by 3 %."""
REWEIGHTINGS = 30
EVALUATIONS = 40
"""Most evaluations of one least-squares problem."""
OUTSIDE_WEIGHT = 4.0
"""dB that a share of 1 of the variance outside the band counts for, against one in the band."""
CLOSE, OUT = 1e-3, 3.0
"""Where power outside the band is counted, from its edges [octaves]."""
LEVEL_WEIGHT = 10.0
"""Weight of the error of the level in the band, in dB against dB."""
DAMP = 1e-3
"""Weight that holds parameters which the data do not determine."""


@dataclass(frozen=True, eq=False)
class FilterFit:
    """A fitted shaping filter, and how well it fits.

    Attributes:
        filter: The filter; its output is an acceleration [m/s^2].
        spectrum: What it was fitted to.
        worst_db: Largest deviation of the density over the band, with its sign [dB].
        worst_frequency: Where [Hz].
        edge_db: The same where the frequency may be off by 2 %, as a steep edge needs [dB].
        edge_frequency: Where [Hz].
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
        """Within 1.5 dB at every frequency of the band and 3 % of the overall rms."""
        return abs(self.worst_db) <= DB_TOLERANCE and self._level_fits

    @property
    def within_edge_tolerance(self) -> bool:
        """The same, with a frequency uncertainty of 2 %."""
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
            verdict = f"within, granted {100 * EDGE_TOLERANCE:g} % of frequency at edges,"
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
        order: Number of states, even, 4 or more; None takes the lowest that fits.
        max_order: Where to stop looking; the best fit found is returned with its report.

    Returns:
        The fit; ask `within_tolerance`, print it.

    Raises:
        ParameterError: If an order is odd or below 4.
    """
    for name, value in (("order", max_order if order is None else order), ("max_order", max_order)):
        if isinstance(value, bool) or not isinstance(value, int) or value < MIN_ORDER or value % 2:
            raise ParameterError(f"fit_filter {name}", repr(value), "an even integer >= 4")
    task = _Task.of(spectrum)
    sections = _fit_sections(task, _first_guess(spectrum, task))
    best, idle = _measure(spectrum, sections), 0
    while sections.order != order and not (order is None and best.within_tolerance):
        if order is None and (sections.order >= max_order or idle == PATIENCE):
            break
        sections = _fit_sections(task, _with_neutral_pair(task, sections))
        fit = _measure(spectrum, sections)
        idle = 0 if _misfit(fit) < WORTHWHILE * _misfit(best) else idle + 1
        if order is not None or _misfit(fit) < _misfit(best):
            best = fit
    return best


@dataclass(frozen=True, eq=False)
class _Task:
    """What is fitted: the table on a grid, and the cost of power outside the band."""

    band: tuple[float, float]
    power: float  # overall [(m/s^2)^2]
    f: Array  # in the band, then outside
    width: Array  # of the trapezoid rule on f
    target: Array  # log of the density in the band, (inside,)
    inside: int  # how many of f lie in the band

    @classmethod
    def of(cls, spectrum: Spectrum) -> "_Task":
        low, high = spectrum.band
        f = _grid(spectrum, per_octave=12, per_segment=6)
        beyond = np.append(0.0, np.geomspace(CLOSE, OUT, 40))  # octaves; the fall is steepest here
        below, above = low * 2.0 ** -beyond[::-1], high * 2.0**beyond
        return cls(
            spectrum.band,
            spectrum.rms() ** 2,
            np.concatenate([f, below, above]),
            np.concatenate([_widths(f), _widths(below), _widths(above)]),
            np.log(spectrum.density(f)),
            len(f),
        )

    def deviation(self, sections: Sections) -> Array:
        """Deviation of the density in the band, shape (inside,) [dB]."""
        return DB * (sections.log_density(self.f[: self.inside])[0] - self.target)

    def outside(self, sections: Sections) -> float:
        """Power outside the band relative to the table's."""
        density = np.exp(sections.log_density(self.f[self.inside :])[0])
        return float(density @ self.width[self.inside :]) / self.power

    def residual(self, sections: Sections, weight: Array) -> tuple[Array, Array]:
        """Residuals and their derivatives by the parameters."""
        k = self.inside
        L, J = sections.log_density(self.f)
        power = np.exp(L) * self.width / self.power
        scale = DB * weight / np.sqrt(k)
        share = OUTSIDE_WEIGHT * np.sqrt(power[k:])
        level = power[:k].sum()
        residual = [scale * (L[:k] - self.target), share, [LEVEL_WEIGHT * np.log(level)]]
        J[k:] *= 0.5 * share[:, None]
        d_level = LEVEL_WEIGHT * power[:k] @ J[:k] / level
        J[:k] *= scale[:, None]
        return np.concatenate(residual), np.vstack([J, d_level])


def _grid(spectrum: Spectrum, per_octave: int, per_segment: int) -> Array:
    """Frequencies over the band: evenly in log, in every segment, and close around its ends."""
    low, high = spectrum.band
    points = spectrum.frequencies
    close = 1.0 + np.array([-0.03, -0.015, -0.008, -0.004, -0.002, 0.0])
    even = np.geomspace(low, high, int(per_octave * np.log2(high / low)) + 40)
    near = np.outer(points, np.concatenate([close, 2.0 - close])).ravel()
    within = np.linspace(points[:-1], points[1:], per_segment).ravel()
    f = np.unique(np.concatenate([even, near, within]))
    return f[(f >= low) & (f <= high)]


def _widths(f: Array) -> Array:
    """Weights of the trapezoid rule on f."""
    step = np.diff(f)
    return 0.5 * (np.append(step, 0.0) + np.insert(step, 0, 0.0))


def _first_guess(spectrum: Spectrum, task: _Task) -> Sections:
    """Order 4: a pole pair at either end of the band."""
    w = 2.0 * np.pi * np.array(spectrum.band)
    guess = Sections(float(w[0]), 0.0, np.log(np.array([w, np.full(2, 0.5)])), np.zeros((2, 0)))
    gain = -float(np.mean(task.deviation(guess))) / DB
    return Sections(guess.w0, gain, guess.poles, guess.zeros)


def _with_neutral_pair(task: _Task, sections: Sections) -> Sections:
    """A pole pair and a zero pair more, at the largest deviation, almost cancelling."""
    deviation = task.deviation(sections)
    at = int(np.argmax(np.abs(deviation)))
    place, nudge = np.log(2.0 * np.pi * task.f[at]), NUDGE * np.sign(deviation[at])
    pole = np.array([[place], [np.log(NEW_DAMPING) + nudge]])
    zero = np.array([[place], [np.log(NEW_DAMPING) - nudge]])
    return Sections(
        sections.w0,
        sections.log_gain,
        np.hstack([sections.poles, pole]),
        np.hstack([sections.zeros, zero]),
    )


def _fit_sections(task: _Task, sections: Sections) -> Sections:
    """Least squares first, then reweighted towards the largest deviation."""
    weight = np.ones(task.inside)
    best = sections = _least_squares(task, sections, weight)
    score, idle = _score(task, best), 0
    for _ in range(REWEIGHTINGS):
        if score <= TARGET or idle == PATIENCE:
            break
        deviation = np.abs(task.deviation(sections))
        weight = weight * np.sqrt(deviation / deviation.max() + 0.05)
        weight = np.maximum(weight / np.sqrt(np.mean(weight**2)), 0.05)
        sections = _least_squares(task, sections, weight)
        reached = _score(task, sections)
        idle = 0 if reached < WORTHWHILE * score else idle + 1
        if reached < score:
            best, score = sections, reached
    return best


def _score(task: _Task, sections: Sections) -> float:
    """Largest of deviation and power outside, relative to what is allowed; 1 just fits."""
    allowed = (1.0 + RMS_TOLERANCE) ** 2 - 1.0
    worst = float(np.abs(task.deviation(sections)).max())
    return max(worst / DB_TOLERANCE, task.outside(sections) / allowed)


def _least_squares(task: _Task, sections: Sections, weight: Array) -> Sections:
    start = sections.vector
    lower, upper = sections.bounds(task.band)
    inside = np.clip(start, lower + 1e-9, upper - 1e-9)

    last: list[tuple[Array, Array, Array]] = []

    def both(vector: Array) -> tuple[Array, Array]:
        """Residuals and derivatives; the solver asks for them one after the other."""
        if not (last and np.array_equal(last[0][0], vector)):
            last[:] = [(vector.copy(), *task.residual(sections.moved(vector), weight))]
        return last[0][1], last[0][2]

    def residual(vector: Array) -> Array:
        return np.concatenate([both(vector)[0], DAMP * (vector - start)])

    def jacobian(vector: Array) -> Array:
        return np.vstack([both(vector)[1], DAMP * np.eye(len(vector))])

    found = least_squares(
        residual, inside, jacobian, (lower, upper), ftol=1e-6, xtol=1e-6, max_nfev=EVALUATIONS
    )
    return sections.moved(found.x)


def _measure(spectrum: Spectrum, sections: Sections) -> FilterFit:
    """The filter with the gain that gives the band its table's power, and its deviations."""
    raw = sections.realised()
    f = np.union1d(_grid(spectrum, per_octave=60, per_segment=20), sections.features(spectrum.band))
    density = raw.density(f)[:, 0]
    in_band = float(density @ _widths(f))
    gain = spectrum.rms() / np.sqrt(in_band)
    total = float(raw.rms()[0])
    logs = np.log(density * gain**2)
    strict = DB * (logs - np.log(spectrum.density(f)))
    lowest, highest = _range(spectrum, f)
    lenient = DB * (np.maximum(logs - np.log(highest), 0.0) + np.minimum(logs - np.log(lowest), 0))
    worst, edge = int(np.argmax(np.abs(strict))), int(np.argmax(np.abs(lenient)))
    return FilterFit(
        raw.scaled(gain),
        spectrum,
        float(strict[worst]),
        float(f[worst]),
        float(lenient[edge]),
        float(f[edge]),
        total * gain / spectrum.rms() - 1.0,
        1.0 - in_band / total**2,
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
    """Largest error relative to its tolerance."""
    return max(abs(fit.worst_db) / DB_TOLERANCE, abs(fit.rms_error) / RMS_TOLERANCE)
