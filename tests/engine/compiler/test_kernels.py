"""The kernels against mpmath, in units in the last place, and at special values."""

import runpy
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.power import constant_power
from ftcfa.engine.compiler.kernels.table import FUNCTIONS
from ftcfa.engine.compiler.kernels.trigonometric import RANGE
from ftcfa.engine.compiler.target import host_target

from ..targets import TARGETS
from .test_operations import machine

NUMBERS = 1000
"""Arguments of each kind, for each function."""
CLOSE = {"exp": 1.0, "log": 1.0, "sin": 1.5, "cos": 1.5, "tanh": 1.5}
"""Largest error of these [ulp]; of the others 4."""
SMALLEST = 2.0**-1074


def kernel(function, arity, target):
    """A kernel as a function on arrays."""
    asm = Assembly(target)
    asm.store(function(asm, *(asm.load("%x", i) for i in range(arity))), "%y", 0)
    return machine(asm, arity)


def some(low, high, rng, signs=(-1, 1)):
    """Numbers of all sizes between two bounds, of both signs."""
    size = np.exp(rng.uniform(np.log(low), np.log(high), NUMBERS))
    return size * rng.choice(signs, NUMBERS)


def near(low, high, rng):
    return rng.uniform(low, high, NUMBERS)


def angles(rng):
    """Also next to the multiples of pi/2, where the sine or the cosine vanishes."""
    multiples = np.arange(1, NUMBERS) * (np.pi / 2)
    large = np.floor(rng.uniform(1, RANGE / 2, NUMBERS)) * (np.pi / 2)
    return np.concatenate([some(1e-300, RANGE, rng), near(-10, 10, rng), multiples, large])


ARGUMENTS = {
    "exp": lambda rng: np.concatenate([near(-745, 709.7, rng), near(-2, 2, rng)]),
    "expm1": lambda rng: np.concatenate([some(1e-320, 700, rng), near(-2, 2, rng)]),
    "sinh": lambda rng: np.concatenate([some(1e-320, 710, rng), near(-2, 2, rng)]),
    "cosh": lambda rng: np.concatenate([some(1e-320, 710, rng), near(-2, 2, rng)]),
    "tanh": lambda rng: np.concatenate([some(1e-320, 30, rng), near(-2, 2, rng)]),
    "log": lambda rng: np.concatenate([some(1e-320, 1e308, rng, (1,)), near(0.5, 2, rng)]),
    "log1p": lambda rng: np.concatenate([some(1e-320, 1e308, rng, (1,)), near(-0.999, 2, rng)]),
    "asinh": lambda rng: np.concatenate([some(1e-320, 1e308, rng), near(-3, 3, rng)]),
    "acosh": lambda rng: 1.0 + some(1e-15, 1e308, rng, (1,)),
    "atanh": lambda rng: np.concatenate([some(1e-320, 1, rng), near(-1, 1, rng)]),
    "sin": angles,
    "cos": angles,
    "tan": angles,
    "asin": lambda rng: np.concatenate([some(1e-320, 1, rng), near(-1, 1, rng)]),
    "acos": lambda rng: np.concatenate([some(1e-320, 1, rng), near(-1, 1, rng)]),
    "atan": lambda rng: np.concatenate([some(1e-320, 1e308, rng), near(-3, 3, rng)]),
    "erf": lambda rng: np.concatenate([some(1e-320, 6, rng), near(-7, 7, rng)]),
}
PAIRS = {
    "atan2": lambda rng: (some(1e-150, 1e150, rng), some(1e-150, 1e150, rng)),
    "hypot": lambda rng: (some(1e-150, 1e150, rng), some(1e-150, 1e150, rng)),
    "pow": lambda rng: bounded_powers(rng),
}


def bounded_powers(rng):
    """Bases and exponents whose power is a normal number."""
    y = np.concatenate([some(1e-300, 1e300, rng, (1,)), near(0.5, 2, rng)])
    return y, rng.uniform(-1, 1, len(y)) * 700 / np.abs(np.log(y))


def error(got, exact):
    """Largest error in units in the last place of the exact value [ulp]."""
    worst = 0.0
    for value, truth in zip(got, exact, strict=True):
        rounded = float(truth)
        if rounded == value:
            continue
        _, exponent = np.frexp(abs(rounded))
        unit = max(2.0 ** (int(exponent) - 53), SMALLEST) if exponent > -1021 else SMALLEST
        worst = max(worst, abs(float((mp.mpf(float(value)) - truth) / mp.mpf(unit))))
    return worst


def truth(name, columns):
    exact = {"pow": mp.power}.get(name) or getattr(mp, name)
    with mp.workdps(50):
        return [exact(*map(mp.mpf, row)) for row in np.transpose(columns).tolist()]


@pytest.mark.parametrize("name", ARGUMENTS)
def test_functions_of_one_number(name):
    x = ARGUMENTS[name](np.random.default_rng(0))
    got = kernel(FUNCTIONS[name], 1, host_target())(x)
    assert error(got, truth(name, [x])) <= CLOSE.get(name, 4.0)


@pytest.mark.parametrize("name", PAIRS)
def test_functions_of_two_numbers(name):
    columns = PAIRS[name](np.random.default_rng(0))
    got = kernel(FUNCTIONS[name], 2, host_target())(*columns)
    assert error(got, truth(name, columns)) <= 4.0


@pytest.mark.parametrize("a", [0.6, 1 / 3, 0.5, -0.4, 0.9, 1.6, 3.7, 7.0, -2.0])
def test_fractional_powers(a):
    rng = np.random.default_rng(0)
    y = np.concatenate([some(1e-320, 1e308, rng, (1,)), near(0.5, 2, rng)])
    y = y[np.abs(a * np.log(y)) < 700]
    got = kernel(lambda asm, x: constant_power(asm, x, a), 1, host_target())(y)
    assert error(got, truth("pow", [y, np.full_like(y, a)])) <= 1.5


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_target_gives_the_same_bits(name):
    """With and without fused multiply-adds in hardware, for any number of lanes."""
    pairs = name in PAIRS
    x = PAIRS[name](np.random.default_rng(1)) if pairs else ARGUMENTS[name](
        np.random.default_rng(1)
    )  # fmt: skip
    columns = x if pairs else (x,)
    first, *others = (
        kernel(FUNCTIONS[name], len(columns), target)(*columns) for target in TARGETS.values()
    )
    for other in others:
        np.testing.assert_array_equal(other.view(np.uint64), first.view(np.uint64))


def test_angles_beyond_the_range_have_no_sine():
    x = np.array([RANGE, np.nextafter(RANGE, np.inf), 1e300, np.inf, -np.inf])
    for name in ("sin", "cos", "tan"):
        got = kernel(FUNCTIONS[name], 1, host_target())(x)
        np.testing.assert_array_equal(np.isnan(got), [False, True, True, True, True])


def test_the_coefficients_are_those_of_the_script():
    script = runpy.run_path(str(Path(__file__).parents[3] / "scripts" / "kernel_coefficients.py"))
    assert script["FILE"].read_text() == script["text"]()
