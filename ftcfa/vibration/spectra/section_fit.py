"""The fit of a shaping filter's sections to a break-point spectrum.

The logarithms of frequency and damping of the poles and zeros are fitted, so the filter is stable
and minimum-phase by construction. The fit is to the density in dB, by non-linear least squares
reweighted towards the largest deviation (Lawson 1961). Nothing in it is random.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ftcfa.arrays import Array
from ftcfa.vibration.spectra.sections import Sections
from ftcfa.vibration.spectra.spectrum import Spectrum

DB_TOLERANCE = 1.5
"""Allowed deviation of the density over the band [dB]."""
RMS_TOLERANCE = 0.03
"""Allowed relative error of the overall rms."""
DB = 10.0 / np.log(10.0)
"""Decibels of a unit of the natural logarithm of a density."""

GOOD = 0.85
"""Score at which reweighting stops; the tolerance has the score 1."""
WORTHWHILE, PATIENCE = 0.97, 3
"""Reweighting stops, and so does growing, after three rounds without a 3 % better score."""
REWEIGHTINGS = 30
"""Largest number of reweighted fits."""
EVALUATIONS = 40
"""Largest number of evaluations in one least-squares problem."""
OUTSIDE_WEIGHT = 4.0
"""Weight of power outside the band: dB for a share of 1 of the variance."""
CLOSE, OUT = 1e-3, 3.0
"""Nearest and farthest distance from the band's edges at which that power counts [octaves]."""
GRID = 2.0**-14
"""Grid of the logarithms of frequencies, dampings and gain: 6e-5, or 0.0005 dB."""
LEVEL_WEIGHT = 10.0
"""Weight of the error of the level in the band, in dB against dB."""
DAMP = 1e-3
"""Weight that holds parameters which the data do not determine."""


@dataclass(frozen=True, eq=False)
class Target:
    """The spectrum on a grid of frequencies, and the cost of power outside its band."""

    band: tuple[float, float]
    power: float  # overall [(m/s^2)^2]
    f: Array  # frequencies in the band, then outside [Hz]
    width: Array  # weights of the trapezoid rule on f
    log_density: Array  # logarithm of the density in the band (inside,)
    inside: int  # number of f in the band

    @classmethod
    def of(cls, spectrum: Spectrum) -> "Target":
        """Target of a spectrum."""
        low, high = spectrum.band
        f = grid(spectrum, per_octave=12, per_segment=6)
        beyond = np.append(0.0, np.geomspace(CLOSE, OUT, 40))  # octaves; the fall is steepest here
        below, above = low * 2.0 ** -beyond[::-1], high * 2.0**beyond
        return cls(
            spectrum.band,
            spectrum.rms() ** 2,
            np.concatenate([f, below, above]),
            np.concatenate([widths(f), widths(below), widths(above)]),
            np.log(spectrum.density(f)),
            len(f),
        )

    def deviation(self, sections: Sections) -> Array:
        """Deviation of the density in the band, shape (inside,) [dB]."""
        return DB * (sections.log_density(self.f[: self.inside])[0] - self.log_density)

    def outside(self, sections: Sections) -> float:
        """Power outside the band, relative to the power of the spectrum."""
        density = np.exp(sections.log_density(self.f[self.inside :])[0])
        return float(density @ self.width[self.inside :]) / self.power

    def residual(self, sections: Sections, weight: Array) -> tuple[Array, Array]:
        """Residuals, and their derivatives with respect to the parameters."""
        k = self.inside
        L, J = sections.log_density(self.f)
        power = np.exp(L) * self.width / self.power
        scale = DB * weight / np.sqrt(k)
        share = OUTSIDE_WEIGHT * np.sqrt(power[k:])
        level = power[:k].sum()
        residual = [scale * (L[:k] - self.log_density), share, [LEVEL_WEIGHT * np.log(level)]]
        J[k:] *= 0.5 * share[:, None]
        d_level = LEVEL_WEIGHT * power[:k] @ J[:k] / level
        J[:k] *= scale[:, None]
        return np.concatenate(residual), np.vstack([J, d_level])


def grid(spectrum: Spectrum, per_octave: int, per_segment: int) -> Array:
    """Frequencies over the band: even in the logarithm, in every segment, and near its ends."""
    low, high = spectrum.band
    points = spectrum.frequencies
    close = 1.0 + np.array([-0.03, -0.015, -0.008, -0.004, -0.002, 0.0])
    even = np.geomspace(low, high, int(per_octave * np.log2(high / low)) + 40)
    near = np.outer(points, np.concatenate([close, 2.0 - close])).ravel()
    within = np.linspace(points[:-1], points[1:], per_segment).ravel()
    f = np.unique(np.concatenate([even, near, within]))
    return f[(f >= low) & (f <= high)]


def widths(f: Array) -> Array:
    """Weights of the trapezoid rule on f."""
    step = np.diff(f)
    return 0.5 * (np.append(step, 0.0) + np.insert(step, 0, 0.0))


def fit_sections(target: Target, sections: Sections) -> Sections:
    """Fit sections, then reweight towards the largest deviation; the best result is returned."""
    weight = np.ones(target.inside)
    best = sections = _least_squares(target, sections, weight)
    score, idle = _score(target, best), 0
    for _ in range(REWEIGHTINGS):
        if score <= GOOD or idle == PATIENCE:
            break
        deviation = np.abs(target.deviation(sections))
        weight = weight * np.sqrt(deviation / deviation.max() + 0.05)
        weight = np.maximum(weight / np.sqrt(np.mean(weight**2)), 0.05)
        sections = _least_squares(target, sections, weight)
        reached = _score(target, sections)
        idle = 0 if reached < WORTHWHILE * score else idle + 1
        if reached < score:
            best, score = sections, reached
    return best.moved(to_grid(best.vector))


def to_grid(logarithms: Array) -> Array:
    """Logarithms rounded to GRID: the solver's last digits depend on the processor."""
    return np.round(logarithms / GRID) * GRID


def _score(target: Target, sections: Sections) -> float:
    """Larger of deviation and power outside the band, each relative to its tolerance."""
    allowed = (1.0 + RMS_TOLERANCE) ** 2 - 1.0
    worst = float(np.abs(target.deviation(sections)).max())
    return max(worst / DB_TOLERANCE, target.outside(sections) / allowed)


def _least_squares(target: Target, sections: Sections, weight: Array) -> Sections:
    """Sections that solve one weighted least-squares problem, from given ones."""
    start = sections.vector
    lower, upper = sections.bounds(target.band)
    inside = np.clip(start, lower + 1e-9, upper - 1e-9)

    last: list[tuple[Array, Array, Array]] = []

    def residual_and_jacobian(vector: Array) -> tuple[Array, Array]:
        """Residuals and derivatives, kept because the solver takes them one after the other."""
        if not (last and np.array_equal(last[0][0], vector)):
            last[:] = [(vector.copy(), *target.residual(sections.moved(vector), weight))]
        return last[0][1], last[0][2]

    def residual(vector: Array) -> Array:
        return np.concatenate([residual_and_jacobian(vector)[0], DAMP * (vector - start)])

    def jacobian(vector: Array) -> Array:
        return np.vstack([residual_and_jacobian(vector)[1], DAMP * np.eye(len(vector))])

    solution = least_squares(
        residual, inside, jacobian, (lower, upper), ftol=1e-6, xtol=1e-6, max_nfev=EVALUATIONS
    )
    return sections.moved(solution.x)
