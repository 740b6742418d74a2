"""What the kernels share: rounding to integers, exponents, polynomials."""

from collections.abc import Sequence

from ftcfa.engine.compiler.assembly import Assembly

MAGIC = 1.5 * 2.0**52
"""A number from 2^52 to 2^53 has a unit in the last place of 1: adding this one rounds."""
MAGIC_BITS = 0x4338000000000000
MANTISSA = 52
BIAS = 1023
SIGN = -(2**63)
"""The sign bit, as a signed word."""
INFINITY = float("inf")
NAN = float("nan")


def polynomial(asm: Assembly, coefficients: Sequence[float], x: str) -> str:
    """A polynomial, lowest coefficient first, by Horner's rule."""
    *rest, value = map(asm.constant, coefficients)
    for coefficient in reversed(rest):
        value = asm.fma(value, x, coefficient)
    return value


def nearest_integer(asm: Assembly, x: str, factor: float = 1.0) -> tuple[str, str]:
    """The integer nearest to x times a factor, |.| < 2^51: as a double and as a word."""
    shifted = asm.fma(x, asm.constant(factor), asm.constant(MAGIC))
    word = asm.integer("sub", asm.bits(shifted), asm.word(MAGIC_BITS))
    return asm.sub(shifted, asm.constant(MAGIC)), word


def double_of(asm: Assembly, word: str) -> str:
    """A signed word as a double, |.| < 2^51."""
    shifted = asm.number(asm.integer("add", word, asm.word(MAGIC_BITS)))
    return asm.sub(shifted, asm.constant(MAGIC))


def power_of_two(asm: Assembly, word: str) -> str:
    """2^n for a word from -1022 to 1023."""
    exponent = asm.integer("add", word, asm.word(BIAS))
    return asm.number(asm.integer("shl", exponent, asm.word(MANTISSA)))


def scaled(asm: Assembly, x: str, word: str) -> str:
    """Compute x 2^n for |n| < 2045, in two steps, so that results may be denormal; rounded once."""
    half = asm.integer("ashr", word, asm.word(1))
    rest = asm.integer("sub", word, half)
    return asm.mul(asm.mul(x, power_of_two(asm, half)), power_of_two(asm, rest))


def clamped(asm: Assembly, x: str, low: float, high: float) -> str:
    """Keep x within two bounds; NaN stays NaN."""
    above = asm.select(asm.compare("olt", x, asm.constant(low)), asm.constant(low), x)
    return asm.select(asm.compare("ogt", x, asm.constant(high)), asm.constant(high), above)


def with_sign(asm: Assembly, magnitude: str, sign: str) -> str:
    """|magnitude| with the sign of another number."""
    return asm.intrinsic("copysign", magnitude, sign)


def absolute(asm: Assembly, x: str) -> str:
    """|x|."""
    return asm.intrinsic("fabs", x)
