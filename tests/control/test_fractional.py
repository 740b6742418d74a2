"""The signed fractional power: what makes it a power, and what keeps the sign."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ftcfa.control.fractional import sig

ROUNDING = 3e-13
"""Relative: log |x|, up to 690 below, is right to 2e-16 of itself, and exp passes that on."""
TINY = 1e-290
"""The law need not tell smaller numbers from each other."""

magnitudes = st.one_of(st.just(0.0), st.floats(TINY, 1e6))
vectors = arrays(
    float, 4, elements=st.builds(float.__mul__, magnitudes, st.sampled_from([1.0, -1.0]))
)
powers = st.floats(0.1, 1.0)


@given(x=vectors, a=powers)
def test_it_is_odd(x, a):
    np.testing.assert_array_equal(sig(-x, a), -sig(x, a))


@given(x=vectors, a=powers)
def test_it_is_the_power_of_the_magnitude_with_the_sign_kept(x, a):
    expected = [0.0 if c == 0 else (1.0 if c > 0 else -1.0) * abs(c) ** a for c in x.tolist()]
    np.testing.assert_allclose(sig(x, a), expected, rtol=ROUNDING, atol=0)


@given(x=vectors)
def test_power_one_is_the_identity(x):
    np.testing.assert_allclose(sig(x, 1.0), x, rtol=ROUNDING, atol=0)


@given(x=vectors, a=powers)
def test_the_inverse_power_undoes_it(x, a):
    np.testing.assert_allclose(sig(sig(x, a), 1.0 / a), x, rtol=10 * ROUNDING, atol=0)


@given(x=vectors, a=powers)
def test_it_keeps_the_order(x, a):
    assert np.all(np.diff(sig(np.sort(x), a)) >= 0)


@pytest.mark.parametrize("a", [0.5, 0.6, 1.0])
def test_zero_stays_zero(a):
    np.testing.assert_array_equal(sig(np.array([0.0, -0.0]), a), 0.0)
