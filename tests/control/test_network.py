"""The radial basis function network: its centres, its formula, and what it refuses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ftcfa import ParameterError, RBFNetwork

ROUNDING = 1e-12
"""Squares and an exponential of numbers near one."""

states = arrays(float, 3, elements=st.floats(-5, 5))


@given(q=states, v=states)
def test_basis_is_lemma_1_with_centres_on_the_diagonal(q, v):
    """10 nodes of width 4 evenly in [-2, 2], as in Section V."""
    expected = []
    for k in range(10):
        centre = -2.0 + 4.0 * k / 9.0
        distance = sum((c - centre) ** 2 for c in [*q.tolist(), *v.tolist()])
        expected.append(math.exp(-distance / 4.0**2))
    np.testing.assert_allclose(RBFNetwork().basis(q, v), expected, rtol=ROUNDING, atol=0)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_a_node_answers_with_one_at_its_centre_and_less_elsewhere(n):
    network = RBFNetwork(nodes=5, width=1.5, half_range=1.0)
    for k, centre in enumerate([-1.0, -0.5, 0.0, 0.5, 1.0]):
        B = network.basis(np.full(n, centre), np.full(n, centre))
        assert B.shape == (5,)
        assert B[k] == 1.0
        assert np.all(np.delete(B, k) < 1.0)


def test_one_node_sits_in_the_middle():
    assert RBFNetwork(nodes=1).basis(np.zeros(2), np.zeros(2)) == [1.0]


def test_far_from_all_centres_it_is_silent():
    assert np.all(RBFNetwork().basis(np.full(2, 1e3), np.full(2, 1e3)) == 0.0)


@pytest.mark.parametrize("nodes", [0, -1, 2.5, True, "ten", None])
def test_bad_numbers_of_nodes_are_refused(nodes):
    with pytest.raises(ParameterError, match=r"RBFNetwork nodes: .*, expected an integer >= 1"):
        RBFNetwork(nodes=nodes)


@pytest.mark.parametrize("name", ["width", "half_range"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "wide", None])
def test_bad_sizes_are_refused(name, value):
    with pytest.raises(ParameterError, match=f"RBFNetwork {name}: .*, expected a number > 0"):
        RBFNetwork(**{name: value})


@given(
    q=states,
    v=states,
    scale=st.sampled_from([1e-3, 1.0, 30.0, 2e3]),
    network=st.sampled_from(
        [RBFNetwork(), RBFNetwork(nodes=1), RBFNetwork(7, 1.0, 3.0), RBFNetwork(10, 0.02, 2.0)]
    ),
)
def test_two_exponentials_give_the_square_of_the_basis(q, v, scale, network):
    """To |X| = 1e4: no infinity, and never zero times infinity. The last one is too narrow."""
    B = network.basis(scale * q, scale * v)
    square = network.basis_square(scale * q, scale * v)
    np.testing.assert_allclose(square, B @ B, rtol=1e-9, atol=1e-290)
