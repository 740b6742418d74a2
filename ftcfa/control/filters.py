"""Command filters: they track a virtual control alpha and give its derivative, (6).

    psi1' = zeta,   zeta = -r1 sig(psi1 - alpha, 1/2) + psi2,   psi2' = -r2 sign(psi1 - alpha)

This is Levant's first-order differentiator (Levant 2003, Int. J. Control 76). Its two
discretisations differ greatly: the explicit one limit-cycles with amplitude (r1 h / 2)^2, the
implicit one does not.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ftcfa.arrays import Array, positive
from ftcfa.control.fractional import sig
from ftcfa.errors import UnknownNameError


class FilterState(NamedTuple):
    """State of a command filter."""

    psi1: Array
    """Filtered signal, shape (n,) [rad/s]."""
    psi2: Array
    """Integral part of its derivative, shape (n,) [rad/s^2]."""


class CommandFilter(Protocol):
    """A filter with state; its output is abar, the filtered virtual control."""

    def init(self, alpha: Array) -> FilterState:
        """At rest on the first input."""
        ...

    def step(self, state: FilterState, alpha: Array, period: float) -> tuple[Array, FilterState]:
        """Filter one sample: (abar at this sample, new state)."""
        ...


@dataclass(frozen=True)
class _LevantFilter(ABC):
    """The gains that both discretisations share.

    Attributes:
        r1: Gain of the root term, (6) [rad^(1/2)/s].
        r2: Gain of the sign term, (6) [rad/s^3]; for |alpha''| <= L: r1 = 1.5 sqrt(L), r2 = 1.1 L.
    """

    r1: float = 750.0
    r2: float = 180.0

    def __post_init__(self) -> None:
        for name in ("r1", "r2"):
            positive(f"filter gain {name}", getattr(self, name))

    def init(self, alpha: Array) -> FilterState:
        """psi1(0) = alpha(0), psi2(0) = 0."""
        return FilterState(alpha, np.zeros_like(alpha))

    @abstractmethod
    def step(self, state: FilterState, alpha: Array, period: float) -> tuple[Array, FilterState]:
        """Filter one sample: (abar at this sample, new state)."""


@dataclass(frozen=True)
class ExplicitFilter(_LevantFilter):
    """Explicit Euler, as most simulations of (6) do it; needs h of 0.1 ms at the paper's gains."""

    def step(self, state: FilterState, alpha: Array, period: float) -> tuple[Array, FilterState]:
        """Output psi1 of this sample; psi1 + h zeta becomes the next."""
        error = state.psi1 - alpha
        zeta = -self.r1 * sig(error, 0.5) + state.psi2
        psi2 = state.psi2 - period * self.r2 * np.sign(error)
        return state.psi1, FilterState(state.psi1 + period * zeta, psi2)


@dataclass(frozen=True)
class ImplicitFilter(_LevantFilter):
    """Implicit Euler, solved in closed form: no chatter at any period.

    With b = psi1 - alpha + h psi2 (old psi2):

        |b| <= h^2 r2:  psi1 <- alpha,                psi2 <- psi2 - b/h
        otherwise:      psi1 <- alpha + sign(b) y^2,  psi2 <- psi2 - h r2 sign(b)
                        y = (-h r1 + sqrt(h^2 r1^2 + 4 (|b| - h^2 r2))) / 2
    """

    def step(self, state: FilterState, alpha: Array, period: float) -> tuple[Array, FilterState]:
        """Output the new psi1: the filter follows alpha without delay."""
        b = state.psi1 - alpha + period * state.psi2
        excess = np.maximum(np.abs(b) - period**2 * self.r2, 0.0)
        damping = period * self.r1
        y = (np.sqrt(damping**2 + 4.0 * excess) - damping) / 2.0
        psi1 = alpha + np.sign(b) * y**2
        slide = np.where(excess > 0.0, period * self.r2 * np.sign(b), b / period)
        psi2 = state.psi2 - slide
        return psi1, FilterState(psi1, psi2)


FILTERS: dict[str, type[_LevantFilter]] = {"implicit": ImplicitFilter, "explicit": ExplicitFilter}
"""Command filters by name."""


def command_filter(choice: "str | CommandFilter") -> CommandFilter:
    """A filter, or the one of that name with the paper's gains.

    Raises:
        UnknownNameError: If there is none of that name.
    """
    if not isinstance(choice, str):
        return choice
    if choice not in FILTERS:
        raise UnknownNameError("filter", choice, list(FILTERS))
    return FILTERS[choice]()
