"""log, log1p, asinh, acosh and atanh.

    x = 2^n m,  sqrt(1/2) <= m < sqrt(2),   f = m - 1,  s = f/(2 + f),  z = s^2
    log(m) = 2 s + s z p(z) = f - s (f - z p(z)),   log(x) = n ln 2 + log(m)

(Tang, Table-driven implementation of the logarithm function, ACM Trans. Math. Softw. 16, 1990,
without the table.)
"""

from ftcfa.coefficients import LN2, LOG
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.bits import (
    INFINITY,
    MANTISSA,
    NAN,
    absolute,
    double_of,
    polynomial,
    with_sign,
)

ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
"""Bits of sqrt(1/2)."""
SMALLEST_NORMAL = 2.0**-1022
SHIFT = 54
"""A denormal number times 2^SHIFT is normal."""
LARGE = 2.0**28
"""asinh(x) is log(2 x) above, to the last place."""


def log(asm: Assembly, x: str) -> str:
    """The natural logarithm; -inf at 0 and NaN below."""
    usual = asm.both(
        asm.compare("ogt", x, asm.constant(0.0)), asm.compare("olt", x, asm.constant(INFINITY))
    )
    negative = asm.compare("olt", x, asm.constant(0.0))
    zero = asm.compare("oeq", x, asm.constant(0.0))
    special = asm.select(negative, asm.constant(NAN), x)
    special = asm.select(zero, asm.constant(-INFINITY), special)
    return asm.select(usual, log_of_positive(asm, *normal(asm, x)), special)


def log_of_positive(asm: Assembly, x: str, shift: str | None = None) -> str:
    """log(x 2^shift) of normal numbers x > 0; ``shift`` is a double."""
    n, m = split(asm, x)
    k = double_of(asm, n) if shift is None else asm.add(double_of(asm, n), shift)
    f = asm.sub(m, asm.constant(1.0))
    s = asm.div(f, asm.add(m, asm.constant(1.0)))
    tail = asm.mul(s, asm.sub(f, log_tail(asm, s)))
    low = asm.sub(f, asm.fma(k, asm.constant(-LN2[1]), tail))
    return asm.fma(k, asm.constant(LN2[0]), low)


def log_tail(asm: Assembly, s: str) -> str:
    """The product z p(z), z = s^2."""
    z = asm.mul(s, s)
    return asm.mul(z, polynomial(asm, LOG, z))


def normal(asm: Assembly, x: str) -> tuple[str, str]:
    """A positive number as a normal one and a power of two, a double: x = y 2^shift."""
    denormal = asm.compare("olt", x, asm.constant(SMALLEST_NORMAL))
    larger = asm.select(denormal, asm.mul(x, asm.constant(2.0**SHIFT)), x)
    return larger, asm.select(denormal, asm.constant(-float(SHIFT)), asm.constant(0.0))


def split(asm: Assembly, x: str) -> tuple[str, str]:
    """The word n and m, x = 2^n m, of a positive normal number."""
    bits = asm.bits(x)
    over = asm.integer("sub", bits, asm.word(ROOT_HALF_BITS))
    n = asm.integer("ashr", over, asm.word(MANTISSA))
    exponent = asm.integer("shl", n, asm.word(MANTISSA))
    return n, asm.number(asm.integer("sub", bits, exponent))


def log1p(asm: Assembly, x: str) -> str:
    """log(1 + x): log(u) + (what rounding u = 1 + x lost)/u."""
    one = asm.constant(1.0)
    u = asm.add(x, one)
    lost = asm.sub(x, asm.sub(u, one))
    finite = asm.compare("olt", absolute(asm, u), asm.constant(INFINITY))
    correction = asm.select(finite, asm.div(lost, u), asm.constant(0.0))
    same = asm.compare("oeq", u, one)
    value = asm.add(log(asm, u), correction)
    zero = asm.compare("oeq", u, asm.constant(0.0))
    value = asm.select(zero, asm.constant(-INFINITY), value)
    return asm.select(same, x, value)


def asinh(asm: Assembly, x: str) -> str:
    """log1p(|x| + x^2/(1 + sqrt(x^2 + 1))), or log(|x|) + log(2) for large |x|."""
    size, one = absolute(asm, x), asm.constant(1.0)
    square = asm.mul(size, size)
    root = asm.intrinsic("sqrt", asm.add(square, one))
    small = log1p(asm, asm.add(size, asm.div(square, asm.add(one, root))))
    large = asm.add(log(asm, size), asm.constant(LN2[0]))
    is_large = asm.compare("ogt", size, asm.constant(LARGE))
    return with_sign(asm, asm.select(is_large, large, small), x)


def acosh(asm: Assembly, x: str) -> str:
    """log1p(t + sqrt(2 t + t^2)), t = x - 1, or log(x) + log(2) for large x."""
    t = asm.sub(x, asm.constant(1.0))
    root = asm.intrinsic("sqrt", asm.fma(t, t, asm.add(t, t)))
    small = log1p(asm, asm.add(t, root))
    large = asm.add(log(asm, x), asm.constant(LN2[0]))
    value = asm.select(asm.compare("ogt", x, asm.constant(LARGE)), large, small)
    return asm.select(asm.compare("olt", x, asm.constant(1.0)), asm.constant(NAN), value)


def atanh(asm: Assembly, x: str) -> str:
    """log1p(2 |x|/(1 - |x|))/2."""
    size = absolute(asm, x)
    ratio = asm.div(asm.add(size, size), asm.sub(asm.constant(1.0), size))
    return with_sign(asm, asm.mul(asm.constant(0.5), log1p(asm, ratio)), x)
