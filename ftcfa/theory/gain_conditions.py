"""The conditions of Theorem 1 on the gains, repaired, for any number of joints.

The paper adds V2 and Vbar, the Lyapunov functions of the compensated errors and of the error
compensation. Repaired, Vbar needs a weight w_s > 1/4, and all conditions depend on it.
"""

from dataclasses import dataclass

import numpy as np

from ftcfa.control.filters import CommandFilter, ExplicitFilter, ImplicitFilter
from ftcfa.control.gains import Gains
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.theory.assumptions import ftcf_of

ROUNDING = 1e-12
"""Relative tolerance of a condition; the paper's k2 = 1/3 meets its condition with equality."""


@dataclass(frozen=True)
class Condition:
    """One condition on the gains: a quantity and its lower limit.

    Attributes:
        name: The quantity.
        value: Its value.
        required: Its lower limit.
        replaces: The printed inequality that this one replaces, and why.
        strict: Whether the value must be larger than the limit; if not, it may be equal.
        needed: Whether the theorem needs this condition. The filter's only keeps pi1 small.
    """

    name: str
    value: float
    required: float
    replaces: str
    strict: bool = False
    needed: bool = True

    @property
    def relation(self) -> str:
        """Relation that must hold between value and limit, ``>`` or ``>=``."""
        return ">" if self.strict else ">="

    @property
    def holds(self) -> bool:
        """Whether the gains meet the condition."""
        if self.strict:
            return self.value > self.required
        return self.value >= self.required * (1 - ROUNDING)


def gain_conditions(
    n: int, gains: Gains, weight: float, command_filter: CommandFilter | str
) -> tuple[Condition, ...]:
    """All conditions on the gains of a loop of n joints.

        k1 >= 3/2 w_s/(w_s - 1/4),   k2 >= 1/4 w_s/(w_s - 1/4),   s > 0

    and r1 >= 1.5 sqrt(L) for the filter, which only keeps pi1 small. k1 and k2 are the smallest of
    the joints.
    """
    w, k1, k2 = weight, float(np.min(gains.k1)), float(np.min(gains.k2))
    s = compensation_coefficient(n, gains.kappa, w)
    lacking = "3/(kappa+3) of (29): (17) lacks the factor n^((1-kappa)/2)"
    conditions = [
        Condition("k1", k1, 1.5 * w / (w - 0.25), "k1 = 2, which is for w_s = 1 (28)"),
        Condition("k2", k2, 0.25 * w / (w - 0.25), "k2 = 1/3, which is for w_s = 1 (28)"),
        Condition("s", s, 0.0, lacking, strict=True),
    ]
    L = filter_bound(command_filter)
    if isinstance(command_filter, ImplicitFilter | ExplicitFilter) and L is not None:
        least = 1.5 * float(np.sqrt(L))
        rule = "Remark 2, which gives no number; r1 = 1.5 sqrt(L), r2 = 1.1 L"
        conditions.append(Condition("r1", command_filter.r1, least, rule, needed=False))
    return tuple(conditions)


def filter_bound(command_filter: CommandFilter | str) -> float | None:
    """Largest |alpha''| at which the filter still follows alpha exactly, L = r2/1.1 [rad/s^3].

    None for a filter that Lemma 7 does not cover. White noise in v leaves alpha'' unbounded.
    """
    if isinstance(command_filter, ImplicitFilter | ExplicitFilter):
        return command_filter.r2 / 1.1
    return None


def compensation_coefficient(n: int, kappa: float, weight: float) -> float:
    """Coefficient of the error compensation in (28), which must be positive.

        s = w_s - kappa N^(1+3/kappa)/(kappa+3),   N = n^((1-kappa)/2)

    for n joints, the fractional power kappa and the weight w_s.
    """
    N = n ** ((1 - kappa) / 2)
    return float(weight - kappa * N ** (1 + 3 / kappa) / (kappa + 3))


def default_weight(n: int, gains: Gains) -> float:
    """Weight w_s that `ftcfa.bounds` takes if none is given.

    It is the paper's 1 where s >= kappa/(kappa+3), so that Delta does not become smaller. If s is
    smaller, it is the weight with s = 3/(kappa+3), the paper's coefficient in (29). Where k1 or k2
    needs a heavier weight, it is that one: k1 > 3/2 needs w_s >= k1/4/(k1 - 3/2), and k2 > 1/4
    needs w_s >= k2/4/(k2 - 1/4).
    """
    s = compensation_coefficient(n, gains.kappa, 1.0)
    w = 1.0 if s >= gains.kappa / (gains.kappa + 3) else 1.0 - s + 3 / (gains.kappa + 3)
    for k, least in ((float(np.min(gains.k1)), 1.5), (float(np.min(gains.k2)), 0.25)):
        if k > least:
            needed = 0.25 * k / (k - least)
            w = needed if needed > w * (1 + ROUNDING) else w
    return w


def gain_shortfall(loop: ClosedLoop) -> float:
    """By how much the gains of the paper's law miss Theorem 1's conditions, relative; else 0.

    Handed to `ftcfa.tune` as its ``condition``, it keeps a search to gains for which the theorem
    holds. The weight w_s is that of `default_weight`.

    Raises:
        ParameterError: If the loop's law is not the paper's.
    """
    law = ftcf_of(loop)
    n, gains = loop.arm.n, law.gains
    conditions = gain_conditions(n, gains, default_weight(n, gains), law.filter)
    missed = [it for it in conditions if it.needed and not it.holds]
    return sum((it.required - it.value) / max(it.required, 1.0) + ROUNDING for it in missed)
