"""Shaping filters as second-order sections.

    H(s) = g s^2 prod_j (s^2 + 2 xi_j w_j s + w_j^2) / prod_i (s^2 + 2 zeta_i w_i s + w_i^2)

up to a constant factor: each section is scaled to (s/w)^2 + 2 zeta s/w + 1.
"""

from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.portable import exp
from ftcfa.vibration.spectra.linear_filter import LinearFilter

DAMPING = (2e-3, 0.95)
"""Bounds of the damping of the poles; below 1 they stay complex and apart."""
ZERO_DAMPING = (1e-3, 3.0)
"""Bounds of the damping of the zeros."""
REACH = (1.0 / 6.0, 4.0)
"""Bounds of the frequencies of poles and zeros, relative to the edges of the band."""


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
        wp, zp = exp(self.poles)
        wz, zz = exp(self.zeros)
        p = -wp * zp, wp * np.sqrt(1.0 - zp * zp)
        gain = exp(np.array(0.5 * self.log_gain)) / np.sqrt(2.0)  # a density is 2 |H|^2
        at = p[0] / self.w0, p[1] / self.w0
        r = gain * (at[0] * at[0] - at[1] * at[1]), gain * (2.0 * at[0] * at[1])
        for w, zeta in zip(wz, zz, strict=True):
            r = _times(r, _quadratic(p, w, zeta))
        for i, (w, zeta) in enumerate(zip(wp, zp, strict=True)):
            own = np.arange(len(wp)) == i  # the section without its own root
            real, imaginary = _quadratic(p, w, zeta)
            section = (np.where(own, 0.0, real), np.where(own, 2.0 * p[1] / (w * w), imaginary))
            r = _over(r, section)
        size = np.sqrt(-2.0 * p[0])
        A = np.zeros((self.order, self.order))
        even, odd = np.arange(0, self.order, 2), np.arange(1, self.order, 2)
        A[even, even] = A[odd, odd] = p[0]
        A[even, odd], A[odd, even] = -p[1], p[1]
        B = np.column_stack([size, np.zeros_like(size)]).reshape(-1, 1)
        C = np.column_stack([2.0 * r[0], -2.0 * r[1]]) / size[:, None]
        return LinearFilter(A, B, C.reshape(1, -1))


Complex = tuple[Array, Array]
"""Real and imaginary part: NumPy's complex products depend on the processor."""


def _times(a: Complex, b: Complex) -> Complex:
    """The product a b."""
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _over(a: Complex, b: Complex) -> Complex:
    """The quotient a/b."""
    square = b[0] * b[0] + b[1] * b[1]
    real, imaginary = _times(a, (b[0], -b[1]))
    return real / square, imaginary / square


def _quadratic(p: Complex, w: float, zeta: float) -> Complex:
    """The section (p/w)^2 + 2 zeta p/w + 1."""
    u = p[0] / w, p[1] / w
    real = u[0] * u[0] - u[1] * u[1] + 2.0 * zeta * u[0] + 1.0
    return real, 2.0 * u[0] * u[1] + 2.0 * zeta * u[1]


def _log_quadratic(w: Array, pairs: Array) -> tuple[Array, Array]:
    """log|1 - u^2 + 2 i zeta u|^2, u = w/w_i, (F, pairs), and its derivatives, (F, 2 pairs)."""
    u = w[:, None] / np.exp(pairs[0])
    a, b2 = 1.0 - u**2, (2.0 * np.exp(pairs[1]) * u) ** 2
    m = a**2 + b2
    by_zeta = 2.0 * b2 / m
    return np.log(m), np.hstack([4.0 * a * (1.0 - a) / m - by_zeta, by_zeta])
