"""What Theorem 1 promises of a loop, in numbers, with the proof's steps repaired.

With p = (3 + kappa)/4, N = n^((1 - kappa)/2) and a weight w_s on the error compensation,

    V  = |v1|^4/4 + |v2|^4/4 + (theta - thetahat)^2/(2 lambda) + w_s (|s1|^4 + |s2|^4)/4
    LV <= -Delta V^p + Gamma                                                              (30)

holds if the gain conditions of `Bounds.conditions` do and if at every state that is visited the
network covers what it stands for, phihat <= sqrt(theta B^T B) + eps, and the filter error stays
below pi1. theta, eps and pi1 are the user's to supply, as in the paper.
"""

from dataclasses import dataclass, replace

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import probability
from ftcfa.control.filters import ExplicitFilter, ImplicitFilter
from ftcfa.control.ftcf import FTCF, Gains
from ftcfa.control.protocol import Desired
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import joint_box, mass_matrix_bounds
from ftcfa.theory.generator import check_white, paper_law

ROUNDING = 1e-12
"""Relative; the paper's k2 = 1/3 meets its condition with equality."""
LEAST_WEIGHT, LARGEST_WEIGHT, WEIGHTS = 0.3, 1e6, 301
"""Of the search for the weight with the least bound of |z1|, which may fall for ever."""


@dataclass(frozen=True)
class Condition:
    """One condition on the gains.

    Attributes:
        name: What must be large enough.
        value: What it is.
        required: What it must be, at least.
        replaces: The printed inequality in whose place it stands, and why.
        strict: Whether it must be larger.
        needed: Whether the theorem says nothing without it. The filter's only keeps pi1 small.
    """

    name: str
    value: float
    required: float
    replaces: str
    strict: bool = False
    needed: bool = True

    @property
    def relation(self) -> str:
        """What value and required must be to each other."""
        return ">" if self.strict else ">="

    @property
    def holds(self) -> bool:
        """Whether the gains meet it."""
        if self.strict:
            return self.value > self.required
        return self.value >= self.required * (1 - ROUNDING)


@dataclass(frozen=True, eq=False)
class Bounds:
    """Theorem 1 for one loop; with another weight or sigma, `dataclasses.replace` it.

    Attributes:
        law: The controller.
        theta: Bound of the squared norm of the network's weights, as supplied.
        eps: Largest error of the network, as supplied.
        pi1: Largest filter error, as supplied [rad/s].
        sigma: Share of Delta that the first-entry time is bought with, 0 < sigma < 1.
        weight: w_s.
        Mmin: Smallest eigenvalue of the nominal M over the joint range [kg m^2 or kg].
        Mmax: Largest.
        etabar: Largest |sat(u) - eta(u)|, shape (n,) [N m or N].
        V0: V at the loop's initial state.
        reach: Diagonal of the joint range [rad]: no two postures are farther apart.
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
    reach: float

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.etabar)

    @property
    def kappa(self) -> float:
        """Fractional power."""
        return self.law.gains.kappa

    @property
    def s(self) -> float:
        """Coefficient of the compensation in (28), w_s - kappa N^(1+3/kappa)/(kappa+3)."""
        return margin(self.n, self.kappa, self.weight)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """On the gains; Theorem 1 says nothing unless all that are needed hold."""
        g, w = self.law.gains, self.weight
        lacking = "3/(kappa+3) of (29): (17) lacks the factor n^((1-kappa)/2)"
        found = [
            Condition("k1", g.k1, 1.5 * w / (w - 0.25), "k1 = 2, which is for w_s = 1 (28)"),
            Condition("k2", g.k2, 0.25 * w / (w - 0.25), "k2 = 1/3, which is for w_s = 1 (28)"),
            Condition("s", self.s, 0.0, lacking, strict=True),
        ]
        if self._levant is not None and self.filter_reach is not None:
            needed = 1.5 * float(np.sqrt(self.filter_reach))
            rule = "Remark 2, which gives no number; r1 = 1.5 sqrt(L), r2 = 1.1 L"
            found.append(Condition("r1", self._levant.r1, needed, rule, needed=False))
        return tuple(found)

    @property
    def filter_reach(self) -> float | None:
        """L = r2/1.1, the |alpha''| up to which the filter follows alpha exactly [rad/s^3].

        None for a filter that Lemma 7 does not speak of. White noise gives alpha'' no bound.
        """
        return None if self._levant is None else self._levant.r2 / 1.1

    @property
    def _levant(self) -> ImplicitFilter | ExplicitFilter | None:
        used = self.law.filter
        return used if isinstance(used, ImplicitFilter | ExplicitFilter) else None

    @property
    def Delta_terms(self) -> dict[str, float]:
        """What Delta is the least of, by name."""
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
        """What Gamma is the sum of, by name."""
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
    def applies(self) -> bool:
        """Whether the gains meet all conditions that the theorem needs."""
        return not self._failed

    @property
    def _failed(self) -> list[Condition]:
        return [each for each in self.conditions if each.needed and not each.holds]

    @property
    def p(self) -> float:
        """(3 + kappa)/4."""
        return (3 + self.kappa) / 4

    @property
    def Delta(self) -> float:
        """Rate of (30)."""
        return min(self.Delta_terms.values())

    @property
    def Gamma(self) -> float:
        """Constant of (30)."""
        return sum(self.Gamma_terms.values())

    @property
    def blame(self) -> str:
        """The largest term of Gamma."""
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
        return _error(self.Vinf, self.weight)

    @property
    def error_without_blame(self) -> float:
        """The same without the largest term of Gamma [rad]."""
        rest = (value for name, value in self.Gamma_terms.items() if name != self.blame)
        return _error(self._level(sum(rest)), self.weight)

    @property
    def first_entry(self) -> float:
        """Bound of the expected time at which V first falls to Vinf [s]; 0 if it begins there.

            E T <= (V0^(1-p) - Vinf^(1-p)) / ((1 - p) sigma Delta)

        and log(V0/Vinf)/(sigma Delta) for kappa = 1. The paper's T, reinterpreted: by (30),
        L V^(1-p)/(1-p) <= -Delta + Gamma V^-p <= -sigma Delta while V >= Vinf. It says nothing of
        the time after, at which V may leave again.
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
        """Bound of the time average of E V^p over [0, t], Gamma/Delta + V0/(Delta t).

        Args:
            t: Length of the time [s].
        """
        return (self.Gamma + self.V0 / t) / self.Delta if self.applies else np.inf

    @property
    def informative(self) -> bool:
        """Whether the bound of |z1| rules out any posture at all."""
        return self.ultimate_error < self.reach

    @property
    def verdict(self) -> str:
        """What the theorem says of this loop, in a few sentences."""
        if self._failed:
            told = " and ".join(
                f"{each.name} = {each.value:.4g} is not {each.relation} {each.required:.4g}"
                for each in self._failed
            )
            return f"Theorem 1 does not apply: {told}."
        given = "Where theta, eps and pi1 are right, the guarantee is"
        share = self.Gamma_terms[self.blame] / self.Gamma
        promise = f"|z1| <= {self.ultimate_error:.3g} rad"
        blame = (
            f"The {self.blame} term is to blame, {100 * share:.4g} % of Gamma; without it, "
            f"{self.error_without_blame:.3g} rad"
        )
        if self.informative:
            first = f"{given} true: {promise} where V <= Vinf. {blame}."
        else:
            first = (
                f"{given} true and not informative: {promise}, and no two postures of this arm "
                f"are more than {self.reach:.3g} rad apart. {blame}."
            )
        if self.first_entry == 0:
            return f"{first} The loop begins with V <= Vinf: the first-entry time says nothing."
        return f"{first} V first falls to Vinf after {self.first_entry:.3g} s at most, on average."

    def _level(self, Gamma: float) -> float:
        if not self.applies:
            return np.inf
        return float((Gamma / ((1 - self.sigma) * self.Delta)) ** (1 / self.p))


def bounds(
    loop: ClosedLoop,
    *,
    theta: float = 0.0,
    eps: float = 0.0,
    pi1: float = 0.0,
    sigma: float = 0.5,
    weight: float | None = None,
) -> Bounds:
    """Theorem 1 with its proof repaired, for any number of joints.

        Delta = min{ 4^p c_i kappa/(kappa+3), (4/w_s)^p c_i s, iota },
        Gamma = |etabar|^4/(4 Mmin^4) + tau + eps^2 + w_s pi1^4/4 + iota theta^2/(2 lambda)
                + iota (1-p) p^(p/(1-p)),
        s     = w_s - kappa N^(1+3/kappa)/(kappa+3)

    The effort limits of the plant and of the nominal arm may differ: etabar_i is the largest
    |sat(u) - eta(u)|, (1 - tanh 1) u* where they do not.

    Args:
        loop: With the paper's controller, whose nominal arm is an `Arm`.
        theta: Bound of |H|^2, the squared norm of the network's weights.
        eps: Largest error of the network, (24).
        pi1: Largest filter error |abar - alpha| [rad/s].
        sigma: Share of Delta that buys the first-entry time; the rest buys a small Vinf.
        weight: w_s; that of `default_weight` by default, which at the paper's gains is 1 for two
            joints and 2.56 for seven. A heavier one costs only through pi1, see `best_weight`.

    Raises:
        ParameterError: If the controller is not the paper's, a part of it is switched off, the
            noise is not white, or a number is out of range.
    """
    law = paper_law(loop)
    check_white(loop)
    for name, value in (("theta", theta), ("eps", eps), ("pi1", pi1)):
        if not (np.isfinite(value) and value >= 0):
            raise ParameterError(f"bounds {name}", repr(value), "a finite number >= 0")
    probability("bounds sigma", sigma)
    if weight is not None and not (np.isfinite(weight) and weight > 0.25):
        raise ParameterError("bounds weight", repr(weight), "a number > 1/4")
    nominal = law.nominal
    if not isinstance(nominal, Arm):
        got = f"a {type(nominal).__name__}"
        raise ParameterError("bounds nominal arm", got, "an Arm, which knows its joint range")
    Mmin, Mmax = mass_matrix_bounds(nominal)
    lower, upper = joint_box(nominal)
    return Bounds(
        law=law,
        theta=theta,
        eps=eps,
        pi1=pi1,
        sigma=sigma,
        weight=default_weight(loop.arm.n, law.gains) if weight is None else weight,
        Mmin=Mmin,
        Mmax=Mmax,
        etabar=saturation_gap(loop.arm.effort_limit, nominal.effort_limit),
        V0=_initial_value(loop, theta, law.gains.lambda_),
        reach=float(np.linalg.norm(upper - lower)),
    )


def margin(n: int, kappa: float, weight: float) -> float:
    """What w_s leaves of the compensation; it must be positive.

    s = w_s - kappa N^(1+3/kappa)/(kappa+3),   N = n^((1-kappa)/2)
    """
    N = n ** ((1 - kappa) / 2)
    return float(weight - kappa * N ** (1 + 3 / kappa) / (kappa + 3))


def default_weight(n: int, gains: Gains) -> float:
    """The weight of `bounds` unless another is asked for.

    The paper's 1 where s >= kappa/(kappa+3), so that Delta does not suffer, else the one with
    s = 3/(kappa+3), the paper's own coefficient in (29); heavier if only then k1 and k2 suffice:
    k1 > 3/2 needs w_s >= k1/4/(k1 - 3/2), k2 > 1/4 needs w_s >= k2/4/(k2 - 1/4).
    """
    s = margin(n, gains.kappa, 1.0)
    w = 1.0 if s >= gains.kappa / (gains.kappa + 3) else 1.0 - s + 3 / (gains.kappa + 3)
    for k, least in ((gains.k1, 1.5), (gains.k2, 0.25)):
        if k > least:
            needed = 0.25 * k / (k - least)
            w = needed if needed > w * (1 + ROUNDING) else w
    return w


def best_weight(found: Bounds) -> tuple[float, float]:
    """The weight up to LARGEST_WEIGHT with the least bound of |z1|, and that bound [rad].

    Without a filter error the bound falls with the weight for ever, towards (4 Vinf)^(1/4): the
    compensation then stays zero and z1 = v1.

    Args:
        found: Bounds at any weight.
    """
    weights = np.geomspace(LEAST_WEIGHT, LARGEST_WEIGHT, WEIGHTS)
    errors = [replace(found, weight=float(w)).ultimate_error for w in weights]
    best = int(np.argmin(errors))
    return float(weights[best]), errors[best]


def saturation_gap(actual: Array, believed: Array) -> Array:
    """Etabar: the largest |sat(u) - eta(u)| over all u, shape (n,) [N m or N].

    sat clips at the actual limit a, eta = b tanh(u/b) has the believed one b. The difference
    rises to a - b tanh(a/b) at u = a and falls to a - b far beyond.

    Args:
        actual: Effort limits of the plant, shape (n,).
        believed: Those of the nominal arm, shape (n,).
    """
    peak = actual - believed * np.tanh(actual / believed)
    return np.maximum(np.abs(peak), np.abs(actual - believed))


def _initial_value(loop: ClosedLoop, theta: float, lambda_: float) -> float:
    """V at the first sample, where s1 = s2 = 0."""
    desired = Desired(*(row[0] for row in loop.reference.at(np.zeros(1))))
    signals, _ = loop.control(loop.init(desired), desired)
    fourth = sum(float(signals[name] @ signals[name]) ** 2 for name in ("v1", "v2"))
    return fourth / 4 + (theta - float(signals["theta"])) ** 2 / (2 * lambda_)


def _error(V: float, weight: float) -> float:
    return float((4 * V) ** 0.25 * (1 + weight ** (-1 / 3)) ** 0.75)
