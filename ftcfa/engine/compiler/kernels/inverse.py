"""atan, atan2, asin and acos, and erf and hypot.

atan(y/x) = pi/4 + atan((y - x)/(y + x)) or pi/2 + atan(-x/y) where y/x is larger than tan(pi/8)
asin(x) = pi/2 - 2 asin(sqrt((1 - x)/2)) for x > 1/2
"""

from ftcfa.coefficients import ASIN, ATAN, ERF, ERFC, HALF_PI, QUARTER_PI
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.bits import INFINITY, absolute, polynomial, with_sign
from ftcfa.engine.compiler.kernels.exponential import exp
from ftcfa.portable import ERF_END, ERF_MIDDLE

TAN_PI_8, TAN_3PI_8 = 0.41421356237309503, 2.414213562373095


def atan(asm: Assembly, x: str) -> str:
    """The inverse tangent, by that of a quotient."""
    return with_sign(asm, _atan_ratio(asm, absolute(asm, x), asm.constant(1.0)), x)


def _atan_ratio(asm: Assembly, y: str, x: str) -> str:
    """atan(y/x) of positive numbers: one quotient, of the smallest size."""
    middle = asm.compare("ogt", y, asm.mul(x, asm.constant(TAN_PI_8)))
    high = asm.compare("ogt", y, asm.mul(x, asm.constant(TAN_3PI_8)))
    above = asm.select(high, asm.negative(x), asm.select(middle, asm.sub(y, x), y))
    below = asm.select(high, y, asm.select(middle, asm.add(y, x), x))
    t = asm.div(above, below)
    z = asm.mul(t, t)
    zero = asm.constant(0.0)
    offset, offset_low = (
        asm.select(high, asm.constant(HALF_PI[i]),
                   asm.select(middle, asm.constant(QUARTER_PI[i]), zero))
        for i in range(2)
    )  # fmt: skip
    tail = asm.fma(asm.mul(t, z), polynomial(asm, ATAN, z), offset_low)
    return asm.add(offset, asm.add(t, tail))


def atan2(asm: Assembly, y: str, x: str) -> str:
    """The angle of (x, y), from -pi to pi, with NumPy's special values."""
    zero, infinity = asm.constant(0.0), asm.constant(INFINITY)
    up, right = absolute(asm, y), absolute(asm, x)
    both = asm.both(asm.compare("oeq", up, infinity), asm.compare("oeq", right, infinity))
    one = asm.constant(1.0)
    angle = _atan_ratio(asm, asm.select(both, one, up), asm.select(both, one, right))
    nothing = asm.compare("oeq", up, zero)
    angle = asm.select(nothing, zero, angle)
    left = asm.emit(f"icmp slt {asm.words} {asm.bits(x)}, {asm.word(0)}")
    reflected = asm.add(asm.sub(asm.constant(2 * HALF_PI[0]), angle), asm.constant(2 * HALF_PI[1]))
    angle = with_sign(asm, asm.select(left, reflected, angle), y)
    return asm.select(asm.compare("uno", x, y), asm.constant(float("nan")), angle)


def asin(asm: Assembly, x: str) -> str:
    """The inverse sine, beyond 1/2 by that of a small angle."""
    large, value = _asin(asm, x)
    far = asm.sub(asm.constant(HALF_PI[0]), asm.sub(asm.add(value, value),
                                                     asm.constant(HALF_PI[1])))  # fmt: skip
    return with_sign(asm, asm.select(large, far, value), x)


def acos(asm: Assembly, x: str) -> str:
    """pi/2 - asin(x), or 2 asin(sqrt((1 - |x|)/2)) near 1 and pi less that near -1."""
    large, value = _asin(asm, x)
    signed = with_sign(asm, value, x)
    near = asm.sub(asm.constant(HALF_PI[0]), asm.sub(signed, asm.constant(HALF_PI[1])))
    twice = asm.add(value, value)
    pi = asm.constant(2 * HALF_PI[0])
    left = asm.sub(pi, asm.sub(twice, asm.constant(2 * HALF_PI[1])))
    negative = asm.compare("olt", x, asm.constant(0.0))
    return asm.select(large, asm.select(negative, left, twice), near)


def _asin(asm: Assembly, x: str) -> tuple[str, str]:
    """The mask of |x| > 1/2, and asin of |x| or of sqrt((1 - |x|)/2)."""
    size, half = absolute(asm, x), asm.constant(0.5)
    large = asm.compare("ogt", size, half)
    below_one = asm.mul(half, asm.sub(asm.constant(1.0), size))
    z = asm.select(large, below_one, asm.mul(size, size))
    t = asm.select(large, asm.intrinsic("sqrt", below_one), size)
    return large, asm.fma(asm.mul(t, z), polynomial(asm, ASIN, z), t)


def erf(asm: Assembly, x: str) -> str:
    """The error function: x p(x^2), or 1 - exp(-x^2) p((x - 2)/(x + 2)) beyond 1."""
    size, one = absolute(asm, x), asm.constant(1.0)
    near = asm.mul(size, polynomial(asm, ERF, asm.mul(size, size)))
    end = asm.compare("ogt", size, asm.constant(ERF_END))
    inside = asm.select(end, asm.constant(ERF_END), size)
    two = asm.constant(2.0)
    u = asm.div(asm.sub(inside, two), asm.add(inside, two))
    decay = exp(asm, asm.negative(asm.mul(inside, inside)))
    far = asm.fma(asm.negative(decay), polynomial(asm, ERFC, u), one)
    value = asm.select(asm.compare("ogt", size, asm.constant(ERF_MIDDLE)), far, near)
    return with_sign(asm, value, x)


def hypot(asm: Assembly, x: str, y: str) -> str:
    """sqrt(x^2 + y^2) = a sqrt(1 + (b/a)^2), a the larger of |x| and |y|."""
    first, second = absolute(asm, x), absolute(asm, y)
    swap = asm.compare("olt", first, second)
    large, small = asm.select(swap, second, first), asm.select(swap, first, second)
    ratio = asm.div(small, large)
    root = asm.intrinsic("sqrt", asm.fma(ratio, ratio, asm.constant(1.0)))
    nothing = asm.compare("oeq", large, asm.constant(0.0))
    value = asm.select(nothing, asm.constant(0.0), asm.mul(large, root))
    infinity = asm.constant(INFINITY)
    value = asm.select(asm.compare("uno", first, second), asm.constant(float("nan")), value)
    infinite = asm.either(asm.compare("oeq", first, infinity), asm.compare("oeq", second, infinity))
    return asm.select(infinite, infinity, value)
