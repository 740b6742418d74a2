"""Command filters: they follow a virtual control alpha and give its derivative, (6).

    psi1' = zeta,   zeta = -r1 sig(psi1 - alpha, 1/2) + psi2,   psi2' = -r2 sign(psi1 - alpha)

This is Levant's first-order differentiator (Levant 2003, Int. J. Control 76), here with two
discretisations that differ greatly. The explicit one oscillates with amplitude (r1 h / 2)^2 on a
constant input. The implicit one does not, and its derivative is half a period late. The other
filters are a linear second-order one and Levant's second-order differentiator, whose discrete
derivative is not late.
"""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ftcfa.arrays import Joints, Traceable
from ftcfa.checks import Check, positive
from ftcfa.control.fractional import sig
from ftcfa.errors import UnknownNameError
from ftcfa.parts import Parameters, Part, number_fields

NEWTON_STEPS = 8
"""Steps to the root of the cubic. The start is less than three times the root; seven steps reach
it to rounding."""


class FilterState(NamedTuple):
    """State of a command filter with two integrators."""

    psi1: Traceable
    """Filtered signal, shape (n,) [rad/s]."""
    psi2: Traceable
    """Integral part of the derivative of psi1, shape (n,) [rad/s^2]."""


class ProperState(NamedTuple):
    """State of the second-order differentiator."""

    psi1: Traceable
    """Filtered signal, shape (n,) [rad/s]."""
    psi2: Traceable
    """Derivative of psi1 less h/2 psi3, shape (n,) [rad/s^2]."""
    psi3: Traceable
    """Integral part of the second derivative of psi1, shape (n,) [rad/s^3]."""


class CommandFilter(Protocol):
    """A filter with state; its output is abar, the filtered virtual control."""

    def init(self, alpha: Traceable) -> Any:
        """State at rest on the first input, shape (n,) [rad/s]."""
        ...

    def step(self, state: Any, alpha: Traceable, period: float) -> tuple[Traceable, Traceable, Any]:
        """Filter one sample: abar [rad/s], its derivative [rad/s^2] and the new state."""
        ...


def implicit_super_twisting(
    x: Traceable, nu: Traceable, r1: Joints, r2: Joints, period: float
) -> tuple[Traceable, Traceable]:
    """One implicit step of x' = -r1 sig(x, 1/2) + nu, nu' = -r2 sign(x), solved in closed form.

    With b = x + h nu:

        |b| <= h^2 r2:  x <- 0,              nu <- nu - b/h
        otherwise:      x <- sign(b) y^2,    nu <- nu - h r2 sign(b)
                        y = (-h r1 + sqrt(h^2 r1^2 + 4 (|b| - h^2 r2))) / 2

    It does not chatter at any period (Brogliato, Polyakov and Efimov 2020, IEEE Trans. Autom.
    Control 65).

    Args:
        x: Shape (n,).
        nu: Shape (n,).
        r1: Gain of the root term.
        r2: Gain of the sign term.
        period: h [s].

    Returns:
        x and nu after the step.
    """
    b = x + period * nu
    excess = np.maximum(np.abs(b) - period**2 * r2, 0.0)
    damping = period * r1
    y = (np.sqrt(damping**2 + 4.0 * excess) - damping) / 2.0
    slide = np.where(excess > 0.0, period * r2 * np.sign(b), b / period)
    return np.sign(b) * y**2, nu - slide


@dataclass(frozen=True)
class _LevantFilter(Part):
    """Gains and initial state of both discretisations of (6).

    Attributes:
        r1: Gain of the root term, (6) [rad^(1/2)/s^(3/2)].
        r2: Gain of the sign term, (6) [rad/s^3]; for |alpha''| <= L: r1 = 1.5 sqrt(L), r2 = 1.1 L.
    """

    r1: Annotated[float, Check(positive, "rad^(1/2)/s^(3/2)", (10.0, 1e4))] = 750.0
    r2: Annotated[float, Check(positive, "rad/s^3", (1.0, 1e5))] = 180.0

    varies: ClassVar[Parameters] = number_fields("r1", "r2")

    def init(self, alpha: Traceable) -> FilterState:
        """psi1(0) = alpha(0), psi2(0) = 0."""
        return FilterState(alpha, np.zeros_like(alpha))


@dataclass(frozen=True)
class ExplicitFilter(_LevantFilter):
    """Explicit Euler step of (6), as in most simulations; the paper's gains need h <= 0.1 ms."""

    def step(
        self, state: FilterState, alpha: Traceable, period: float
    ) -> tuple[Traceable, Traceable, FilterState]:
        """Filter one sample: psi1 and zeta at it; the new psi1 is psi1 + h zeta."""
        error = state.psi1 - alpha
        zeta = -self.r1 * sig(error, 0.5) + state.psi2
        psi2 = state.psi2 - period * self.r2 * np.sign(error)
        return state.psi1, zeta, FilterState(state.psi1 + period * zeta, psi2)


@dataclass(frozen=True)
class ImplicitFilter(_LevantFilter):
    """Implicit Euler step of (6), solved in closed form: it does not chatter at any period.

    It is `implicit_super_twisting` with x = psi1 - alpha and nu = psi2. Once psi1 = alpha, the
    derivative is the backward difference, which is half a period late.
    """

    def step(
        self, state: FilterState, alpha: Traceable, period: float
    ) -> tuple[Traceable, Traceable, FilterState]:
        """Filter one sample: the new psi1, which is not late, and zeta of the step."""
        error, psi2 = implicit_super_twisting(
            state.psi1 - alpha, state.psi2, self.r1, self.r2, period
        )
        psi1 = alpha + error
        return psi1, (psi1 - state.psi1) / period, FilterState(psi1, psi2)


@dataclass(frozen=True)
class SecondOrderFilter(Part):
    """Linear filter of second order (Farrell et al. 2009, [8] of the paper).

        psi1' = psi2,   psi2' = -2 zeta omega psi2 - omega^2 (psi1 - alpha)

    by implicit Euler steps, which are stable at any period. It lags alpha by 2 zeta/omega. We did
    not have [8]; the equations are those that the literature gives for it.

    Attributes:
        omega: Natural frequency [rad/s]; ten times the laws' velocity rate by default.
        zeta: Damping ratio.
    """

    omega: Annotated[float, Check(positive, "rad/s", (10.0, 3000.0))] = 265.0
    zeta: Annotated[float, Check(positive)] = 1.0

    varies: ClassVar[Parameters] = number_fields("omega", "zeta")

    def init(self, alpha: Traceable) -> FilterState:
        """psi1(0) = alpha(0), psi2(0) = 0."""
        return FilterState(alpha, np.zeros_like(alpha))

    def step(
        self, state: FilterState, alpha: Traceable, period: float
    ) -> tuple[Traceable, Traceable, FilterState]:
        """Filter one sample: the new psi1 and psi2."""
        pull = period * self.omega
        psi2 = (state.psi2 - pull * self.omega * (state.psi1 - alpha)) / (
            1.0 + 2.0 * self.zeta * pull + pull**2
        )
        psi1 = state.psi1 + period * psi2
        return psi1, psi2, FilterState(psi1, psi2)


@dataclass(frozen=True)
class ProperFilter(Part):
    """Levant's second-order differentiator, implicit, with an output that is not late.

        psi1' = -2 L^(1/3) sig(e, 2/3) + psi2,   e = psi1 - alpha
        psi2' = -2.12 L^(2/3) sig(e, 1/3) + psi3
        psi3' = -1.1 L sign(e)

    for |alpha'''| <= L (gains: Levant 2003, Int. J. Control 76). Implicit Euler solves

        e + h k1 sig(e, 2/3) + h^2 k2 sig(e, 1/3) + h^3 k3 sign(e) = b,
        b = psi1 - alpha + h psi2 + h^2 psi3  (old)

    a cubic in |e|^(1/3), by Newton's method. psi2 is late by half a period, like any backward
    difference, an error of h alpha''/2. Seeber (2024, "Proper implicit discretization of
    arbitrary-order robust exact differentiators", arXiv 2404.02770) shows that the outputs must
    be linear combinations of the states; for this order

        zeta = psi2 + h/2 psi3

    is exact on parabolas and otherwise within h^2 L/3. (We had the abstract of that article alone;
    the coefficient 1/2 is the one that makes zeta exact on parabolas.)

    Attributes:
        L: Bound of |alpha'''| [rad/s^4].
    """

    L: Annotated[float, Check(positive, "rad/s^4", (1e2, 1e9))] = 1e6

    varies: ClassVar[Parameters] = number_fields("L")

    def init(self, alpha: Traceable) -> ProperState:
        """psi1(0) = alpha(0), psi2(0) = psi3(0) = 0."""
        zero = np.zeros_like(alpha)
        return ProperState(alpha, zero, zero)

    def step(
        self, state: ProperState, alpha: Traceable, period: float
    ) -> tuple[Traceable, Traceable, ProperState]:
        """Filter one sample: the new psi1 and zeta."""
        h, root = period, self.L ** (1.0 / 3.0)
        k1, k2, k3 = 2.0 * root, 2.12 * root**2, 1.1 * self.L
        b = state.psi1 - alpha + h * (state.psi2 + h * state.psi3)
        excess = np.maximum(np.abs(b) / h**3 - k3, 0.0)
        w = _root_of_cubic(k1, k2, excess)  # |e|^(1/3) / h
        sign = np.where(excess > 0.0, np.sign(b), b / (h**3 * k3))
        psi3 = state.psi3 - h * k3 * sign
        psi2 = state.psi2 + h * (psi3 - k2 * h * w * sign)
        psi1 = alpha + (h * w) ** 3 * np.sign(b)
        return psi1, psi2 + h / 2.0 * psi3, ProperState(psi1, psi2, psi3)


def _root_of_cubic(k1: float, k2: float, c: Traceable) -> Traceable:
    """The root w >= 0 of w^3 + k1 w^2 + k2 w = c for c >= 0, shape (n,).

    Each term alone gives an upper bound. Newton's method starts at the least of them and descends,
    since the cubic is convex there.
    """
    w = np.minimum(np.minimum(sig(c, 1.0 / 3.0), np.sqrt(c / k1)), c / k2)
    for _ in range(NEWTON_STEPS):
        w = w - (((w + k1) * w + k2) * w - c) / ((3.0 * w + 2.0 * k1) * w + k2)
    return w


FILTERS: dict[str, type[CommandFilter]] = {
    "implicit": ImplicitFilter,
    "explicit": ExplicitFilter,
    "second-order": SecondOrderFilter,
    "proper": ProperFilter,
}
"""Name to command filter."""


def command_filter(choice: "str | CommandFilter") -> CommandFilter:
    """The filter itself, or the filter of a name with its default gains.

    Raises:
        UnknownNameError: If there is no filter of that name.
    """
    if not isinstance(choice, str):
        return choice
    if choice not in FILTERS:
        raise UnknownNameError("filter", choice, FILTERS, field="filter")
    return FILTERS[choice]()


def leaky_step(x: Traceable, rate: Joints, drive: Traceable, period: float) -> Traceable:
    """One Euler step of x' = -rate x + drive with implicit decay, stable for any rate >= 0."""
    return (x + period * drive) / (1.0 + period * rate)
