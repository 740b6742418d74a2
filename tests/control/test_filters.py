"""Command filters against a brute-force solution, known limit cycles and known derivatives."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.signal import lti, step

from ftcfa import (
    ExplicitFilter,
    ImplicitFilter,
    ParameterError,
    ProperFilter,
    SecondOrderFilter,
    UnknownNameError,
)
from ftcfa.control.filters import FILTERS, FilterState, ProperState, command_filter
from ftcfa.engine.compiler.flatten import flat

BRENT = 1e-14
"""Absolute and relative accuracy of the root finder."""
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
    abar, rate, new = ImplicitFilter(r1, r2).step(state, np.array([alpha]), h)
    scale = 1.0 + abs(psi1) + abs(alpha) + h * abs(psi2)
    assert abar == new.psi1
    assert rate == (new.psi1 - psi1) / h
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
    alpha, *states = rng.normal(size=(4, 5))
    for choice in FILTERS.values():
        kind = type(choice().init(alpha))
        state = kind(*states[: len(kind._fields)])
        together = flat(choice().step(state, alpha, PERIOD))
        for i in range(5):
            one = kind(*(part[i : i + 1] for part in state))
            alone = flat(choice().step(one, alpha[i : i + 1], PERIOD))
            np.testing.assert_array_equal(alone, together[i::5])


@pytest.mark.parametrize("name", list(FILTERS))
def test_init_rests_on_the_first_input(name):
    alpha = np.array([0.3, -2.0])
    state = FILTERS[name]().init(alpha)
    np.testing.assert_array_equal(state.psi1, alpha)
    for part in state[1:]:
        np.testing.assert_array_equal(part, 0.0)


@pytest.mark.parametrize("name", ["implicit", "second-order", "proper"])
def test_at_rest_on_a_constant_a_filter_stays(name):
    alpha = np.array([0.3, -2.0])
    state = FILTERS[name]().init(alpha)
    for _ in range(3):
        abar, rate, state = FILTERS[name]().step(state, alpha, PERIOD)
        np.testing.assert_array_equal(abar, alpha)
        np.testing.assert_array_equal(rate, 0.0)


def run(chosen, alpha, period, psi1=None):
    """Outputs over the samples of one channel."""
    state = chosen.init(np.array([alpha[0] if psi1 is None else psi1]))
    outputs = []
    for sample in alpha:
        abar, _, state = chosen.step(state, np.array([sample]), period)
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

    Once converged the implicit filter lies on alpha exactly, so that its derivative is the
    backward difference: half a period late, an error of h L/2.
    """
    L = 9.0
    t = np.arange(0.0, 10.0, PERIOD)
    alpha, derivative = np.sin(3.0 * t), 3.0 * np.cos(3.0 * t)
    state = ImplicitFilter(*r1_r2).init(alpha[:1])
    abar, psi2, zeta = (np.zeros_like(t) for _ in range(3))
    for k in range(len(t)):
        out, rate, state = ImplicitFilter(*r1_r2).step(state, alpha[k : k + 1], PERIOD)
        abar[k], psi2[k], zeta[k] = out[0], state.psi2[0], rate[0]
    late = t > 5.0
    np.testing.assert_allclose(abar[late], alpha[late], rtol=0, atol=AGREEMENT)
    for estimate in (psi2, zeta):
        np.testing.assert_allclose(estimate[late], derivative[late], rtol=0, atol=0.51 * PERIOD * L)


def cubic_error(b, L, h):
    """The root e of e + h k1 sig(e, 2/3) + h^2 k2 sig(e, 1/3) + h^3 k3 sign(e) = b."""
    k1, k2, k3 = 2.0 * L ** (1 / 3), 2.12 * L ** (2 / 3), 1.1 * L
    excess = abs(b) - h**3 * k3
    if excess <= 0:
        return 0.0
    y = brentq(
        lambda y: y**3 + h * k1 * y**2 + h**2 * k2 * y - excess,
        0.0,
        excess ** (1 / 3),
        xtol=BRENT,
        rtol=BRENT,
    )
    return np.sign(b) * y**3


@given(
    psi1=numbers,
    psi2=numbers,
    psi3=numbers,
    alpha=numbers,
    L=st.floats(0.1, 1e6),
    h=st.sampled_from([1e-4, 1e-3, 1e-2, 0.1]),
)
def test_proper_filter_solves_its_implicit_equations(psi1, psi2, psi3, alpha, L, h):
    b = psi1 - alpha + h * psi2 + h**2 * psi3
    assume(abs(abs(b) - 1.1 * h**3 * L) > AGREEMENT)
    e = cubic_error(b, L, h)
    state = ProperState(*(np.array([x]) for x in (psi1, psi2, psi3)))
    abar, rate, new = ProperFilter(L).step(state, np.array([alpha]), h)
    scale = 1.0 + abs(psi1) + abs(alpha) + h * abs(psi2) + h**2 * abs(psi3)
    assert abar == new.psi1
    assert rate == new.psi2 + h / 2 * new.psi3
    assert new.psi1[0] - alpha == pytest.approx(e, abs=AGREEMENT * scale)
    power = np.sign(e) * abs(e) ** (2 / 3)
    moved = psi1 + h * (new.psi2[0] - 2.0 * L ** (1 / 3) * power)  # the equation of psi1
    room = AGREEMENT * scale + h * 2.0 * L ** (1 / 3) * (AGREEMENT * scale) ** (2 / 3)
    assert new.psi1[0] == pytest.approx(moved, abs=room)
    if e == 0.0:
        assert abs(new.psi3[0] - psi3) <= 1.1 * h * L * (1.0 + AGREEMENT)
    else:
        moved = psi3 - 1.1 * h * L * np.sign(e)
        assert new.psi3[0] == pytest.approx(moved, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("period", [1e-3, 1e-2])
def test_only_the_proper_derivative_of_a_parabola_is_exact(period):
    """alpha = t + 5 t^2: a backward difference is late by half a period, 5 h."""
    t = np.arange(0.0, 2.0, period)
    errors = {}
    for chosen in (ImplicitFilter(10.0, 60.0), ProperFilter(1e4)):
        state = chosen.init(np.zeros(1))
        for x in t:
            abar, rate, state = chosen.step(state, np.array([x + 5.0 * x**2]), period)
        np.testing.assert_allclose(abar, x + 5.0 * x**2, rtol=AGREEMENT)
        errors[type(chosen)] = 1.0 + 10.0 * t[-1] - rate[0]
    assert errors[ImplicitFilter] == pytest.approx(5.0 * period, rel=1e-6)
    assert errors[ProperFilter] == pytest.approx(0.0, abs=1e-8)


def test_the_error_of_the_proper_derivative_falls_with_the_square_of_the_period():
    """h^2/3 times the largest third derivative, once the filter lies on alpha."""
    for h in (1e-2, 1e-3):
        t = np.arange(0.0, 5.0, h)
        state, errors = ProperFilter(30.0).init(np.zeros(1)), []
        for x in t:
            _, rate, state = ProperFilter(30.0).step(state, np.array([np.sin(3.0 * x)]), h)
            errors.append(rate[0] - 3.0 * np.cos(3.0 * x))
        largest = np.max(np.abs(errors[len(t) // 2 :]))
        assert largest == pytest.approx(h**2 * 27.0 / 3.0, rel=0.01)


@pytest.mark.parametrize("zeta", [0.7, 1.0, 2.0])
def test_second_order_filter_approaches_its_step_response(zeta):
    """Against scipy's response of omega^2/(s^2 + 2 zeta omega s + omega^2), the error halves."""
    omega, errors = 50.0, []
    for h in (1e-4, 5e-5):
        t = h * np.arange(1, 2000)
        _, exact = step(lti([omega**2], [1.0, 2.0 * zeta * omega, omega**2]), T=np.append(0.0, t))
        outputs, _ = run(SecondOrderFilter(omega, zeta), np.ones_like(t), h, psi1=0.0)
        errors.append(np.max(np.abs(outputs - exact[1:])))
    assert errors[1] < 3e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)


def test_second_order_filter_lags_by_two_zeta_over_omega():
    t = np.arange(0.0, 1.0, PERIOD)
    outputs, state = run(SecondOrderFilter(200.0, 0.8), t, PERIOD)
    assert t[-1] - outputs[-1] == pytest.approx(2.0 * 0.8 / 200.0, rel=1e-9)
    assert state.psi2[0] == pytest.approx(1.0, rel=1e-9)


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
    with pytest.raises(
        UnknownNameError, match=r"filter 'linear'.*one of: implicit, explicit, second-order, proper"
    ):
        command_filter("linear")


@pytest.mark.parametrize(
    ("chosen", "name"),
    [
        (ExplicitFilter, "r1"),
        (ImplicitFilter, "r2"),
        (SecondOrderFilter, "omega"),
        (SecondOrderFilter, "zeta"),
        (ProperFilter, "L"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "750", None, True])
def test_bad_gains_are_refused(chosen, name, value):
    with pytest.raises(ParameterError, match=rf"Filter {name}: .*, expected a number > 0"):
        chosen(**{name: value})
