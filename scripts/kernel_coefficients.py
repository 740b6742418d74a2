"""The coefficients of the elementary functions in the generated code, derived anew.

    python scripts/kernel_coefficients.py [--check]

Every function is a polynomial on a short interval, after a reduction that
`ftcfa.engine.compiler.kernels` describes. The polynomials minimise the largest relative error
(Remez, Sur le calcul effectif des polynomes d'approximation de Tchebychef, C. R. Acad. Sci. 199,
1934), here in 60 digits by mpmath, and are rounded to doubles. The script writes
ftcfa/coefficients.py; with --check it says whether that file is up to date.
"""

import argparse
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import mpmath as mp

FILE = Path(__file__).parents[1] / "ftcfa/coefficients.py"
mp.mp.dps = 60
GRID = 40
"""Points between two nodes among which an extremum of the error is sought."""
ROUNDS = 12
LINE = 100
"""Longest line of the file."""
Function = Callable[[mp.mpf], mp.mpf]


class Approximation(NamedTuple):
    """A polynomial to be found: that of a function on an interval, weighted."""

    meaning: str
    function: Function
    weight: Function
    """The error of the polynomial is divided by this: it is what the result is relative to."""
    low: mp.mpf
    high: mp.mpf
    coefficients: int


def series(function: Function, at_zero: mp.mpf) -> Function:
    """The function, with its limit at zero."""
    return lambda x: at_zero if abs(x) < mp.mpf(10) ** -25 else function(x)


def of_root(function: Function, at_zero: mp.mpf) -> Function:
    """A function of the square root of its argument."""
    return series(lambda z: function(mp.sqrt(z)), at_zero)


HALF_LN2 = mp.log(2) / 2 * (1 + mp.mpf(2) ** -20)
PI_4 = mp.pi / 4 * (1 + mp.mpf(2) ** -20)
S_MAX = (mp.sqrt(2) - 1) / (mp.sqrt(2) + 1) * (1 + mp.mpf(2) ** -20)
TAN_PI_8 = mp.sqrt(2) - 1
ERF_END = 6
"""Where erf is 1 in double precision."""


def erfc_variable(x: mp.mpf) -> mp.mpf:
    """The variable of the polynomial of erfc, (x - 2)/(x + 2)."""
    return (x - 2) / (x + 2)


def _erfc_of_variable(u: mp.mpf) -> mp.mpf:
    x = 2 * (1 + u) / (1 - u)
    return mp.erfc(x) * mp.exp(x * x)


APPROXIMATIONS = {
    "EXPM1": Approximation(
        "expm1(r) = r + r^2 p(r), |r| <= ln(2)/2",
        series(lambda r: (mp.expm1(r) - r) / r**2, mp.mpf(1) / 2),
        series(lambda r: mp.expm1(r) / r**2 if r else mp.mpf(10) ** 12, mp.mpf(10) ** 12),
        -HALF_LN2, HALF_LN2, 11,
    ),
    "EXP2": Approximation(
        "2^r = 1 + r p(r), |r| <= 1/2",
        series(lambda r: (mp.mpf(2) ** r - 1) / r, mp.log(2)),
        series(lambda r: mp.mpf(2) ** r / abs(r), mp.mpf(10) ** 12),
        -mp.mpf(1) / 2, mp.mpf(1) / 2, 11,
    ),
    "LOG": Approximation(
        "log((1 + s)/(1 - s)) = 2 s + s z p(z), z = s^2, sqrt(1/2) <= quotient <= sqrt(2)",
        of_root(lambda s: (mp.log((1 + s) / (1 - s)) - 2 * s) / s**3, mp.mpf(2) / 3),
        of_root(lambda s: mp.log((1 + s) / (1 - s)) / s**3, mp.mpf(10) ** 12),
        mp.mpf(0), S_MAX**2, 7,
    ),
    "LOG_LONG": Approximation(
        "the same = 2 s + 2/3 s z + s z^2 p(z), for the logarithm in two parts",
        of_root(
            lambda s: (mp.log((1 + s) / (1 - s)) - 2 * s - 2 * s**3 / 3) / s**5, mp.mpf(2) / 5
        ),
        of_root(lambda s: mp.log((1 + s) / (1 - s)) / s**5, mp.mpf(10) ** 12),
        mp.mpf(0), S_MAX**2, 8,
    ),
    "SIN": Approximation(
        "sin(r) = r + r z p(z), z = r^2, |r| <= pi/4",
        of_root(lambda r: (mp.sin(r) - r) / r**3, -mp.mpf(1) / 6),
        of_root(lambda r: mp.sin(r) / r**3, mp.mpf(10) ** 12),
        mp.mpf(0), PI_4**2, 6,
    ),
    "COS": Approximation(
        "cos(r) = 1 - z/2 + z^2 p(z), z = r^2, |r| <= pi/4",
        of_root(lambda r: (mp.cos(r) - 1 + r**2 / 2) / r**4, mp.mpf(1) / 24),
        of_root(lambda r: mp.cos(r) / r**4, mp.mpf(10) ** 12),
        mp.mpf(0), PI_4**2, 6,
    ),
    "ATAN": Approximation(
        "atan(t) = t + t z p(z), z = t^2, |t| <= tan(pi/8)",
        of_root(lambda t: (mp.atan(t) - t) / t**3, -mp.mpf(1) / 3),
        of_root(lambda t: mp.atan(t) / t**3, mp.mpf(10) ** 12),
        mp.mpf(0), TAN_PI_8**2, 11,
    ),
    "ASIN": Approximation(
        "asin(t) = t + t z p(z), z = t^2, |t| <= 1/2",
        of_root(lambda t: (mp.asin(t) - t) / t**3, mp.mpf(1) / 6),
        of_root(lambda t: mp.asin(t) / t**3, mp.mpf(10) ** 12),
        mp.mpf(0), mp.mpf(1) / 4, 13,
    ),
    "ERF": Approximation(
        "erf(x) = x p(x^2), |x| <= 1",
        of_root(lambda x: mp.erf(x) / x, 2 / mp.sqrt(mp.pi)),
        of_root(lambda x: mp.erf(x) / x, 2 / mp.sqrt(mp.pi)),
        mp.mpf(0), mp.mpf(1), 13,
    ),
    "ERFC": Approximation(
        "erfc(x) = exp(-x^2) p(u), u = (x - 2)/(x + 2), 1 <= x <= 6",
        _erfc_of_variable, _erfc_of_variable,
        erfc_variable(mp.mpf(1)), erfc_variable(mp.mpf(ERF_END)), 18,
    ),
}  # fmt: skip
"""The polynomials by the name of their coefficients."""


def remez(one: Approximation) -> tuple[list[mp.mpf], mp.mpf]:
    """Coefficients, lowest first, and the largest weighted error."""
    n = one.coefficients
    middle, half = (one.low + one.high) / 2, (one.high - one.low) / 2
    nodes = [middle - half * mp.cos(mp.pi * k / n) for k in range(n + 1)]
    found: list[mp.mpf] = []
    worst = mp.mpf(0)

    def error(x: mp.mpf) -> mp.mpf:
        return (_value(found, x) - one.function(x)) / one.weight(x)

    for _ in range(ROUNDS):
        rows = [[x**k for k in range(n)] + [(-1) ** i * one.weight(x)] for i, x in enumerate(nodes)]
        solved = mp.lu_solve(mp.matrix(rows), mp.matrix([one.function(x) for x in nodes]))
        found, level = list(solved[:n]), abs(solved[n])
        extrema = _extrema(error, one, nodes)
        worst = max(abs(error(x)) for x in extrema)
        if len(extrema) != n + 1 or worst < level * (1 + mp.mpf(10) ** -4):
            break
        nodes = extrema
    return found, worst


def _value(coefficients: list[mp.mpf], x: mp.mpf) -> mp.mpf:
    """A polynomial, lowest coefficient first."""
    value = mp.mpf(0)
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def _extrema(error: Function, one: Approximation, nodes: list[mp.mpf]) -> list[mp.mpf]:
    """The largest error of each sign in turn, on a grid as fine as the nodes are apart."""
    edges = [one.low, *nodes, one.high]
    points = sorted(
        {a + (b - a) * k / GRID for a, b in pairwise(edges)
         for k in range(GRID + 1)}
    )  # fmt: skip
    runs: list[list[tuple[mp.mpf, mp.mpf]]] = []
    for x in points:
        e = error(x)
        if not runs or (e > 0) != (runs[-1][-1][1] > 0):
            runs.append([])
        runs[-1].append((x, e))
    best = [max(run, key=lambda pair: abs(pair[1]))[0] for run in runs]
    while len(best) > len(nodes):  # the smallest one at either end is no extremum
        best.pop(0 if abs(error(best[0])) < abs(error(best[-1])) else -1)
    return best


def parts(value: mp.mpf, count: int) -> list[float]:
    """A number as a sum of doubles, each the next 53 bits."""
    found = []
    for _ in range(count):
        found.append(float(value))
        value -= mp.mpf(found[-1])
    return found


def text() -> str:
    """The module of the coefficients."""
    lines = [
        '"""Coefficients of the kernels, by ``scripts/kernel_coefficients.py``: do not edit."""',
        "",
    ]
    for name, one in APPROXIMATIONS.items():
        found, worst = remez(one)
        bits = f"2^{float(mp.log(worst, 2)):.1f}"
        lines.append(f"{name} = (")
        lines += [f'    float.fromhex("{float(c).hex()}"),' for c in found]
        lines += [")", f'"""{one.meaning};', f'relative error {bits} before rounding."""']
    constants = {
        "LN2": ("ln(2), its top 53 bits and the next", parts(mp.log(2), 2)),
        "LOG2_E": ("1/ln(2)", parts(1 / mp.log(2), 1)),
        "TWO_THIRDS": ("2/3, its top 53 bits and the next", parts(mp.mpf(2) / 3, 2)),
        "TWO_OVER_LN2": ("2/ln(2), its top 53 bits and the next", parts(2 / mp.log(2), 2)),
        "INVERSE_LN2": ("1/ln(2), its top 53 bits and the next", parts(1 / mp.log(2), 2)),
        "HALF_PI": ("pi/2, three times 53 bits", parts(mp.pi / 2, 3)),
        "TWO_OVER_PI": ("2/pi", parts(2 / mp.pi, 1)),
        "QUARTER_PI": ("pi/4, twice 53 bits", parts(mp.pi / 4, 2)),
    }
    for name, (meaning, doubles) in constants.items():
        numbers = [f'float.fromhex("{x.hex()}")' for x in doubles]
        line = f"{name} = ({', '.join(numbers)})" if len(numbers) > 1 else f"{name} = {numbers[0]}"
        many = [f"{name} = (", *(f"    {x}," for x in numbers), ")"]
        lines += [line] if len(line) <= LINE else many
        lines.append(f'"""{meaning}."""')
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the coefficients, or compare them with the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    new = text()
    if parser.parse_args().check:
        sys.exit(0 if FILE.read_text() == new else f"{FILE} is not what this script makes")
    FILE.write_text(new)


if __name__ == "__main__":
    main()
