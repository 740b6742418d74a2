"""The kernels against mpmath, in units in the last place, and the same bits on every target."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.table import FUNCTIONS
from ftcfa.engine.compiler.kernels.trigonometric import RANGE
from ftcfa.engine.compiler.target import host_target

from ..targets import TARGETS

SCRIPTS = Path(__file__).parents[3] / "scripts"
ACCURACY = runpy.run_path(str(SCRIPTS / "kernel_accuracy.py"))
NUMBERS = 1000
"""Arguments of each kind, for each function."""
CLOSE = {"exp": 1.0, "log": 1.0, "sin": 1.5, "cos": 1.5, "tanh": 1.5, "pow": 1.5}
"""Largest error of these and of y^a with a constant a [ulp]; of the others 4."""


def test_errors_are_within_their_bounds():
    found = ACCURACY["errors"](NUMBERS)
    assert found.keys() >= FUNCTIONS.keys()
    for name, ulp in found.items():
        assert ulp <= CLOSE.get(name, 1.5 if "^" in name else 4.0), name


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_target_gives_the_same_bits(name):
    """With and without fused multiply-adds in hardware, for any number of lanes."""
    columns = ACCURACY["ARGUMENTS"][name](ACCURACY["Draw"](NUMBERS, seed=1))
    first, *others = (
        ACCURACY["kernel"](FUNCTIONS[name], len(columns), target)(*columns)
        for target in TARGETS.values()
    )
    for other in others:
        np.testing.assert_array_equal(other.view(np.uint64), first.view(np.uint64))


def test_angles_beyond_the_range_have_no_sine():
    x = np.array([RANGE, np.nextafter(RANGE, np.inf), 1e300, np.inf, -np.inf])
    for name in ("sin", "cos", "tan"):
        got = ACCURACY["kernel"](FUNCTIONS[name], 1, host_target())(x)
        np.testing.assert_array_equal(np.isnan(got), [False, True, True, True, True])


def test_the_coefficients_are_those_of_the_script():
    script = runpy.run_path(str(SCRIPTS / "kernel_coefficients.py"))
    assert script["FILE"].read_text() == script["text"]()


def test_the_sine_of_an_opposite_costs_no_second_reduction():
    def both(asm, x):
        return asm.add(FUNCTIONS["sin"](asm, asm.negative(x)), FUNCTIONS["cos"](asm, x))

    def fused(function):
        asm = Assembly(host_target())
        function(asm, asm.load("%x", 0))
        return sum("llvm.fma" in line for line in asm.lines)

    assert fused(both) == fused(FUNCTIONS["sin"])
    x = np.linspace(-9.0, 9.0, 64)
    got = ACCURACY["kernel"](both, 1, host_target())(x)
    np.testing.assert_allclose(got, np.cos(x) - np.sin(x), atol=1e-15)
