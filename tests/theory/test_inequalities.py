"""The steps of Theorem 1's proof: what replaces each misprint holds, what is printed does not.

Vectors and gains are drawn at random; every counterexample to a printed step is asserted.
"""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

ROUNDING = 1e-10
"""Relative to the larger side: both are sums of a few dozen products of doubles."""
CONFIDENCE = 1 - 1e-6

entries = st.floats(-1e3, 1e3).map(lambda x: 0.0 if abs(x) < 1e-6 else x)
kappas = st.floats(0.05, 1.0)
gains = st.floats(0.01, 100.0)
positive = st.floats(1e-3, 1e3)


@st.composite
def vectors(draw, count=2):
    """A few vectors of one length from 1 to 9."""
    n = draw(st.integers(1, 9))
    return [draw(arrays(float, n, elements=entries)) for _ in range(count)]


def below(left, right):
    """left <= right up to rounding."""
    return left <= right + ROUNDING * max(abs(left), abs(right), 1e-300)


def power(x, a):
    """sig(x, a), independently of the package."""
    return np.sign(x) * np.abs(x) ** a


def size(x):
    return float(np.sqrt(x @ x))


# Definition 2: 1/2 Tr(Phi^T V_xx Phi), printed without the transpose


def test_definition_2_needs_the_transpose():
    """dx = Phi dw from zero, V = |x|^2/2: E V(t) = t/2 E|Phi w|^2, known from the normal law."""
    Phi = np.array([[0.3, 1.0], [-2.0, 0.5]])
    w = np.random.default_rng(0).standard_normal((200_000, 2))
    V = 0.5 * np.sum((w @ Phi.T) ** 2, axis=1)  # at t = 1
    error = stats.norm.ppf(0.5 + CONFIDENCE / 2) * V.std() / np.sqrt(len(V))
    assert abs(V.mean() - 0.5 * np.trace(Phi.T @ Phi)) < error
    assert abs(V.mean() - 0.5 * np.trace(Phi @ Phi)) > 100 * error


# Lemma 5: (I + Mbar^-1 dM)^-1, printed without the inverse of Mbar


@given(a=positive, share=st.floats(-0.9, 10.0))
def test_lemma_5(a, share):
    change = share * a
    assert 1 / (a + change) == pytest.approx(1 / a - change / a / (1 + change / a) / a)


def test_lemma_5_as_printed_fails():
    a, change = 2.0, 1.0
    assert abs(1 / (a + change) - (1 / a - change / a / (1 + a * change) / a)) > 0.08


# (15), first step: the cross terms


@given(v=vectors(3), c1=gains, k1=gains, kappa=kappas)
def test_15(v, c1, k1, kappa):
    v1, v2, s1 = v
    v, s = v1 @ v1, s1 @ s1
    rate = v2 - c1 * power(v1, kappa) - 0.75 * (1 + k1) * v1 + k1 * s1 + c1 * power(s1, kappa)
    left = v * (v1 @ rate)
    right = c1 * v * (v1 @ (power(s1, kappa) - power(v1, kappa)))
    right += (v2 @ v2) ** 2 / 4 + k1 * s**2 / 4
    terms = v**1.5 * (size(v2) + c1 * (size(v1) + 1) * 3 + (1 + k1) * size(v1) + k1 * size(s1))
    assert left <= right + ROUNDING * (terms + abs(right))


# (16): >=, printed <=


@given(v=vectors(1), kappa=kappas)
def test_16(v, kappa):
    (v1,) = v
    left = (v1 @ v1) * (v1 @ power(v1, kappa))
    assert below(size(v1) ** (3 + kappa), left)


def test_16_as_printed_fails():
    v1, kappa = np.array([1.0, 1.0]), 0.6
    left, right = (v1 @ v1) * (v1 @ power(v1, kappa)), (v1 @ v1) ** ((3 + kappa) / 2)
    assert left == 4.0
    assert left > right + 0.5  # 2^1.8


# (17): a factor N^(1 + 3/kappa) on the compensation's part, printed without any


@given(v=vectors(2), kappa=kappas)
@example(v=[np.ones(2), np.ones(2)], kappa=0.6)
def test_17_with_the_factor_of_the_equations(v, kappa):
    v1, s1 = v
    N = len(v1) ** ((1 - kappa) / 2)
    left = (v1 @ v1) * (v1 @ power(s1, kappa))
    share = kappa / (kappa + 3)
    sizes = 3 / (kappa + 3) * size(v1) ** (3 + kappa) + share * size(s1) ** (3 + kappa)
    assert below(left, N * sizes)


@given(v=vectors(2), kappa=st.floats(0.2, 1.0))
def test_17_with_the_factor_on_the_compensation_alone(v, kappa):
    """As (18) needs it: v1 keeps 3/(kappa+3), so that kappa/(kappa+3) of c1 is left to it."""
    v1, s1 = v
    N = len(v1) ** ((1 - kappa) / 2)
    left = (v1 @ v1) * (v1 @ power(s1, kappa))
    right = 3 / (kappa + 3) * size(v1) ** (3 + kappa)
    right += kappa / (kappa + 3) * N ** (1 + 3 / kappa) * size(s1) ** (3 + kappa)
    assert below(left, right)


@pytest.mark.parametrize("n", [2, 3, 7])
def test_17_as_printed_fails(n):
    v1 = s1 = np.ones(n)
    kappa = 0.6
    left = (v1 @ v1) * (v1 @ power(s1, kappa))
    right = size(v1) ** (3 + kappa)  # 3/(kappa+3) + kappa/(kappa+3) = 1
    assert left > 1.1 * right
    assert left == pytest.approx(n ** ((1 - kappa) / 2) * right)  # the factor is the least


# (20): the constant 1/4, and the spectral norm in place of Frobenius'


@st.composite
def positive_definite(draw):
    """A matrix with known extreme eigenvalues, and a vector of its size."""
    n = draw(st.integers(1, 6))
    eigenvalues = draw(arrays(float, n, elements=st.floats(0.05, 20.0)))
    Q, _ = np.linalg.qr(draw(arrays(float, (n, n), elements=entries)) + np.eye(n) * 1e-3)
    return (Q * eigenvalues) @ Q.T, eigenvalues.min()


@given(data=st.data(), M=positive_definite())
def test_20(data, M):
    matrix, Mmin = M
    v2 = data.draw(arrays(float, len(matrix), elements=entries))
    gap = data.draw(arrays(float, len(matrix), elements=entries))
    left = (v2 @ v2) * (v2 @ np.linalg.solve(matrix, gap))
    right = 0.75 * (v2 @ v2) ** 2 + (gap @ gap) ** 2 / (4 * Mmin**4)
    assert left <= right * (1 + ROUNDING) + 1e-6 * Mmin**-4


def test_20_as_printed_fails_in_its_last_step():
    """|M^-1|_F is as much as sqrt(n)/Mmin; (20) takes it for 1/Mmin."""
    M, gap, v2 = np.eye(2), np.array([10.0, 10.0]), np.zeros(2)
    frobenius = np.linalg.norm(np.linalg.inv(M), "fro") ** 4 * (gap @ gap) ** 2
    assert 0.75 * (v2 @ v2) ** 2 + frobenius > 3 * (0.75 * (v2 @ v2) ** 2 + (gap @ gap) ** 2)


# eta: |sat(u) - eta(u)| <= (1 - tanh 1) u*


@given(u=st.floats(-1e6, 1e6), limit=positive)
def test_saturation_gap(u, limit):
    gap = abs(np.clip(u, -limit, limit) - limit * np.tanh(u / limit))
    assert below(gap, (1 - np.tanh(1)) * limit)


# (21), (22)


@given(v=vectors(2), k2=gains)
def test_21(v, k2):
    v2, s2 = v
    left = k2 * (v2 @ v2) * (v2 @ s2)
    assert below(left, 0.75 * k2 * (v2 @ v2) ** 2 + k2 / 4 * (s2 @ s2) ** 2)


@given(data=st.data(), n=st.integers(1, 6), m=st.integers(1, 6))
def test_22_and_the_trace_that_is_tighter(data, n, m):
    v2 = data.draw(arrays(float, n, elements=entries))
    phi = data.draw(arrays(float, (n, m), elements=st.floats(-10, 10)))
    V_vv = 2 * np.outer(v2, v2) + (v2 @ v2) * np.eye(n)
    ito = np.trace(phi.T @ V_vv @ phi) / 2
    trace = 1.5 * (v2 @ v2) * np.sum(phi**2)
    paper = 1.5 * m * np.sqrt(m) * (v2 @ v2) * np.linalg.norm(phi.T @ phi, 2)
    assert below(ito, trace)
    assert below(trace, paper)


# (25): the network, also where phihat <= sqrt(theta B^T B) + eps is all that is known


@given(v=vectors(1), theta=positive, BB=positive, tau=positive, eps=positive, share=kappas)
def test_25(v, theta, BB, tau, eps, share):
    x = v[0] @ v[0]
    demand = share * (np.sqrt(theta * BB) + eps)
    right = x**2 * theta * BB / (4 * tau) + tau + x**2 / 4 + eps**2
    assert below(x * demand, right)


# (26), (28): theta~ thetahat, printed theta~ theta~'


@given(theta=positive, estimate=st.floats(0, 1e3), iota=gains, lambda_=positive)
def test_26_adaptation(theta, estimate, iota, lambda_):
    missing = theta - estimate
    left = iota / lambda_ * missing * estimate
    right = iota / (2 * lambda_) * (theta**2 - missing**2)
    assert left <= right + ROUNDING * iota / lambda_ * (theta**2 + estimate**2)


def test_26_as_printed_fails():
    """With v2 = 0, theta~' = -thetahat' = iota thetahat."""
    theta, estimate, iota, lambda_ = 1.0, 0.5, 100.0, 1.0
    missing, rate = theta - estimate, iota * estimate
    left = iota / lambda_ * missing * rate
    right = iota / (2 * lambda_) * (theta**2 - missing**2)
    assert left > 60 * right


# (27), (28): the compensation, with the weight that (17) needs


@given(v=vectors(3), c1=gains, c2=gains, k1=gains, k2=gains, kappa=kappas)
def test_27(v, c1, c2, k1, k2, kappa):
    s1, s2, gap = v  # abar - alpha, |gap| = pi1
    rate1 = -k1 * s1 - c1 * power(s1, kappa) + gap + s2
    rate2 = -k2 * s2 - c2 * power(s2, kappa)
    left = (s1 @ s1) * (s1 @ rate1) + (s2 @ s2) * (s2 @ rate2)
    right = -(k1 - 1.5) * (s1 @ s1) ** 2 - (k2 - 0.25) * (s2 @ s2) ** 2 + (gap @ gap) ** 2 / 4
    right -= c1 * size(s1) ** (3 + kappa) + c2 * size(s2) ** (3 + kappa)
    largest = max(size(s1), size(s2), size(gap), 1.0) ** 4 * (c1 + c2 + k1 + k2 + 2)
    assert left <= right + ROUNDING * largest


@given(w=st.floats(0.251, 5.0), k=positive)
def test_28_the_gain_conditions_are_those_of_the_weight(w, k):
    """k_i/4 of (26) against w_s (k_1 - 3/2) and w_s (k_2 - 1/4) of (27)."""
    for least in (1.5, 0.25):
        enough = least * w / (w - 0.25)
        assume(abs(k / enough - 1) > 1e-9)
        assert (w * (k - least) - k / 4 >= 0) == (k >= enough)


def test_28_as_printed_loses_the_compensation_of_seven_joints():
    """Printed coefficient 3/(kappa+3); with the factor of (17) and w_s = 1 it is negative."""
    n, kappa = 7, 0.6
    N = n ** ((1 - kappa) / 2)
    assert 1 - kappa / (kappa + 3) * N ** (1 + 3 / kappa) < -0.7


# (29): the constant iota (1-p) p^(p/(1-p))


@given(x=st.floats(0, 1e6), kappa=st.floats(0.0, 0.99), iota=gains)
def test_29(x, kappa, iota):
    p = (3 + kappa) / 4
    assert below(iota * x**p, iota * x + iota * (1 - p) * p ** (p / (1 - p)))


def test_29_as_printed_fails():
    kappa, iota = 0.6, 100.0
    p = (3 + kappa) / 4
    x = p ** (1 / (1 - p))  # where x^p - x is largest
    printed = (1 - kappa) / 4 * (4 / (kappa + 3)) ** ((kappa + 3) / (1 - kappa))
    assert iota * x**p - iota * x > 10 * printed
    assert iota * x**p - iota * x == pytest.approx(iota * (1 - p) * p ** (p / (1 - p)))


@given(terms=arrays(float, 5, elements=st.floats(0, 1e6)), kappa=kappas)
def test_30_powers_of_the_terms_add_up_to_that_of_the_sum(terms, kappa):
    """Lemma 2, from (29) to (30)."""
    p = (3 + kappa) / 4
    assert below(np.sum(terms) ** p, np.sum(terms**p))


AMOUNTS = st.just(0.0) | st.floats(1e-100, 1e6)
"""The mean of smaller numbers underflows."""

# (32): Jensen's inequality, printed the wrong way round


@given(V=arrays(float, st.integers(1, 20), elements=AMOUNTS), kappa=kappas)
def test_32_jensen(V, kappa):
    p = (3 + kappa) / 4
    assert below(np.mean(V**p), np.mean(V) ** p)


def test_32_as_printed_fails():
    """It needs E V^p >= (E V)^p."""
    V, p = np.array([0.0, 2.0]), 0.9
    assert np.mean(V**p) < 0.94 * np.mean(V) ** p


@given(
    Delta=positive, Gamma=positive, p=st.floats(0.75, 0.99), sigma=st.floats(0.01, 0.99),
    above=st.floats(1.0, 1e3),
)  # fmt: skip
def test_first_entry_what_replaces_32(Delta, Gamma, p, sigma, above):
    """L V^(1-p)/(1-p) <= V^-p LV <= -sigma Delta wherever V >= Vinf: the drift of the clock."""
    Vinf = (Gamma / ((1 - sigma) * Delta)) ** (1 / p)
    V = above * Vinf
    assert below(V**-p * (-Delta * V**p + Gamma), -sigma * Delta * (1 - ROUNDING))


# |z1|; Remark 6 is in test_bounds.py


@given(v=vectors(2), w=st.floats(0.26, 1e3))
def test_bound_of_the_tracking_error(v, w):
    v1, s1 = v
    V = ((v1 @ v1) ** 2 + w * (s1 @ s1) ** 2) / 4
    assert below(size(v1 + s1), (4 * V) ** 0.25 * (1 + w ** (-1 / 3)) ** 0.75)


def test_bound_of_the_tracking_error_is_reached():
    """Equality of Hoelder: |s1| = w^(-1/3) |v1| in the same direction."""
    w = 2.5
    v1 = np.array([0.3, -0.4])
    s1 = w ** (-1 / 3) * v1
    V = ((v1 @ v1) ** 2 + w * (s1 @ s1) ** 2) / 4
    assert size(v1 + s1) == pytest.approx((4 * V) ** 0.25 * (1 + w ** (-1 / 3)) ** 0.75)
