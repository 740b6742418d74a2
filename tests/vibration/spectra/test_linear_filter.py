"""Linear filters of white noise: stationary state, density, and exact steps of any length."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import quad
from scipy.linalg import expm

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.spectra.linear_filter import LinearFilter, root_of_covariance

QUADRATURE = 1e-8
"""Relative accuracy of quad over an infinite range."""
ROUNDING = 1e-11
"""Relative; some fifty products of matrices of size ten whose entries are of size one."""
SIGNIFICANCE = 1e-6
"""A right sequence fails a chi-squared test one time in a million."""
STEPS = [1e-7, 1e-4, 3e-3, 0.1, 2.0, 1e3]


def oscillator(w, zeta, intensity=1.0):
    """x'' + 2 zeta w x' + w^2 x = xi; the output is x."""
    A = [[0.0, 1.0], [-(w**2), -2 * zeta * w]]
    return LinearFilter(A, [[0.0], [math.sqrt(intensity)]], [[1.0, 0.0]])


def lag(rate, size=1.0):
    """x' = -rate x + xi (Ornstein and Uhlenbeck)."""
    return LinearFilter([[-rate]], [[1.0]], [[size]])


def random_filter(seed, n=5, m=2, p=2):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A -= (np.linalg.eigvals(A).real.max() + rng.uniform(0.1, 2.0)) * np.eye(n)
    return LinearFilter(A, rng.normal(size=(n, m)), rng.normal(size=(p, n)))


def test_stationary_variance_of_an_oscillator():
    filter = oscillator(10.0, 0.05)
    P = filter.covariance()
    assert P[0, 0] == pytest.approx(0.005)  # 1/(4 zeta w^3)
    assert P[1, 1] == pytest.approx(0.5)  # 1/(4 zeta w)
    assert P[0, 1] == pytest.approx(0.0, abs=1e-15)
    assert filter.rms() == pytest.approx(math.sqrt(0.005))


def test_density_of_a_lag_is_two_sided_twice():
    f = np.array([0.0, 0.3, 5.0])
    exact = 2.0 * 9.0 / (4.0 + (2.0 * np.pi * f) ** 2)
    np.testing.assert_allclose(lag(2.0, 3.0).density(f)[:, 0], exact)


@pytest.mark.parametrize("seed", range(5))
def test_the_stationary_variance_is_the_integral_of_the_density(seed):
    filter = random_filter(seed)
    for k in range(filter.outputs):
        power = quad(lambda f, k=k: filter.density(f)[0, k], 0, np.inf, limit=500)[0]
        assert filter.rms()[k] ** 2 == pytest.approx(power, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("step", STEPS)
def test_the_stationary_covariance_stays_as_it_is(seed, step):
    filter = random_filter(seed)
    P, sampled = filter.covariance(), filter.discretise(step)
    np.testing.assert_allclose(sampled.root @ sampled.root.T, P, rtol=0, atol=ROUNDING)
    after = sampled.A @ P @ sampled.A.T + sampled.B @ sampled.B.T
    np.testing.assert_allclose(after, P, rtol=0, atol=ROUNDING * np.abs(P).max())


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("step", [1e-4, 3e-3, 0.1, 1.0])
def test_a_step_against_gauss_legendre_quadrature(seed, step):
    filter = random_filter(seed)
    n, p = filter.order, filter.outputs
    F = np.block([[filter.A, np.zeros((n, p))], [filter.C, np.zeros((p, p))]])
    G = np.vstack([filter.B, np.zeros((p, filter.inputs))])
    nodes, weights = np.polynomial.legendre.leggauss(40)
    columns = [expm(F * 0.5 * step * (1 + node)) @ G for node in nodes]
    Q = sum(0.5 * step * w * c @ c.T for w, c in zip(weights, columns, strict=True))
    sampled = filter.discretise(step)
    noise = np.vstack([sampled.B, sampled.D])
    scale = np.sqrt(np.outer(np.diag(Q), np.diag(Q)))
    np.testing.assert_allclose(noise @ noise.T / scale, Q / scale, rtol=0, atol=1e-10)
    Phi = expm(F * step)
    np.testing.assert_allclose(np.vstack([sampled.A, sampled.C]), Phi[:, :n], atol=1e-12)


@pytest.mark.parametrize("rate", [0.1, 1.0, 50.0])
@pytest.mark.parametrize("step", STEPS)
def test_the_integral_of_a_lag_has_its_known_variance(rate, step):
    sampled = lag(rate).discretise(step)
    x = rate * step
    exact = (x - 1.0 + math.exp(-x)) / rate**3
    if x < 1e-3:  # the closed form cancels; x^2/2 - x^3/6 is exact to x^4
        exact = (x**2 / 2 - x**3 / 6 + x**4 / 24) / rate**3
    assert sampled.covariance(0)[0, 0] == pytest.approx(exact, rel=1e-11)
    variance = (1.0 - math.exp(-2 * x)) / (2 * rate) if x > 1e-3 else (x - x**2) / rate
    assert (sampled.B @ sampled.B.T)[0, 0] == pytest.approx(
        variance, rel=1e-5 if x <= 1e-3 else 1e-11
    )


@pytest.mark.parametrize("step", [1e-3, 0.02, 0.3])
@pytest.mark.parametrize("lagged", [0, 1, 2, 7])
def test_the_covariances_of_the_integrals_follow_from_the_density(step, lagged):
    """E[Y_k Y_0] = integral of S(f) h^2 sinc(f h)^2 cos(2 pi f k h) over f > 0."""
    filter = oscillator(10.0, 0.2)

    f = np.linspace(0.0, 200.0, 400_001)  # beyond, 1e-7 of the whole
    weight = (step * np.sinc(f * step)) ** 2 * np.cos(2 * np.pi * f * lagged * step)
    exact = np.trapezoid(filter.density(f)[:, 0] * weight, f)
    scale = filter.discretise(step).covariance(0)[0, 0]
    assert filter.discretise(step).covariance(lagged)[0, 0] == pytest.approx(
        exact, abs=1e-6 * scale
    )


@given(st.floats(1e-6, 10.0), st.integers(0, 1000))
@settings(max_examples=40, deadline=None)
def test_two_steps_are_one_of_twice_the_length(step, seed):
    filter = random_filter(seed, n=4, m=1, p=1)
    one, two = filter.discretise(step), filter.discretise(2 * step)
    scale = two.covariance(0)[0, 0]
    joined = 2.0 * one.covariance(0) + one.covariance(1) + one.covariance(1).T
    assert joined[0, 0] == pytest.approx(scale, rel=1e-9)
    np.testing.assert_allclose(one.A @ one.A, two.A, atol=1e-12)


def test_a_filter_without_noise_is_still():
    sampled = LinearFilter([[-1.0]], [[0.0]], [[1.0]]).discretise(0.1)
    assert sampled.normals == 0
    np.testing.assert_array_equal(sampled.root, [[0.0]])


def test_a_state_that_no_noise_reaches():
    filter = LinearFilter([[-1.0, 0.0], [0.0, -2.0]], [[1.0], [0.0]], [[1.0, 1.0], [0.0, 1.0]])
    sampled = filter.discretise(0.5)
    assert sampled.normals == 2
    np.testing.assert_allclose(sampled.B[1], 0.0)
    np.testing.assert_allclose(sampled.D[1], 0.0)
    np.testing.assert_allclose(sampled.root @ sampled.root.T, np.diag([0.5, 0.0]))


def test_states_of_very_different_size_lose_nothing():
    filter = random_filter(3)
    size = np.array([1e-9, 1.0, 1e9, 1e-3, 1e5])
    scaled = LinearFilter(
        filter.A * size[:, None] / size, filter.B * size[:, None], filter.C / size
    )
    for lagged in (0, 1, 5):
        np.testing.assert_allclose(
            scaled.discretise(0.1).covariance(lagged),
            filter.discretise(0.1).covariance(lagged),
            rtol=1e-9,
        )


def test_a_simulated_sequence_has_its_variance_from_the_first_sample():
    filter = oscillator(10.0, 0.05)
    sampled, rng, paths = filter.discretise(0.05), np.random.default_rng(0), 20_000
    x = sampled.root @ rng.standard_normal((2, paths))
    for k in range(40):
        if k in (0, 1, 39):
            chi = np.sum(x[0] ** 2) / 0.005
            assert SIGNIFICANCE < stats.chi2(paths).cdf(chi) < 1 - SIGNIFICANCE
        n = rng.standard_normal((sampled.normals, paths))
        Y = sampled.C @ x + sampled.D @ n
        x = sampled.A @ x + sampled.B @ n
        if k in (0, 1, 39):
            chi = np.sum(Y**2) / sampled.covariance(0)[0, 0]
            assert SIGNIFICANCE < stats.chi2(paths).cdf(chi) < 1 - SIGNIFICANCE


def test_a_scaled_filter():
    np.testing.assert_allclose(lag(2.0).scaled(3.0).density([1.0]), 9.0 * lag(2.0).density([1.0]))


def test_the_root_of_a_regular_covariance_is_cholesky_s():
    Q = random_filter(4).covariance()
    np.testing.assert_allclose(root_of_covariance(Q), np.linalg.cholesky(Q), atol=1e-12)


def test_the_integral_needs_one_normal_only():
    sampled = random_filter(0, p=1).discretise(0.1)
    assert sampled.D[0, 0] > 0
    np.testing.assert_array_equal(sampled.D[0, 1:], 0.0)


def test_the_root_of_a_singular_covariance():
    v = np.array([1.0, 1e-8, -3e6])
    root = root_of_covariance(np.outer(v, v))
    assert root.shape == (3, 1)
    np.testing.assert_allclose(root @ root.T, np.outer(v, v), rtol=1e-12)
    assert root_of_covariance(np.zeros((2, 2))).shape == (2, 0)


@pytest.mark.parametrize(
    ("A", "B", "C", "message"),
    [
        ([[1.0]], [[1.0]], [[1.0]], "LinearFilter A: an eigenvalue of real part 1, expected all"),
        ([[0.0]], [[1.0]], [[1.0]], "LinearFilter A: an eigenvalue of real part 0, expected all"),
        ([[np.nan]], [[1.0]], [[1.0]], "LinearFilter A: [[nan]], expected finite numbers"),
        ([["x"]], [[1.0]], [[1.0]], "LinearFilter A: [['x']], expected a matrix of numbers"),
        ([[-1.0]], [1.0], [[1.0]], "LinearFilter A, B, C: shapes (1, 1), (1,), (1, 1), expected"),
        ([[-1.0]], [[1.0]], [[1.0, 1.0]], "LinearFilter A, B, C: shapes (1, 1), (1, 1), (1, 2)"),
        ([], [[1.0]], [[1.0]], "LinearFilter A, B, C: shapes (0,), (1, 1), (1, 1), expected (n,"),
    ],
)
def test_what_is_no_stable_filter_is_refused(A, B, C, message):
    with pytest.raises((ParameterError, ShapeError)) as refused:
        LinearFilter(A, B, C)
    assert str(refused.value).startswith(message)


@pytest.mark.parametrize("step", [0, -1.0, np.nan, np.inf])
def test_a_step_is_positive(step):
    with pytest.raises(ParameterError, match=r"step: .*, expected a number > 0 \[s\]"):
        lag(1.0).discretise(step)
