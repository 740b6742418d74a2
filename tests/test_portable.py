"""Portable arithmetic: against mpmath and SciPy, and the same bits under other CPUs and BLAS."""

import os
import subprocess
import sys

import mpmath as mp
import numpy as np
import pytest
from scipy.linalg import expm

from ftcfa import portable
from tests.engine.targets import ELSEWHERE

ULP = 2.0**-52
RNG = np.random.default_rng(0)


def relative(got, exact):
    return max(abs(float((mp.mpf(float(g)) - e) / e)) for g, e in zip(got, exact, strict=True))


@pytest.mark.parametrize(
    ("function", "exact", "x"),
    [
        (portable.exp, mp.exp, RNG.uniform(-700, 700, 500)),
        (portable.exp, mp.exp, RNG.uniform(-1, 1, 500)),
        (portable.log, mp.log, np.exp(RNG.uniform(-700, 700, 500))),
        (portable.log, mp.log, RNG.uniform(0.5, 2, 500)),
        (portable.normal_cdf, mp.ncdf, RNG.uniform(-1.4, 8, 500)),
        (portable.cube_root, mp.cbrt, np.exp(RNG.uniform(-600, 600, 500))),
    ],
)
def test_functions_to_the_last_places(function, exact, x):
    assert relative(function(x), [exact(mp.mpf(v)) for v in x.tolist()]) < 2 * ULP


@pytest.mark.parametrize("largest", [7.0, 1e3, 1e6])
def test_sines_and_cosines(largest):
    x = RNG.uniform(-largest, largest, 500)
    for got, exact in zip(portable.sin_cos(x), (mp.sin, mp.cos), strict=True):
        truth = [exact(mp.mpf(v)) for v in x.tolist()]
        assert max(abs(float(mp.mpf(float(g)) - e)) for g, e in zip(got, truth, strict=True)) < ULP


def test_the_tail_of_the_normal_distribution():
    x = np.linspace(-8.4, 0.0, 500)
    exact = [mp.ncdf(mp.mpf(v)) for v in x.tolist()]
    assert relative(portable.normal_cdf(x), exact) < 100 * ULP  # of exp(-x^2/2)


def test_rounded_numbers_forget_their_last_bits():
    x = RNG.standard_normal(500) * 2.0 ** RNG.integers(-300, 300, 500)
    np.testing.assert_allclose(portable.rounded(x), x, rtol=2.0**-40)
    nearest = portable.rounded(x)
    np.testing.assert_array_equal(portable.rounded(nearest * (1 + ULP)), nearest)
    special = np.array([0.0, -0.0, 1.0, np.inf, -np.inf, np.nan])
    np.testing.assert_array_equal(portable.rounded(special), special)


def test_cube_roots_of_zero_and_of_negative_numbers():
    np.testing.assert_allclose(portable.cube_root(np.array([0.0, -8.0, 27.0])), [0, -2, 3])


def test_matrices():
    A, B = RNG.standard_normal((4, 3, 5)), RNG.standard_normal((4, 5, 2))
    np.testing.assert_allclose(portable.product(A, B), A @ B, rtol=1e-14, atol=1e-14)
    S = RNG.standard_normal((20, 3, 3))
    S = S + np.swapaxes(S, -1, -2)
    np.testing.assert_allclose(portable.exponential(S), expm(S), rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("rank", [0, 1, 2, 3])
def test_roots_of_singular_matrices(rank):
    x = RNG.standard_normal((20, 3, rank))
    S = x @ np.swapaxes(x, -1, -2)
    L = portable.root(S)
    assert np.all(np.tril(L) == L)
    np.testing.assert_allclose(L @ np.swapaxes(L, -1, -2), S, atol=1e-12)


PROGRAM = """
import hashlib
import numpy as np
import ftcfa

arm = ftcfa.load_arm("panda")
record = ftcfa.Record(1e-3, np.sin(np.arange(400.0) ** 2)[:, None])
shakes = {
    "white": ftcfa.WhiteNoise(0.1),
    "table": ftcfa.ShapedNoise(["mil_std_810g_highway_truck_vertical"]),
    "record": ftcfa.RecordedAcceleration(record),
}
for name, excitation in shakes.items():
    loop = ftcfa.ClosedLoop(
        arm,
        ftcfa.FTCF(arm, compensation="bias"),
        ftcfa.Sinusoid(0.3, offset=arm.home),
        ftcfa.Vibration(ftcfa.BaseAcceleration("z"), excitation),
        substeps=4,
        uncertainty=ftcfa.Uncertainty(mass=0.2, centre=0.01, shape=0.1, payload=(0.0, 2.0)),
    )
    paths = ftcfa.ensemble(loop, 12, 0.2, chunk=5)
    numbers = [v.values for v in paths.variables.values() if v.dtype.kind in "fi"]
    whole = b"".join(np.ascontiguousarray(a).tobytes() for a in numbers)
    print(name, hashlib.sha256(whole).hexdigest())
"""


def test_ensembles_of_uncertain_pandas_have_the_same_bits_elsewhere():
    hashes = {
        name: subprocess.run(
            [sys.executable, "-c", PROGRAM],
            env={**os.environ, **changed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for name, changed in {"here": {}, **ELSEWHERE}.items()
    }
    assert len(set(hashes.values())) == 1, hashes
