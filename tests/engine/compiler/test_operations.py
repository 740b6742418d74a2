"""What the tape of a traced loop is lowered to, operation by operation, against NumPy.

A tiny kernel is compiled for each: y = f(x), a number a lane.
"""

import ctypes
import sys

import casadi as ca
import numpy as np
import pytest
from scipy import special

from ftcfa import ParameterError, TracingError
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.trigonometric import RANGE
from ftcfa.engine.compiler.normals import normals
from ftcfa.engine.compiler.program import machine_code
from ftcfa.engine.compiler.tape import lower
from ftcfa.engine.compiler.target import host_target
from ftcfa.model.symbols import SymbolArray, array, column, symbols
from ftcfa.streams import standard_normals

from ..targets import TARGETS

KERNELS = 4
"""Largest error of the kernels [ulp] (`test_kernels.py`); NumPy's own functions add theirs."""
NUMPY = 4
"""Largest error of NumPy's vectorised functions [ulp], by its documentation."""
ULP = 2.0**-52
LARGEST_ANGLE = RANGE
"""Largest angle of which there is a sine; beyond, it is NaN."""

_TINY, _SMALL = [5e-324, 1e-310, 1e-300, 1e-8], [0.5, 0.999999, 1.0, 1.000001, np.pi / 2, 2.5, 3.7]
_LARGE = [20.0, 700.0, 750.0, 1e5, 1e15, LARGEST_ANGLE, 1e300]
_POSITIVE = np.array([0.0, *_TINY, *_SMALL, *_LARGE, np.inf])
SPECIAL = np.array([*_POSITIVE, *-_POSITIVE, np.nan])


@pytest.fixture(params=TARGETS)
def target(request):
    return TARGETS[request.param]


def erf(x):
    """Of numbers by SciPy, of symbols by CasADi: NumPy has none."""
    return array(ca.erf(column(x)), 1) if isinstance(x, SymbolArray) else special.erf(x)


_ONE = """sin cos tan arcsin arccos arctan sinh cosh tanh arcsinh arccosh arctanh exp log expm1
log1p floor ceil trunc sqrt fabs abs sign square negative reciprocal logical_not"""
_TWO = """add subtract multiply power arctan2 hypot fmod maximum minimum copysign less less_equal
greater greater_equal equal not_equal logical_and logical_or"""
ONE = {
    **{name: getattr(np, name) for name in _ONE.split()},
    "erf": erf,
    "x^2": lambda x: x**2,
    "x^3": lambda x: x**3,
    "x^-1": lambda x: x**-1,
    "x^0.5": lambda x: x**0.5,
    "x^0.6": lambda x: x**0.6,
    "|x|^0.6": lambda x: np.abs(x) ** 0.6,
    "2^x": lambda x: 2.0**x,
    "twice": lambda x: x + x,
    "inside": lambda x: np.where(np.logical_and(x > -1.0, np.logical_not(x >= 2.0)), x, 7.0),
    "outside": lambda x: np.where(np.logical_or(x < -1.0, x == 0.5), -x, x - 3.0),
    "many masks": lambda x: sum(
        2.0**k * np.logical_not(np.logical_and(np.floor(k * x), np.sin(k * x) < 0.5 * np.cos(x)))
        for k in range(1, 12)
    ),
    "mask as number": lambda x: (x > 0.25) * 3.0 + (x != 1.0),
    "clip": lambda x: np.clip(x, -2.0, 2.0),
    "constant": lambda x: np.where(x > 0, np.pi, -1e-300),
    "not a number": lambda x: np.where(x > 0, np.nan, np.inf),
}
TWO = {
    **{name: getattr(np, name) for name in _TWO.split()},
    "where": lambda x, y: np.where(x > y, x, y + 1.0),
    "larger, compared": lambda x, y: np.maximum(x, y) <= np.minimum(x, y),
    "clip": lambda x, y: np.clip(x, -np.abs(y), np.abs(y)),
}


def lowered(function, arity, target):
    """A NumPy function, traced and compiled: what evaluates it on arrays of numbers."""
    inputs = [symbols(f"x{i}", 1) for i in range(arity)]
    output = ca.densify(ca.SX(function(*inputs).to_casadi()))
    columns = [ca.vertcat(*(x.to_casadi() for x in inputs))]
    asm = Assembly(target)
    (values,) = lower(asm, ca.Function("f", columns, [output], {"cse": True}), [asm.memory("%x")])
    asm.store(values[0], "%y", 0)
    return machine(asm, arity)


def machine(asm, inputs, outputs=1):
    """Code that reads %x and writes %y as a function on arrays, a lane each."""
    body = "\n".join([*asm.lines, "  ret void", "}"])
    head = "\n".join([*sorted(asm.declarations), "define void @f(ptr %x, ptr %y) {"])
    engine = machine_code(f"{head}\n{body}", asm.symbols, asm.target)
    call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(
        engine.get_function_address("f")
    )

    def evaluate(*columns):
        x = np.stack(np.broadcast_arrays(*columns))
        missing = -x.shape[1] % asm.lanes
        padded = np.pad(x, ((0, 0), (0, missing)), mode="edge")
        y = np.empty((outputs, padded.shape[1]), dtype=float)
        for start in range(0, padded.shape[1], asm.lanes):
            block = np.ascontiguousarray(padded[:, start : start + asm.lanes])
            result = np.empty((outputs, asm.lanes))
            call(block.ctypes.data, result.ctypes.data)
            y[:, start : start + asm.lanes] = result
        return y[:, : x.shape[1]].squeeze()

    evaluate.engine = engine  # owns the code
    assert inputs >= 1
    return evaluate


def one_argument():
    rng = np.random.default_rng(0)
    return np.concatenate(
        [
            SPECIAL,
            rng.uniform(-1, 1, 300),
            10 * rng.standard_normal(300),
            rng.choice([-1, 1], 100) * 10 ** rng.uniform(-300, 300, 100),
        ]
    )


def two_arguments():
    rng = np.random.default_rng(1)
    first, second = np.meshgrid(SPECIAL, SPECIAL)
    x, y = 10 * rng.standard_normal((2, 300))
    return np.concatenate([first.ravel(), x]), np.concatenate([second.ravel(), y])


def assert_numpys(got, function, columns, ulps=KERNELS + NUMPY):
    with np.errstate(all="ignore"):
        truth = np.asarray(function(*columns), dtype=float)
    same = (got == truth) | (np.isnan(got) & np.isnan(truth))
    with np.errstate(invalid="ignore"):
        near = np.abs(got - truth) <= np.maximum(ulps * ULP * np.abs(truth), 5e-324 * ulps)
    wrong = np.flatnonzero(~(same | (near & np.isfinite(truth))))
    cases = [(*(float(c[i]) for c in columns), float(got[i]), float(truth[i])) for i in wrong[:5]]
    assert not cases, f"(arguments, got, NumPy's): {cases}"


@pytest.mark.parametrize("name", ONE)
def test_functions_of_one_number_are_numpys(name, target):
    x = one_argument()
    if name in ("sin", "cos", "tan"):
        beyond = np.abs(x) > LARGEST_ANGLE
        assert np.all(np.isnan(lowered(ONE[name], 1, target)(x[beyond])))
        x = x[~beyond]
    if name == "many masks":
        x = x[np.abs(x) < LARGEST_ANGLE / 11]
    assert_numpys(lowered(ONE[name], 1, target)(x), ONE[name], [x])


@pytest.mark.parametrize("name", TWO)
def test_functions_of_two_numbers_are_numpys(name, target):
    columns = two_arguments()
    assert_numpys(lowered(TWO[name], 2, target)(*columns), TWO[name], columns)


def test_division_is_numpys_where_the_reciprocal_is_a_normal_number(target):
    x, y = two_arguments()
    with np.errstate(all="ignore"):
        normal = ~(np.abs(1.0 / y) < sys.float_info.min) | np.isinf(y) | (y == 0)
        normal &= np.isfinite(1.0 / y) | (y == 0)
    columns = [x[normal], y[normal]]
    assert_numpys(lowered(np.divide, 2, target)(*columns), np.divide, columns)


def test_maximum_and_minimum_propagate_nan_from_either_side(target):
    x, y = np.array([np.nan, 1.0, np.nan]), np.array([1.0, np.nan, np.nan])
    for function in (np.maximum, np.minimum):
        assert np.all(np.isnan(lowered(function, 2, target)(x, y)))


def test_sign_of_zero_is_zero_and_of_nan_is_nan(target):
    got = lowered(np.sign, 1, target)(np.array([0.0, -0.0, np.nan, 5e-324, -5e-324]))
    np.testing.assert_array_equal(got, [0.0, 0.0, np.nan, 1.0, -1.0])


def test_signs_of_zero_survive(target):
    x = np.array([0.0, -0.0])
    for function in (np.sqrt, np.floor, np.ceil, np.sin, np.tan, np.arcsin, np.sinh, np.tanh):
        got = lowered(function, 1, target)(x)
        np.testing.assert_array_equal(np.signbit(got), [False, True], err_msg=str(function))
    got = lowered(np.copysign, 2, target)(np.array([3.0, 3.0]), x)
    np.testing.assert_array_equal(got, [3.0, -3.0])


def test_the_unchosen_side_of_where_may_be_anything(target):
    x = np.array([-1.0, 0.0, 4.0, np.inf])
    got = lowered(lambda x: np.where(x > 0, np.sqrt(x), 1.0 / x), 1, target)(x)
    np.testing.assert_array_equal(got[[0, 2, 3]], [-1.0, 2.0, np.inf])
    assert np.isinf(got[1])


@pytest.mark.parametrize("name", [*ONE, *TWO])
def test_a_lane_is_independent_of_its_neighbours(name):
    function, arity = (ONE[name], 1) if name in ONE else (TWO[name], 2)
    evaluate = lowered(function, arity, host_target())
    lanes, rng = host_target().lanes, np.random.default_rng(3)
    columns = [one_argument(), rng.permutation(one_argument())][:arity]
    alone = evaluate(*(np.repeat(c, lanes) for c in columns)).reshape(-1, lanes)
    for lane in range(lanes):
        np.testing.assert_array_equal(alone[:, lane], alone[:, 0])
    for _ in range(5):
        order = rng.permutation(len(columns[0]))
        np.testing.assert_array_equal(evaluate(*(c[order] for c in columns)), alone[order, 0])


@pytest.mark.parametrize("channels", [1, 2, 3, 6])
def test_noise_is_the_streams(target, channels):
    seed, step, stream = 2**63 + 12345, 987654321, 3
    paths = np.array([0, 1, 2, 77, 2**32, 2**63, 2**64 - 1, 5] * 2, dtype=np.uint64)
    asm = Assembly(target)
    signed = np.uint64(seed).astype(np.int64)
    key = asm.emit(f"load {asm.words}, ptr %x, align 8")
    deviates = normals(asm, asm.word(signed), key, asm.word(step), stream, channels)
    for i, value in enumerate(deviates):
        asm.store(value, "%y", i)
    got = machine(asm, 1, channels)(paths.view(float)).reshape(channels, -1)
    truth = [
        standard_normals(seed, int(p), stream, range(step, step + 1), channels)[0] for p in paths
    ]
    # The cosine near its zero: an ulp of the angle, up to 2 pi, is all of the error there.
    np.testing.assert_allclose(got, np.transpose(truth), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("lanes", [0, 3, 32, -1, "8"])
def test_odd_numbers_of_lanes_are_refused(lanes):
    with pytest.raises(ParameterError, match=r"lanes: .* expected one of \(1, 2, 4, 8, 16\)"):
        host_target(lanes)


def test_an_operation_that_cannot_be_compiled_is_named():
    def inverse(x):
        return array(ca.erfinv(column(x)), 1)

    with pytest.raises(TracingError, match=r'operation erfinv: cannot be compiled.*"interpreted"'):
        lowered(inverse, 1, host_target())
