"""Theorem 1 in numbers, with the steps of its proof repaired.

n joints; z1 = q - q_d is the tracking error (5), kappa the fractional power of the gains, v1, v2,
s1, s2 and thetahat are those of the controller (9), (10), (12). With p = (3 + kappa)/4 and a weight
w_s on the error compensation, the Lyapunov function and its generator satisfy

    V  = |v1|^4/4 + |v2|^4/4 + (theta - thetahat)^2/(2 lambda) + w_s (|s1|^4 + |s2|^4)/4
    LV <= -Delta V^p + Gamma                                                              (30)

if the gains meet `Bounds.conditions` and if at every state that is visited the network covers the
unknown dynamics, phihat <= sqrt(theta B^T B) + eps, and the filter error is at most pi1. The user
supplies theta, eps and pi1, as in the paper.
"""

from dataclasses import dataclass, replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.ftcf import FTCF
from ftcfa.theory.gain_conditions import (
    Condition,
    compensation_coefficient,
    filter_bound,
    gain_conditions,
)

LEAST_WEIGHT, LARGEST_WEIGHT, WEIGHTS = 0.3, 1e6, 301
"""Grid of the search for the weight with the least bound of |z1|; it may fall without end."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """The bounds that Theorem 1 gives for one loop.

    `dataclasses.replace` gives them for another weight, sigma or premise.

    Attributes:
        law: The controller.
        theta: Bound of the squared norm of the network's weights, as supplied.
        eps: Largest error of the network, as supplied.
        pi1: Largest filter error |abar - alpha|, as supplied [rad/s].
        sigma: Share of Delta that the bound of the first-entry time uses, 0 < sigma < 1.
        weight: w_s.
        Mmin: Smallest eigenvalue of the nominal M over the joint range [kg m^2 or kg].
        Mmax: Largest eigenvalue of the nominal M over the joint range [kg m^2 or kg].
        etabar: Largest |sat(u) - eta(u)|, shape (n,) [N m or N].
        V0: V at the loop's initial state.
        joint_range: Length of the diagonal of the joint range [rad]; no two postures are farther
            apart.
    """

    law: FTCF
    theta: float
    eps: float
    pi1: float
    sigma: float
    weight: float
    Mmin: float
    Mmax: float
    etabar: Array
    V0: float
    joint_range: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.etabar)

    @property
    def kappa(self) -> float:
        """Fractional power of the controller."""
        return self.law.gains.kappa

    @property
    def p(self) -> float:
        """Power of V in (30), (3 + kappa)/4."""
        return (3 + self.kappa) / 4

    @property
    def s(self) -> float:
        """Coefficient of the error compensation: see `compensation_coefficient`."""
        return compensation_coefficient(self.n, self.kappa, self.weight)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Conditions on the gains; Theorem 1 applies only if all that are needed hold."""
        return gain_conditions(self.n, self.law.gains, self.weight, self.law.filter)

    @property
    def filter_bound(self) -> float | None:
        """Largest |alpha''| that the filter follows exactly [rad/s^3], or None: `filter_bound`."""
        return filter_bound(self.law.filter)

    @property
    def applies(self) -> bool:
        """Whether the gains meet all conditions that the theorem needs."""
        return not self._failed

    @property
    def _failed(self) -> list[Condition]:
        return [each for each in self.conditions if each.needed and not each.holds]

    @property
    def Delta_terms(self) -> dict[str, float]:
        """The rates of which Delta is the least, by name."""
        g, p, w = self.law.gains, self.p, self.weight
        share = g.kappa / (g.kappa + 3)
        return {
            "4^p c1 kappa/(kappa+3)": 4**p * g.c1 * share,
            "4^p c2 kappa/(kappa+3)": 4**p * g.c2 * share,
            "(4/w_s)^p c1 s": (4 / w) ** p * g.c1 * self.s,
            "(4/w_s)^p c2 s": (4 / w) ** p * g.c2 * self.s,
            "iota": g.iota,
        }

    @property
    def Gamma_terms(self) -> dict[str, float]:
        """The terms of which Gamma is the sum, by name."""
        g, p = self.law.gains, self.p
        learning = g.iota * (1 - p) * p ** (p / (1 - p)) if p < 1 else 0.0
        return {
            "saturation": float(np.sum(self.etabar**2) ** 2 / (4 * self.Mmin**4)),
            "tau": g.tau,
            "network error": self.eps**2,
            "filter error": self.weight * self.pi1**4 / 4,
            "network weights": g.iota * self.theta**2 / (2 * g.lambda_),
            "fractional power": learning,
        }

    @property
    def Delta(self) -> float:
        """Rate of decay in (30)."""
        return min(self.Delta_terms.values())

    @property
    def Gamma(self) -> float:
        """Constant in (30)."""
        return sum(self.Gamma_terms.values())

    @property
    def largest_term(self) -> str:
        """Name of the largest term of Gamma."""
        return max(self.Gamma_terms, key=lambda name: self.Gamma_terms[name])

    @property
    def Vinf(self) -> float:
        """Level that V reaches in expected finite time, (Gamma/((1 - sigma) Delta))^(1/p)."""
        return self._level(self.Gamma)

    @property
    def ultimate_error(self) -> float:
        """Bound of |z1| where V <= Vinf [rad].

            |z1| <= |v1| + |s1| <= (4 Vinf)^(1/4) (1 + w_s^(-1/3))^(3/4)

        by Hoelder, since |v1|^4 + w_s |s1|^4 <= 4 Vinf; for w_s = 1 its square is
        4 sqrt(2) sqrt(Vinf).
        """
        return _largest_error(self.Vinf, self.weight)

    @property
    def error_without_largest_term(self) -> float:
        """Bound of |z1| if the largest term of Gamma were zero [rad]."""
        rest = (value for name, value in self.Gamma_terms.items() if name != self.largest_term)
        return _largest_error(self._level(sum(rest)), self.weight)

    @property
    def first_entry(self) -> float:
        """Bound of the expected time at which V first falls to Vinf [s]; 0 if V0 <= Vinf.

            E T <= (V0^(1-p) - Vinf^(1-p)) / ((1 - p) sigma Delta)

        and log(V0/Vinf)/(sigma Delta) for kappa = 1. This is the T of the paper with another
        meaning: by (30), L V^(1-p)/(1-p) <= -Delta + Gamma V^-p <= -sigma Delta while V >= Vinf.
        After the first entry V may exceed Vinf again.
        """
        if not self.applies:
            return np.inf
        if self.Vinf >= self.V0:
            return 0.0
        rest = 1 - self.p
        ratio = self.Vinf / self.V0
        fall = -np.expm1(rest * np.log(ratio)) / rest if rest > 0 else -np.log(ratio)
        return float(self.V0**rest * fall / (self.sigma * self.Delta))

    def time_average(self, t: float) -> float:
        """Bound of the time average of E V^p over [0, t] [s], Gamma/Delta + V0/(Delta t)."""
        return (self.Gamma + self.V0 / t) / self.Delta if self.applies else np.inf

    def best_weight(self) -> tuple[float, float]:
        """Weight up to LARGEST_WEIGHT with the least bound of |z1|, and that bound [rad].

        Without a filter error the bound falls with the weight towards (4 Vinf)^(1/4) and has no
        least value: the compensation then stays zero and z1 = v1.
        """
        weights = np.geomspace(LEAST_WEIGHT, LARGEST_WEIGHT, WEIGHTS)
        errors = [replace(self, weight=float(w)).ultimate_error for w in weights]
        best = int(np.argmin(errors))
        return float(weights[best]), errors[best]

    @property
    def informative(self) -> bool:
        """Whether the bound of |z1| excludes any posture: it is smaller than the joint range."""
        return self.ultimate_error < self.joint_range

    @property
    def verdict(self) -> str:
        """Result of the theorem for this loop, in a few sentences."""
        if self._failed:
            reasons = " and ".join(
                f"{each.name} = {each.value:.4g} is not {each.relation} {each.required:.4g}"
                for each in self._failed
            )
            return f"Theorem 1 does not apply: {reasons}."
        share = self.Gamma_terms[self.largest_term] / self.Gamma
        sentences = [
            f"If theta, eps and pi1 are right, |z1| <= {self.ultimate_error:.3g} rad "
            "where V <= Vinf."
        ]
        if not self.informative:
            sentences.append(
                "This bound is true but says nothing about this arm: no two of its postures are "
                f"more than {self.joint_range:.3g} rad apart."
            )
        sentences.append(
            f"The largest term of Gamma is the {self.largest_term} term, {100 * share:.4g} % of "
            f"it; without it the bound is {self.error_without_largest_term:.3g} rad."
        )
        if self.first_entry == 0:
            sentences.append("V <= Vinf from the start, so there is no first-entry time to bound.")
        else:
            sentences.append(f"On average, V first falls to Vinf within {self.first_entry:.3g} s.")
        return " ".join(sentences)

    def _level(self, Gamma: float) -> float:
        if not self.applies:
            return np.inf
        return float((Gamma / ((1 - self.sigma) * self.Delta)) ** (1 / self.p))


def _largest_error(V: float, weight: float) -> float:
    """Largest |v1| + |s1| where |v1|^4 + w_s |s1|^4 <= 4 V [rad]."""
    return float((4 * V) ** 0.25 * (1 + weight ** (-1 / 3)) ** 0.75)
