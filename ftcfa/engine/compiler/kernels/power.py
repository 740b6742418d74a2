"""y^a = 2^(a log2 y), with the logarithm in two parts: more than 60 bits.

    s = f/(2 + f) = s_h + s_l,   log2(m) = 2 s/ln 2 + s z p(z)/ln 2   (see `logarithm`)
    a (n + log2 m) = k + r,  |r| <= 1/2,   2^r = 1 + r p(r)

As exp(a log y) in single parts, the error would grow to hundreds of units in the last place.
"""

from collections.abc import Callable

from ftcfa.coefficients import EXP2, INVERSE_LN2, LOG_LONG, TWO_OVER_LN2, TWO_THIRDS
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.bits import (
    INFINITY,
    NAN,
    absolute,
    clamped,
    double_of,
    nearest_integer,
    polynomial,
    power_of_two,
    scaled,
    with_sign,
)
from ftcfa.engine.compiler.kernels.logarithm import log_tail, normal, split

Logarithm = tuple[str, str]
"""Higher and lower part of a logarithm."""
Log2 = Callable[[Assembly, str], Logarithm]
Exp2 = Callable[[Assembly, str, str], str]
MODERATE = 0.9
"""Exponents up to which y^a is neither infinite nor denormal, whatever y."""
SMALL = 8.0
"""Exponents up to which a logarithm of 60 bits is enough."""
LEAST, MOST = -1100.0, 1030.0
"""Below, 2^x is 0 in double precision; above, it is infinite."""


def constant_power(asm: Assembly, y: str, a: float, nonnegative: bool = False) -> str:
    """Compute y^a for a constant a; ``nonnegative`` if y is known to be >= 0 or NaN."""
    if a == 0.0:
        return asm.constant(1.0)
    if a == 1.0:
        return y
    size = y if nonnegative else absolute(asm, y)
    value = _of_positive(asm, size, asm.constant(a), *_ways(abs(a)))
    ends = size if a > 0.0 else asm.div(asm.constant(1.0), size)
    value = asm.select(_usual(asm, size), value, ends)
    if nonnegative:
        return value
    if a == int(a):
        return with_sign(asm, value, y) if int(a) % 2 else value
    negative = asm.both(
        asm.compare("olt", y, asm.constant(0.0)), asm.compare("ogt", y, asm.constant(-INFINITY))
    )
    return asm.select(negative, asm.constant(NAN), value)


def _ways(a: float) -> tuple[Log2, Exp2]:
    """The cheapest logarithm and exponential that are accurate for exponents up to a."""
    if a <= MODERATE:
        return _log2, _exp2_of_normal
    return (_log2 if a <= SMALL else _log2_precise), _exp2


def _usual(asm: Assembly, size: str) -> str:
    """Mask of the numbers that are neither zero nor infinite nor NaN."""
    positive = asm.compare("ogt", size, asm.constant(0.0))
    return asm.both(positive, asm.compare("olt", size, asm.constant(INFINITY)))


def power(asm: Assembly, y: str, a: str) -> str:
    """Compute y^a, with NumPy's special values."""
    zero, one = asm.constant(0.0), asm.constant(1.0)
    size = absolute(asm, y)
    value = _of_positive(asm, size, a, _log2_precise, _exp2)
    growing = asm.compare("ogt", a, zero)
    ends = asm.select(growing, size, asm.div(one, size))
    value = asm.select(_usual(asm, size), value, ends)
    value = _infinite_exponent(asm, size, a, value)
    whole = asm.compare("oeq", asm.intrinsic("floor", a), a)
    half = asm.mul(a, asm.constant(0.5))
    even = asm.compare("oeq", asm.intrinsic("floor", half), half)
    odd = asm.both(whole, asm.invert(even))
    value = asm.select(odd, with_sign(asm, value, y), value)
    negative = asm.both(asm.compare("olt", y, zero), asm.compare("ogt", y, asm.constant(-INFINITY)))
    value = asm.select(asm.both(negative, asm.invert(whole)), asm.constant(NAN), value)
    undefined = asm.compare("uno", y, a)
    value = asm.select(undefined, asm.constant(NAN), value)
    trivial = asm.either(asm.compare("oeq", a, zero), asm.compare("oeq", y, one))
    return asm.select(trivial, one, value)


def _infinite_exponent(asm: Assembly, size: str, a: str, value: str) -> str:
    """|y|^a where a is infinite: 0, 1 or infinity."""
    one = asm.constant(1.0)
    infinite = asm.compare("oeq", absolute(asm, a), asm.constant(INFINITY))
    grows = asm.compare("ogt", a, asm.constant(0.0))
    above = asm.select(grows, asm.constant(INFINITY), asm.constant(0.0))
    below = asm.select(grows, asm.constant(0.0), asm.constant(INFINITY))
    limit = asm.select(asm.compare("ogt", size, one), above, below)
    limit = asm.select(asm.compare("oeq", size, one), one, limit)
    return asm.select(infinite, limit, value)


def _of_positive(asm: Assembly, y: str, a: str, log2: Log2, exp2: Exp2) -> str:
    """Compute y^a for a positive finite y."""
    larger, shift = normal(asm, y)
    word, m = split(asm, larger)
    n = asm.add(double_of(asm, word), shift)
    high, low = log2(asm, m)
    whole = asm.add(n, high)  # |n| > |high| or n = 0: nothing is lost
    low = asm.add(asm.add(asm.sub(n, whole), high), low)
    product = asm.mul(a, whole)
    return exp2(asm, product, asm.fma(a, low, asm.fma(a, whole, asm.negative(product))))


def _exp2_of_normal(asm: Assembly, high: str, low: str) -> str:
    """2^(high + low) where that is a normal number."""
    k, n = nearest_integer(asm, high)
    return asm.mul(_exp2_of_rest(asm, asm.add(asm.sub(high, k), low)), power_of_two(asm, n))


def _exp2(asm: Assembly, high: str, low: str) -> str:
    """2^(high + low), which may overflow or be denormal."""
    bounded = clamped(asm, high, LEAST, MOST)
    k, n = nearest_integer(asm, bounded)
    low = asm.select(asm.compare("oeq", bounded, high), low, asm.constant(0.0))
    return scaled(asm, _exp2_of_rest(asm, asm.add(asm.sub(bounded, k), low)), n)


def _exp2_of_rest(asm: Assembly, r: str) -> str:
    """2^r, |r| <= 1/2."""
    return asm.fma(r, polynomial(asm, EXP2, r), asm.constant(1.0))


def _quotient(asm: Assembly, m: str) -> tuple[str, str]:
    """The quotient s = (m - 1)/(m + 1) in two parts."""
    one = asm.constant(1.0)
    f, d = asm.sub(m, one), asm.add(m, one)
    d_low = asm.sub(m, asm.sub(d, one))
    inverse = asm.div(one, d)
    s = asm.mul(f, inverse)
    minus = asm.negative(s)
    return s, asm.mul(asm.fma(minus, d_low, asm.fma(minus, d, f)), inverse)


def _log2(asm: Assembly, m: str) -> Logarithm:
    """log2(m) in two parts, to 2^-60: 2 s/ln 2 in two, and s z p(z)/ln 2 in the lower."""
    s, s_low = _quotient(asm, m)
    tail = asm.mul(s, log_tail(asm, s))
    high = asm.mul(s, asm.constant(TWO_OVER_LN2[0]))
    low = asm.fma(s, asm.constant(TWO_OVER_LN2[0]), asm.negative(high))
    low = asm.fma(s, asm.constant(TWO_OVER_LN2[1]), low)
    low = asm.fma(s_low, asm.constant(TWO_OVER_LN2[0]), low)
    return high, asm.fma(tail, asm.constant(INVERSE_LN2[0]), low)


def _log2_precise(asm: Assembly, m: str) -> Logarithm:
    """log2(m) in two parts, to 2^-66: 2/3 z + z^2 p(z) has two parts too."""
    s, s_low = _quotient(asm, m)
    z = asm.mul(s, s)
    z_low = asm.fma(asm.add(s, s), s_low, asm.fma(s, s, asm.negative(z)))
    first = asm.constant(TWO_THIRDS[0])
    lead = asm.mul(z, first)
    lead_low = asm.fma(z_low, first, asm.fma(z, first, asm.negative(lead)))
    lead_low = asm.fma(z, asm.constant(TWO_THIRDS[1]), lead_low)
    tail = asm.fma(asm.mul(z, z), polynomial(asm, LOG_LONG, z), lead_low)
    two = asm.add(asm.constant(2.0), lead)
    two_low = asm.add(asm.add(asm.sub(asm.constant(2.0), two), lead), tail)
    t = asm.mul(s, two)
    t_low = asm.fma(s, two, asm.negative(t))
    t_low = asm.fma(s, two_low, asm.fma(s_low, two, t_low))
    high = asm.mul(t, asm.constant(INVERSE_LN2[0]))
    low = asm.fma(t, asm.constant(INVERSE_LN2[0]), asm.negative(high))
    low = asm.fma(t_low, asm.constant(INVERSE_LN2[0]), low)
    low = asm.fma(t, asm.constant(INVERSE_LN2[1]), low)
    total = asm.add(high, low)
    return total, asm.add(asm.sub(high, total), low)
