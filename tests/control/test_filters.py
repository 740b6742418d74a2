"""Command filters against a brute-force solution, known limit cycles and known derivatives."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from ftcfa import ExplicitFilter, ImplicitFilter, ParameterError, UnknownNameError
from ftcfa.control.filters import FILTERS, FilterState, command_filter

BRENT = 1e-14
"""Absolute and relative accuracy asked of the root finder."""
AGREEMENT = 1e-10
"""Closed form and root finder, relative to the numbers that enter: cancellation costs digits."""
PERIOD = 1e-3

numbers = st.floats(-100, 100)
gains = st.floats(0.1, 1e3)


def implicit_error(b, r1, r2, h):
    """The root e of e + h r1 sig(e, 1/2) + h^2 r2 sign(e) = b, the sign's value at zero free."""
    if abs(b) <= h**2 * r2:
        return 0.0
    s = 1.0 if b > 0 else -1.0
    excess = abs(b) - h**2 * r2
    return s * brentq(lambda e: e + h * r1 * e**0.5 - excess, 0.0, excess, xtol=BRENT, rtol=BRENT)


@given(
    psi1=numbers,
    psi2=numbers,
    alpha=numbers,
    r1=gains,
    r2=gains,
    h=st.sampled_from([1e-4, 1e-3, 1e-2, 0.1]),
)
def test_implicit_filter_solves_its_implicit_equations(psi1, psi2, alpha, r1, r2, h):
    b = psi1 + h * psi2 - alpha
    assume(abs(abs(b) - h**2 * r2) > AGREEMENT)  # at the corner, rounding picks the side
    e = implicit_error(b, r1, r2, h)
    state = FilterState(np.array([psi1]), np.array([psi2]))
    abar, new = ImplicitFilter(r1, r2).step(state, np.array([alpha]), h)
    scale = 1.0 + abs(psi1) + abs(alpha) + h * abs(psi2)
    assert abar == new.psi1
    assert new.psi1[0] == pytest.approx(alpha + e, abs=AGREEMENT * scale)
    if e == 0.0:  # sliding: the set-valued sign takes the value that holds the filter on alpha
        s = (psi2 - new.psi2[0]) / (h * r2)
        assert abs(s) <= 1.0 + AGREEMENT * scale / (h**2 * r2)
        assert new.psi1[0] - psi1 == pytest.approx(h * new.psi2[0], abs=AGREEMENT * scale)
    else:
        s = np.sign(e)
        assert new.psi2[0] == pytest.approx(psi2 - h * r2 * s, abs=AGREEMENT * scale)


def test_components_do_not_mix():
    rng = np.random.default_rng(0)
    psi1, psi2, alpha = rng.normal(size=(3, 5))
    for choice in FILTERS.values():
        together, after = choice().step(FilterState(psi1, psi2), alpha, PERIOD)
        for i in range(5):
            one = FilterState(psi1[i : i + 1], psi2[i : i + 1])
            alone, alone_after = choice().step(one, alpha[i : i + 1], PERIOD)
            assert alone == together[i]
            assert alone_after == (after.psi1[i], after.psi2[i])


@pytest.mark.parametrize("name", list(FILTERS))
def test_init_rests_on_the_first_input(name):
    alpha = np.array([0.3, -2.0])
    state = FILTERS[name]().init(alpha)
    np.testing.assert_array_equal(state.psi1, alpha)
    np.testing.assert_array_equal(state.psi2, 0.0)


def run(chosen, alpha, period, psi1=None):
    """Outputs over the samples of one channel."""
    state = chosen.init(np.array([alpha[0] if psi1 is None else psi1]))
    outputs = []
    for sample in alpha:
        abar, state = chosen.step(state, np.array([sample]), period)
        outputs.append(abar[0])
    return np.array(outputs), state


def test_explicit_filter_limit_cycles_and_the_implicit_one_does_not():
    """Amplitude (r1 h/2)^2 = 0.14 at the paper's gains and 1 ms, on a constant input."""
    still = np.zeros(4000)
    explicit, _ = run(ExplicitFilter(), still, PERIOD, psi1=0.01)
    amplitude = np.max(np.abs(explicit[2000:]))
    assert amplitude == pytest.approx((750.0 * PERIOD / 2.0) ** 2, rel=0.05)
    implicit, state = run(ImplicitFilter(), still, PERIOD, psi1=0.01)
    assert np.all(implicit[2000:] == 0.0)
    assert np.all(state.psi2 == 0.0)


def test_the_limit_cycle_of_the_explicit_filter_shrinks_with_the_square_of_the_period():
    coarse, fine = (
        np.max(np.abs(run(ExplicitFilter(), np.zeros(4000), h, psi1=0.01)[0][2000:]))
        for h in (1e-3, 1e-4)
    )
    assert coarse / fine == pytest.approx(100.0, rel=0.1)


@pytest.mark.parametrize("r1_r2", [(750.0, 180.0), (1.5 * 9.0**0.5, 1.1 * 9.0)])
def test_implicit_filter_gives_a_sine_and_its_derivative(r1_r2):
    """With the paper's gains and with the rule r1 = 1.5 sqrt(L), r2 = 1.1 L for L = max|alpha''|.

    Once converged the implicit filter lies on alpha exactly, so that psi2 is the backward
    difference: half a period late, an error of h L/2.
    """
    L = 9.0
    t = np.arange(0.0, 10.0, PERIOD)
    alpha, derivative = np.sin(3.0 * t), 3.0 * np.cos(3.0 * t)
    state = ImplicitFilter(*r1_r2).init(alpha[:1])
    abar, psi2 = np.zeros_like(t), np.zeros_like(t)
    for k in range(len(t)):
        out, state = ImplicitFilter(*r1_r2).step(state, alpha[k : k + 1], PERIOD)
        abar[k], psi2[k] = out[0], state.psi2[0]
    late = t > 5.0
    np.testing.assert_allclose(abar[late], alpha[late], rtol=0, atol=AGREEMENT)
    np.testing.assert_allclose(psi2[late], derivative[late], rtol=0, atol=0.51 * PERIOD * L)


def test_explicit_filter_follows_a_sine_at_a_tenth_of_the_period():
    t = np.arange(0.0, 2.0, 1e-4)
    abar, _ = run(ExplicitFilter(), np.sin(3.0 * t), 1e-4)
    limit_cycle = (750.0 * 1e-4 / 2.0) ** 2
    assert np.max(np.abs(abar - np.sin(3.0 * t))[1000:]) < 2.0 * limit_cycle


@pytest.mark.parametrize("name", ["implicit", "explicit"])
def test_a_filter_goes_by_name_with_the_gains_of_section_5(name):
    chosen = command_filter(name)
    assert chosen == FILTERS[name](r1=750.0, r2=180.0)


def test_a_filter_object_is_taken_as_it_is():
    mine = ImplicitFilter(10.0, 20.0)
    assert command_filter(mine) is mine


def test_an_unknown_filter_lists_the_known_ones():
    with pytest.raises(UnknownNameError, match=r"filter 'kalman'.*one of: implicit, explicit"):
        command_filter("kalman")


@pytest.mark.parametrize("chosen", list(FILTERS.values()))
@pytest.mark.parametrize("name", ["r1", "r2"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "750", None, True])
def test_bad_gains_are_refused(chosen, name, value):
    with pytest.raises(ParameterError, match=f"filter gain {name}: .*, expected a number > 0"):
        chosen(**{name: value})
