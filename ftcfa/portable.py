"""Arithmetic on arrays that gives the same bits on every machine.

NumPy's own exp, log, sin and cos depend on the processor's instructions, and its matrix products on
the BLAS that is installed. These functions add, multiply, divide and take roots only, each rounded
as IEEE 754 says, in a fixed order. The polynomials are those of the generated code
(`ftcfa.engine.compiler.kernels`), which has fused operations; the results are some ulp apart.
"""

import numpy as np

from ftcfa.arrays import Array
from ftcfa.coefficients import COS, ERF, ERFC, EXPM1, HALF_PI, LN2, LOG, LOG2_E, SIN, TWO_OVER_PI

TAIL = 2**30
"""A constant is cut after its top 23 bits: its product with a number below TAIL is exact."""
ROOT_HALF = 0.7071067811865476
ERF_MIDDLE, ERF_END = 1.0, 6.0
"""From where erf is 1 - erfc, and from where it is 1."""
KEPT_BITS = 40
"""Bits of a number that are the same whichever machine computes it."""
TAYLOR = 24
"""Terms of the exponential of a matrix."""
HALVINGS = 5
"""A matrix is divided by 2^HALVINGS, and its exponential squared so many times."""


def product(A: Array, B: Array) -> Array:
    """Matrix products A B, shapes (..., n, k) and (..., k, m), summed from the first column on."""
    total = A[..., :, :1] * B[..., :1, :]
    for k in range(1, A.shape[-1]):
        total = total + A[..., :, k : k + 1] * B[..., k : k + 1, :]
    return total


def exp(x: Array) -> Array:
    """e^x."""
    k = np.rint(np.clip(x, -745.0, 710.0) * LOG2_E)
    r = _reduced(x, k, LN2)
    return np.ldexp(1.0 + (r + r * r * _polynomial(EXPM1, r)), k.astype(np.int64))


def log(x: Array) -> Array:
    """The natural logarithm of positive numbers."""
    m, exponent = np.frexp(x)
    small = m < ROOT_HALF
    m, k = np.where(small, 2.0 * m, m), exponent - 1.0 * small
    f = m - 1.0
    s = f / (m + 1.0)
    z = s * s
    high, *low = _cut(LN2)
    tail = s * (f - z * _polynomial(LOG, z)) - k * sum(low)
    return k * high + (f - tail)


def cube_root(x: Array) -> Array:
    """The real cube root: exp(log(|x|)/3) after one step of Newton's method."""
    size = np.abs(x)
    safe = np.where(size > 0.0, size, 1.0)
    y = exp(log(safe) / 3.0)
    y = y - (y * y * y - safe) / (3.0 * y * y)
    return np.where(size > 0.0, np.copysign(y, x), x)


def sin_cos(x: Array) -> tuple[Array, Array]:
    """sin(x) and cos(x) of numbers up to a million."""
    k = np.rint(x * TWO_OVER_PI)
    r = _reduced(x, k, HALF_PI)
    z = r * r
    s = r + r * z * _polynomial(SIN, z)
    c = 1.0 - (0.5 * z - z * z * _polynomial(COS, z))
    quarter = k.astype(np.int64) & 3
    sine = np.choose(quarter, [s, c, -s, -c])
    return sine, np.choose(quarter, [c, -s, -c, s])


def normal_cdf(x: Array) -> Array:
    """The standard normal distribution function, (1 + erf(x/sqrt 2))/2, to |x| = 8.4."""
    z = np.minimum(np.abs(x) * ROOT_HALF, ERF_END)
    near = 1.0 - z * _polynomial(ERF, z * z)
    far = exp(-z * z) * _polynomial(ERFC, (z - 2.0) / (z + 2.0))
    tail = 0.5 * np.where(z > ERF_MIDDLE, far, near)
    return np.where(x > 0.0, 1.0 - tail, tail)


def rounded(x: Array) -> Array:
    """Numbers rounded to KEPT_BITS: another library's functions, which differ in the last bits."""
    mantissa, exponent = np.frexp(x)
    return np.ldexp(np.rint(np.ldexp(mantissa, KEPT_BITS)), exponent - KEPT_BITS)


def exponential(A: Array, halvings: int = HALVINGS) -> Array:
    """Exponentials of matrices of norms up to 2^halvings / 4, shape (..., n, n).

    exp(A) = exp(A/2^k)^(2^k), the inner one by its Taylor series.
    """
    A, identity = A / 2.0**halvings, np.eye(A.shape[-1])
    value: Array = identity + A / TAYLOR
    for k in range(TAYLOR - 1, 0, -1):
        value = identity + product(A, value) / k
    for _ in range(halvings):
        value = product(value, value)
    return value


def solve(A: Array, B: Array) -> Array:
    """X with A X = B, by elimination with the largest pivots; shapes (n, n) and (n, m)."""
    rows, n = np.concatenate([A, B], axis=1), len(A)
    for j in range(n):
        largest = j + int(np.argmax(np.abs(rows[j:, j])))
        rows[[j, largest]] = rows[[largest, j]]
        rows[j] = rows[j] / rows[j, j]
        others = rows[:, j].copy()
        others[j] = 0.0
        rows = rows - others[:, None] * rows[j]
    return rows[:, n:]


def root(S: Array, smallest: float = 0.0) -> Array:
    """Lower triangular L with L L^T = S, of positive semidefinite matrices, shape (..., n, n).

    A squared pivot of at most ``smallest``, where S is singular, leaves its column zero.
    """
    n = S.shape[-1]
    L = np.zeros(S.shape)
    for j in range(n):
        left = S[..., :, j] - product(L, np.swapaxes(L[..., j : j + 1, :], -1, -2))[..., 0]
        square = left[..., j]
        pivot = np.sqrt(np.where(square > smallest, square, 1.0))
        column = np.where((square > smallest)[..., None], left / pivot[..., None], 0.0)
        L[..., j:, j] = column[..., j:]
    return L


def _cut(parts: tuple[float, ...]) -> list[float]:
    """A constant, given as a sum, as a sum of numbers of 23 bits and a rest."""
    found = []
    first, *rest = parts
    for _ in range(2):
        mantissa, exponent = np.frexp(first)
        high = float(np.ldexp(np.rint(mantissa * 2.0**23), exponent - 23))
        found.append(high)
        first -= high
    return [*found, first, *rest]


def _reduced(x: Array, k: Array, parts: tuple[float, ...]) -> Array:
    """The rest x - k c for a constant c, the product with its first parts exact."""
    for part in _cut(parts):
        x = x - k * part
    return x


def _polynomial(coefficients: tuple[float, ...], x: Array) -> Array:
    """A polynomial, lowest coefficient first."""
    value = np.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        value = value * x + coefficient
    return value
