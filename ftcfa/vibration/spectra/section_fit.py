"""Shaping filters as second-order sections, and their fit to a break-point spectrum.

    H(s) = g s^2 prod_j (s^2 + 2 xi_j w_j s + w_j^2) / prod_i (s^2 + 2 zeta_i w_i s + w_i^2)

up to a constant factor: each section is scaled to (s/w)^2 + 2 zeta s/w + 1. The logarithms of
frequency and damping of the poles and zeros are fitted, so the filter is stable and minimum-phase
by construction. The fit is to the density in dB, by non-linear least squares reweighted towards
the largest deviation (Lawson 1961). Nothing in it is random.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ftcfa.arrays import Array
from ftcfa.vibration.spectra.linear_filter import LinearFilter
from ftcfa.vibration.spectra.spectrum import Spectrum

DAMPING = (2e-3, 0.95)
"""Bounds of the damping of the poles; below 1 they stay complex and apart."""
ZERO_DAMPING = (1e-3, 3.0)
"""Bounds of the damping of the zeros."""
REACH = (1.0 / 6.0, 4.0)
"""Bounds of the frequencies of poles and zeros, relative to the edges of the band."""

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
LEVEL_WEIGHT = 10.0
"""Weight of the error of the level in the band, in dB against dB."""
DAMP = 1e-3
"""Weight that holds parameters which the data do not determine."""


@dataclass(frozen=True, eq=False)
class Sections:
    """Second-order sections, two pole pairs more than zero pairs and a double zero at s = 0.

        log S(w) = log_gain + 4 log(w/w0) + sum_j Q(w; zero j) - sum_i Q(w; pole i)
        Q(w; i)  = log |1 - (w/w_i)^2 + 2 i zeta_i w/w_i|^2

    Attributes:
        w0: Unit of angular frequency [rad/s].
        log_gain: Logarithm of the factor of the density.
        poles: log w_i and log zeta_i, shape (2, pole pairs).
        zeros: log w_j and log xi_j, shape (2, zero pairs).
    """

    w0: float
    log_gain: float
    poles: Array
    zeros: Array

    @property
    def order(self) -> int:
        """Number of states: two for each pole pair."""
        return 2 * self.poles.shape[1]

    @property
    def vector(self) -> Array:
        """All parameters in one vector."""
        return np.concatenate([[self.log_gain], self.poles.ravel(), self.zeros.ravel()])

    def moved(self, vector: Array) -> "Sections":
        """The same sections with other parameters."""
        split = 1 + self.poles.size
        poles, zeros = vector[1:split], vector[split:]
        shaped = poles.reshape(self.poles.shape), zeros.reshape(self.zeros.shape)
        return Sections(self.w0, float(vector[0]), *shaped)

    def bounds(self, band: tuple[float, float]) -> tuple[Array, Array]:
        """Least and largest parameters for a band [Hz]."""
        edges = np.log([2.0 * np.pi * f * factor for f, factor in zip(band, REACH, strict=True)])
        ends = []
        for k, sign in ((0, -1.0), (1, 1.0)):
            parts = [[sign * np.inf]]
            for pairs, damping in ((self.poles, DAMPING), (self.zeros, ZERO_DAMPING)):
                parts += [[edges[k]] * pairs.shape[1], [np.log(damping[k])] * pairs.shape[1]]
            ends.append(np.concatenate(parts))
        return ends[0], ends[1]

    def log_density(self, f: Array) -> tuple[Array, Array]:
        """Logarithm of the one-sided density at f [Hz], (F,), and derivatives, (F, parameters)."""
        w = 2.0 * np.pi * f
        pole, d_pole = _log_quadratic(w, self.poles)
        zero, d_zero = _log_quadratic(w, self.zeros)
        value = self.log_gain + 4.0 * np.log(w / self.w0) + zero.sum(1) - pole.sum(1)
        return value, np.hstack([np.ones((len(f), 1)), -d_pole, d_zero])

    def features(self, band: tuple[float, float]) -> Array:
        """Frequencies in the band that resolve every resonance and every notch [Hz]."""
        w, zeta = np.exp(np.hstack([self.poles, self.zeros]))
        near = 1.0 + np.sinh(np.linspace(-4.0, 4.0, 41))[:, None] * np.minimum(zeta, 0.03)
        f = (near * w).ravel() / (2.0 * np.pi)
        return f[(f >= band[0]) & (f <= band[1])]

    def realised(self) -> LinearFilter:
        """Filter in modal form: partial fractions over the poles p_i = sigma_i + i omega_i.

            d xi_i = p_i xi_i dt + c_i dW,   y = sum_i 2 Re(r_i xi_i)/c_i,   c_i^2 = -2 sigma_i

        In two real states for each pole, A is normal and block-diagonal, and the states have unit
        size.
        """
        wp, zp = np.exp(self.poles)
        wz, zz = np.exp(self.zeros)
        p = wp * (-zp + 1j * np.sqrt(1.0 - zp**2))
        quadratic = (p[:, None] / wp) ** 2 + 2.0 * zp * p[:, None] / wp + 1.0  # (pole, section)
        quadratic[np.diag_indices(len(p))] = 2j * p.imag / wp**2  # without its own root
        zero = (p[:, None] / wz) ** 2 + 2.0 * zz * p[:, None] / wz + 1.0
        gain = np.exp(0.5 * self.log_gain) / np.sqrt(2.0)  # a density is 2 |H|^2
        r = gain * (p / self.w0) ** 2 * zero.prod(axis=1) / quadratic.prod(axis=1)
        size = np.sqrt(-2.0 * p.real)
        A = np.zeros((self.order, self.order))
        even, odd = np.arange(0, self.order, 2), np.arange(1, self.order, 2)
        A[even, even] = A[odd, odd] = p.real
        A[even, odd], A[odd, even] = -p.imag, p.imag
        B = np.column_stack([size, np.zeros_like(size)]).reshape(-1, 1)
        C = np.column_stack([2.0 * r.real, -2.0 * r.imag]) / size[:, None]
        return LinearFilter(A, B, C.reshape(1, -1))


def _log_quadratic(w: Array, pairs: Array) -> tuple[Array, Array]:
    """log|1 - u^2 + 2 i zeta u|^2, u = w/w_i, (F, pairs), and its derivatives, (F, 2 pairs)."""
    u = w[:, None] / np.exp(pairs[0])
    a, b2 = 1.0 - u**2, (2.0 * np.exp(pairs[1]) * u) ** 2
    m = a**2 + b2
    by_zeta = 2.0 * b2 / m
    return np.log(m), np.hstack([4.0 * a * (1.0 - a) / m - by_zeta, by_zeta])


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
    return best


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
