"""The sequential test: its errors summed exactly over all walks, its bounds, its independence."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import quad

from ftcfa.errors import ParameterError, ShapeError
from ftcfa.statistics.sequential_test import SequentialTest, log_evidence, share_bounds

NEGLIGIBLE = 1e-16
"""Probability of a number of successes at which the verdict of the test does not matter."""


def walk(share, beta, budget, truth):
    """Probabilities of yes and of no within the budget, and mean number of paths, exactly.

    The number of successes is a random walk; walks that reached a decision are taken out.
    """
    undecided, yes, no, mean = np.array([1.0]), 0.0, 0.0, 0.0
    for n in range(1, budget + 1):
        mean += undecided.sum()
        undecided = np.append(undecided * (1 - truth), 0.0) + np.append(0.0, undecided * truth)
        S = np.flatnonzero(undecided > NEGLIGIBLE)
        says_yes = log_evidence(S, n - S, share) >= -np.log(beta)
        says_no = log_evidence(n - S, S, 1 - share) >= -np.log(beta)
        assert not np.any(says_yes & says_no)
        yes, no = yes + undecided[S[says_yes]].sum(), no + undecided[S[says_no]].sum()
        undecided[S[says_yes | says_no]] = 0.0
    return yes, no, mean


@pytest.mark.parametrize("share", [0.5, 0.8, 0.95, 0.99])
@pytest.mark.parametrize("beta", [0.01, 0.05, 0.2])
def test_exact_probability_of_error(share, beta):
    """At the share itself, the worst case; it is also not wasted: more than a quarter is used."""
    yes, no, _ = walk(share, beta, 600, share)
    assert beta / 4 < yes <= beta
    assert no <= beta
    for truth in (share - 0.3 * (1 - share), share + 0.3 * (1 - share)):
        yes, no, _ = walk(share, beta, 600, truth)
        assert (yes if truth < share else no) <= beta


@pytest.mark.parametrize(
    ("truth", "documented"), [(1.0, 74), (0.99, 136), (0.975, 450), (0.9, 254)]
)
def test_it_stops_early(truth, documented):
    """Fewer paths than the fixed test that says yes as surely; the numbers of the docstring."""
    yes, no, mean = walk(0.95, 0.05, 3000, truth)
    assert mean == pytest.approx(documented, abs=1)
    assert (yes if truth > 0.95 else no) > 0.997
    if 0.95 < truth < 1:
        n = next(
            n
            for n in range(20, 3000)
            if stats.binom.sf(stats.binom.isf(0.05, n, 0.95), n, truth) >= yes
        )
        assert mean < 0.6 * n


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 40), st.integers(0, 40), st.floats(0.05, 0.95))
def test_evidence_is_the_mixed_likelihood_ratio(S, F, p0):
    """By quadrature in the angle of p = sin^2: Jeffreys' weight is uniform there."""
    start = np.arcsin(np.sqrt(p0))
    ratio, _ = quad(
        lambda angle: (np.sin(angle) ** 2 / p0) ** S * (np.cos(angle) ** 2 / (1 - p0)) ** F,
        start,
        np.pi / 2,
        epsabs=0,
        epsrel=1e-10,
        limit=200,
    )
    assert log_evidence(S, F, p0) == pytest.approx(np.log(ratio / (np.pi / 2 - start)), abs=1e-8)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 300), st.integers(0, 300), st.sampled_from([0.001, 0.05, 0.3]))
def test_bounds_separate_refuted_shares_from_the_others(S, F, beta):
    low, high = share_bounds(S, S + F, beta)
    assert 0 <= low <= S / max(S + F, 1) if S + F else low == 0
    assert low < high
    shares = np.linspace(1e-6, 1 - 1e-6, 400)
    shares = shares[(np.abs(shares - low) > 1e-9) & (np.abs(shares - high) > 1e-9)]
    below = shares < S / max(S + F, 1)
    refuted = log_evidence(S, F, shares) >= -np.log(beta)
    np.testing.assert_array_equal(refuted & below, shares < low)
    refuted = log_evidence(F, S, 1 - shares) >= -np.log(beta)
    np.testing.assert_array_equal(refuted & ~below, shares > high)


def test_the_bounds_agree_with_the_answer():
    test = SequentialTest(0.9, 0.05, 5000)
    rng = np.random.default_rng(0)
    for truth, answer in ((0.97, "yes"), (0.8, "no")):
        for _ in range(20):
            verdict = test.judge(rng.random(5000) < truth)
            assert verdict.answer == answer
            assert verdict.finished
            assert (verdict.low >= 0.9) == (answer == "yes")
            assert (verdict.high <= 0.9) == (answer == "no")
            assert verdict.low <= verdict.successes / verdict.trials <= verdict.high


@pytest.mark.parametrize("truth", [0.8, 0.88, 0.9, 0.91, 0.97, 1.0])
def test_it_stops_at_the_first_look_that_decides(truth):
    test = SequentialTest(0.9, 0.1, 4000)
    for seed in range(5):
        outcomes = np.random.default_rng(seed).random(4000) < truth
        S, n = np.cumsum(outcomes), np.arange(1, 4001)
        yes = log_evidence(S, n - S, 0.9) >= -np.log(0.1)
        no = log_evidence(n - S, S, 0.1) >= -np.log(0.1)
        first = np.argmax(yes | no) if np.any(yes | no) else 3999
        answer = "yes" if yes[first] else "no" if no[first] else "undecided"
        verdict = test.judge(outcomes)
        assert (verdict.trials, verdict.answer) == (first + 1, answer)


def test_bounds_hold_at_all_looks_together():
    """2,000 walks looked at after each of 300 paths: the lower bound holds in 95 %."""
    rng, truth = np.random.default_rng(1), 0.7
    S = np.cumsum(rng.random((2000, 300)) < truth, axis=1)
    n = np.arange(1, 301)
    refuted = log_evidence(S, n - S, truth) >= -np.log(0.05)
    assert np.mean(~refuted.any(axis=1)) > 0.95 - 3 * np.sqrt(0.05 * 0.95 / 2000)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), truth=st.sampled_from([0.85, 0.95, 0.99]))
def test_the_verdict_does_not_depend_on_chunks(seed, truth):
    outcomes = np.random.default_rng(seed).random(1000) < truth
    test = SequentialTest(0.95, 0.05, 1000)
    whole = test.judge(outcomes)
    for size in (7, 64, 999):
        for end in range(size, 1000 + size, size):
            verdict = test.judge(outcomes[:end])
            if verdict.finished:
                break
        assert verdict == whole or verdict.answer == "undecided" == whole.answer


def test_undecided_at_the_budget_and_as_soon_as_it_is_certain():
    test = SequentialTest(0.95, 0.05, 100)
    verdict = test.judge(np.arange(100) % 20 != 7)
    assert (verdict.answer, verdict.trials, verdict.finished) == ("undecided", 100, True)
    assert verdict.low < 0.95 < verdict.high
    assert test.judge(np.arange(200) % 20 != 7) == verdict
    early = test.judge(np.arange(95) % 20 != 7)
    assert (early.answer, early.finished) == ("undecided", True)
    start = test.judge([True] * 20)
    assert (start.answer, start.trials, start.finished) == ("undecided", 20, False)
    assert not test.judge([]).finished
    six = SequentialTest(0.5, 0.05, 6)  # which six successes or six failures decide
    assert not six.judge([True] * 5).finished
    assert six.judge([True] * 6).answer == "yes"
    assert six.judge([False] * 6).answer == "no"
    assert six.judge([True, False]).finished


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((1.0, 0.05, 100), "SequentialTest share: 1.0, expected a number between 0 and 1"),
        ((95, 0.05, 100), "expected a number between 0 and 1; give 0.95 for 95 percent"),
        ((0.95, 0.0, 100), "SequentialTest beta: 0.0, expected a number between 0 and 1"),
        ((0.95, 0.5, 100), "SequentialTest beta: 0.5, expected at most 1/3"),
        ((0.95, 0.05, 0), "SequentialTest budget: 0, expected an integer >= 1"),
    ],
)
def test_errors(arguments, text):
    with pytest.raises(ParameterError) as caught:
        SequentialTest(*arguments)
    assert text in str(caught.value)


def test_error_of_outcomes():
    with pytest.raises(ShapeError, match=r"outcomes: shape \(2, 1\), expected shape \(paths,\)"):
        SequentialTest(0.95, 0.05, 10).judge([[True], [False]])
