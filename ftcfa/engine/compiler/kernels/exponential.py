"""exp, expm1, sinh, cosh and tanh.

    x = n ln 2 + r,  |r| <= ln(2)/2,   e^x = 2^n e^r,   e^r = 1 + q,  q = r + r^2 p(r)

(Muller, Elementary Functions, 3rd ed. 2016, chapter 11). n ln 2 is subtracted in two parts with
fused multiply-adds, the first of them without rounding.
"""

from ftcfa.coefficients import EXPM1, LN2, LOG2_E
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.bits import (
    absolute,
    clamped,
    nearest_integer,
    polynomial,
    power_of_two,
    scaled,
    with_sign,
)

LEAST, MOST = -746.0, 711.0
"""Below, e^x is 0 in double precision; above, it is infinite."""
OVERFLOW = 710.0
"""e^x is infinite, and n is still 1024."""
ONE_IS_NOTHING = 40.0
"""e^-x is less than half a unit in the last place of 1."""
TINY = 2.0**-54
"""expm1(x) is x below."""


def exp(asm: Assembly, x: str) -> str:
    """e^x."""
    return _scaled_exp(asm, x, 0)


def expm1(asm: Assembly, x: str) -> str:
    """e^x - 1, without cancellation near zero.

    2 (2^(n-1) q + (2^(n-1) - 1/2)): half of 2^n does not overflow where e^x does not.
    """
    n, q = _reduced(asm, clamped(asm, x, -ONE_IS_NOTHING, OVERFLOW))
    half = power_of_two(asm, asm.integer("sub", n, asm.word(1)))
    value = asm.fma(half, q, asm.sub(half, asm.constant(0.5)))
    tiny = asm.compare("olt", absolute(asm, x), asm.constant(TINY))
    return asm.select(tiny, x, asm.add(value, value))


def sinh(asm: Assembly, x: str) -> str:
    """Compute (t + t/(t + 1))/2 with t = expm1(|x|), or e^|x|/2 for large |x|."""
    size = absolute(asm, x)
    t = expm1(asm, clamped(asm, size, 0.0, ONE_IS_NOTHING))
    small = asm.add(t, asm.div(t, asm.add(t, asm.constant(1.0))))
    large = asm.compare("ogt", size, asm.constant(ONE_IS_NOTHING))
    half = asm.mul(asm.constant(0.5), small)
    return with_sign(asm, asm.select(large, _scaled_exp(asm, size, -1), half), x)


def cosh(asm: Assembly, x: str) -> str:
    """Compute h + 1/(4 h) with h = e^|x|/2."""
    h = _scaled_exp(asm, absolute(asm, x), -1)
    return asm.add(h, asm.div(asm.constant(0.25), h))


def tanh(asm: Assembly, x: str) -> str:
    """Compute t/(t + 2) with t = expm1(2 |x|) = 2^n q + (2^n - 1), all in two parts."""
    size = clamped(asm, absolute(asm, x), 0.0, ONE_IS_NOTHING)
    n, r, square = _reduced_parts(asm, asm.add(size, size))
    q = asm.add(r, square)
    power, two = power_of_two(asm, n), asm.constant(2.0)
    base = asm.sub(power, asm.constant(1.0))
    t = asm.fma(power, q, base)
    t_low = asm.fma(power, q, asm.sub(base, t))  # exact: |2^n - 1| is 0 or above |2^n q|
    t_low = asm.fma(power, asm.add(asm.sub(r, q), square), t_low)
    d = asm.add(t, two)
    d_low = asm.add(asm.sub(two, d), t)
    inverse = asm.div(asm.constant(1.0), d)
    ratio = asm.mul(t, inverse)
    minus = asm.negative(ratio)
    rest = asm.add(asm.fma(minus, asm.add(d_low, t_low), asm.fma(minus, d, t)), t_low)
    return with_sign(asm, asm.fma(rest, inverse, ratio), x)


def _scaled_exp(asm: Assembly, x: str, shift: int) -> str:
    """e^x 2^shift."""
    n, q = _reduced(asm, clamped(asm, x, LEAST, MOST))
    n = asm.integer("add", n, asm.word(shift)) if shift else n
    return scaled(asm, asm.add(q, asm.constant(1.0)), n)


def _reduced(asm: Assembly, x: str) -> tuple[str, str]:
    """The word n and q = e^r - 1."""
    n, r, square = _reduced_parts(asm, x)
    return n, asm.add(r, square)


def _reduced_parts(asm: Assembly, x: str) -> tuple[str, str, str]:
    """The word n, r, and r^2 p(r): e^r - 1 is their sum."""
    k, n = nearest_integer(asm, x, LOG2_E)
    r = asm.fma(k, asm.constant(-LN2[0]), x)
    r = asm.fma(k, asm.constant(-LN2[1]), r)
    return n, r, asm.mul(asm.mul(r, r), polynomial(asm, EXPM1, r))
