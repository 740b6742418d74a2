"""sin, cos and tan, with one reduction for all.

    |x| = n pi/2 + r,  |r| <= pi/4

n pi/2 is subtracted in three parts with fused multiply-adds, the first of them without rounding
(Cody and Waite, Software Manual for the Elementary Functions, 1980). Beyond RANGE the results are
NaN, as for infinity.
"""

from typing import cast

from ftcfa.coefficients import COS, HALF_PI, SIN, TWO_OVER_PI
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.bits import NAN, SIGN, absolute, nearest_integer, polynomial

RANGE = 2.0**45
"""Largest |x| of which the functions are computed."""


def sin(asm: Assembly, x: str) -> str:
    """The sine; that of -0 is -0."""
    n, s, c = _sin_cos(asm, x)
    sign = asm.integer("xor", _sign(asm, n), asm.integer("and", asm.bits(x), asm.word(SIGN)))
    return _signed(asm, asm.select(_odd(asm, n), c, s), sign)


def cos(asm: Assembly, x: str) -> str:
    """The cosine, as the sine of x + pi/2."""
    n, s, c = _sin_cos(asm, x)
    sign = _sign(asm, asm.integer("add", n, asm.word(1)))
    return _signed(asm, asm.select(_odd(asm, n), s, c), sign)


def tan(asm: Assembly, x: str) -> str:
    """The tangent: sin/cos, or -cos/sin where n is odd."""
    n, s, c = _sin_cos(asm, x)
    odd = _odd(asm, n)
    value = asm.div(asm.select(odd, c, s), asm.select(odd, asm.negative(s), c))
    return _signed(asm, value, asm.integer("and", asm.bits(x), asm.word(SIGN)))


def _sin_cos(asm: Assembly, x: str) -> tuple[str, str, str]:
    """The word n, sin(r) and cos(r), computed once for x and -x."""
    x = asm.unsigned(x)
    return cast(tuple[str, str, str], asm.once(("sin_cos", x), lambda: _reduced(asm, x)))


def _reduced(asm: Assembly, x: str) -> tuple[str, str, str]:
    size = absolute(asm, x)
    k, n = nearest_integer(asm, size, TWO_OVER_PI)
    r = asm.select(asm.compare("ogt", size, asm.constant(RANGE)), asm.constant(NAN), size)
    for part in HALF_PI:
        r = asm.fma(k, asm.constant(-part), r)
    z = asm.mul(r, r)
    s = asm.fma(asm.mul(r, z), polynomial(asm, SIN, z), r)
    half = asm.fma(z, asm.constant(-0.5), asm.constant(1.0))
    lost = asm.fma(z, asm.constant(-0.5), asm.sub(asm.constant(1.0), half))
    c = asm.add(half, asm.fma(asm.mul(z, z), polynomial(asm, COS, z), lost))
    return n, s, c


def _odd(asm: Assembly, n: str) -> str:
    """Mask of the lanes in which n is odd."""
    bit = asm.integer("and", n, asm.word(1))
    return asm.emit(f"icmp ne {asm.words} {bit}, {asm.word(0)}")


def _sign(asm: Assembly, n: str) -> str:
    """The sign bit where the second bit of n is set."""
    return asm.integer("and", asm.integer("shl", n, asm.word(62)), asm.word(SIGN))


def _signed(asm: Assembly, value: str, sign: str) -> str:
    """A value with its sign changed where a word has the sign bit."""
    return asm.number(asm.integer("xor", asm.bits(value), sign))
