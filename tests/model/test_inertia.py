"""Perturbed robots are possible robots."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ftcfa import Arm, ParameterError, load_arm
from ftcfa.arrays import Array
from ftcfa.model.inertia import inertial_parameters, perturbed_inertias, pseudo_inertia

ROUNDING = 1e-12
"""Relative to the largest entry."""
SEMIDEFINITE = 1e-5
"""Relative; a URDF's rounding may push an eigenvalue 1e-6 below zero, a strain stretches that."""
PERTURBED = ("double_pendulum", "panda", "xarm7", "so101", "tiago_arm")
ARMS = {name: load_arm(name) for name in PERTURBED}

seeds = st.integers(0, 2**32 - 1)
spreads = st.floats(0, 0.3)


def bodies(arm: Arm) -> list[pin.Inertia]:
    return list(arm.model.inertias)[1:]


def assert_possible_body(body: pin.Inertia, original: pin.Inertia) -> None:
    """Mass, pseudo-inertia and principal moments are those of some distribution of mass."""
    assert (body.mass > 0) == (original.mass > 0)
    before = np.linalg.eigvalsh(pin.PseudoInertia.FromInertia(original).toMatrix())
    drawn = np.linalg.eigvalsh(pin.PseudoInertia.FromInertia(body).toMatrix())
    slack = SEMIDEFINITE * drawn[-1]
    assert drawn[0] >= -slack
    if before[0] > SEMIDEFINITE * before[-1]:
        assert drawn[0] > 0
    a, b, c = np.linalg.eigvalsh(body.inertia)
    assert a >= -slack
    assert a + b >= c - slack


@pytest.mark.parametrize("name", PERTURBED)
@settings(max_examples=40, deadline=None)
@given(seed=seeds, mass=spreads, centre=spreads, shape=spreads)
def test_every_draw_is_a_possible_robot(
    name: str, seed: int, mass: float, centre: float, shape: float
) -> None:
    arm = ARMS[name]
    drawn = arm.perturbed(np.random.default_rng(seed), mass=mass, centre=centre, shape=shape)
    for body, original in zip(bodies(drawn), bodies(arm), strict=True):
        assert_possible_body(body, original)
    q = np.random.default_rng(seed).uniform(-3, 3, arm.n)
    assert np.linalg.eigvalsh(drawn.mass_matrix(q))[0] > 0


def test_a_draw_depends_on_the_generator_alone_and_leaves_the_original(arm: Arm) -> None:
    q, v = arm.home, np.linspace(-1, 1, arm.n)
    before = arm.mass_matrix(q), arm.bias_force(q, v)
    first, again = (arm.perturbed(np.random.default_rng(7)) for _ in range(2))
    other = arm.perturbed(np.random.default_rng(8))
    np.testing.assert_array_equal(first.mass_matrix(q), again.mass_matrix(q))
    np.testing.assert_array_equal(first.bias_force(q, v), again.bias_force(q, v))
    np.testing.assert_array_equal(arm.mass_matrix(q), before[0])
    np.testing.assert_array_equal(arm.bias_force(q, v), before[1])
    scale = np.max(np.abs(before[0]))
    for drawn in (first, other):
        assert np.max(np.abs(drawn.mass_matrix(q) - before[0])) > 1e-3 * scale
    assert np.max(np.abs(first.mass_matrix(q) - other.mass_matrix(q))) > 1e-3 * scale
    assert first.joint_names == arm.joint_names
    np.testing.assert_array_equal(first.effort_limit, arm.effort_limit)


def test_zero_spreads_give_the_same_robot(arm: Arm) -> None:
    same = arm.perturbed(np.random.default_rng(0), mass=0, centre=0, shape=0)
    M = arm.mass_matrix(arm.home)
    difference = np.max(np.abs(same.mass_matrix(arm.home) - M))
    assert difference <= ROUNDING * np.max(np.abs(M))


def test_one_generator_gives_a_new_robot_at_every_draw() -> None:
    arm, rng = ARMS["panda"], np.random.default_rng(0)
    first, second = arm.perturbed(rng), arm.perturbed(rng)
    assert first.model.inertias[1].mass != second.model.inertias[1].mass


def body_of_unit_density() -> Array:
    """Pseudo-inertia of a box of 0.2 x 0.3 x 0.4 m and 2 kg, its centre at (0.1, -0.2, 0.3)."""
    c = np.array([0.1, -0.2, 0.3])
    J = np.zeros((4, 4))
    J[:3, :3] = 2 * (np.diag([0.2, 0.3, 0.4]) ** 2 / 12 + np.outer(c, c))
    J[:3, 3] = J[3, :3] = 2 * c
    J[3, 3] = 2
    return J


def perturbed_body(
    J: Array, rng: np.random.Generator, mass: float, centre: float, shape: float
) -> Array:
    """Pseudo-inertia of a random body near the body J."""
    return pseudo_inertia(perturbed_inertias(inertial_parameters(J), rng, mass, centre, shape))


def test_a_pure_change_of_mass_scales_the_body() -> None:
    J = body_of_unit_density()
    drawn = perturbed_body(J, np.random.default_rng(1), 0.3, 0.0, 0.0)
    assert drawn[3, 3] != J[3, 3]
    np.testing.assert_allclose(drawn, J * drawn[3, 3] / J[3, 3], rtol=ROUNDING)


def test_a_pure_displacement_moves_the_centre_and_nothing_else() -> None:
    J = body_of_unit_density()
    drawn = perturbed_body(J, np.random.default_rng(1), 0.0, 0.1, 0.0)
    before, after = pin.PseudoInertia.FromMatrix(J), pin.PseudoInertia.FromMatrix(drawn)
    assert np.linalg.norm(after.toInertia().lever - before.toInertia().lever) > 0.01
    assert after.mass == pytest.approx(before.mass, rel=ROUNDING)
    np.testing.assert_allclose(
        after.toInertia().inertia, before.toInertia().inertia, rtol=0, atol=ROUNDING
    )


def test_a_pure_deformation_keeps_mass_and_centre() -> None:
    J = body_of_unit_density()
    drawn = perturbed_body(J, np.random.default_rng(1), 0.0, 0.0, 0.1)
    np.testing.assert_allclose(drawn[3], J[3], rtol=ROUNDING)
    assert np.max(np.abs(drawn[:3, :3] - J[:3, :3])) > 1e-4


def test_spreads_are_the_standard_deviations_that_they_say() -> None:
    draws, J, rng = 4000, body_of_unit_density(), np.random.default_rng(2)
    # A sample standard deviation of 4000 normal numbers errs by 1/sqrt(8000) = 1.1 %, one sigma:
    five_sigma = 5 / np.sqrt(2 * draws)  # wrong for one seed in a million
    samples = [perturbed_body(J, rng, 0.2, 0.03, 0.0) for _ in range(draws)]
    masses = np.log([drawn[3, 3] / 2 for drawn in samples])
    centres = np.array([drawn[:3, 3] / drawn[3, 3] for drawn in samples])
    assert np.std(masses) == pytest.approx(0.2, rel=five_sigma)
    np.testing.assert_allclose(np.std(centres, axis=0), 0.03, rtol=five_sigma)
    shape = 0.01  # small, so that the length along an axis changes by its own strain alone
    ball = np.diag([1.0, 1.0, 1.0, 2.0])
    balls = [perturbed_body(ball, rng, 0.0, 0.0, shape) for _ in range(draws)]
    lengths = np.log([np.sqrt(np.diag(drawn)[:3]) for drawn in balls])
    np.testing.assert_allclose(np.std(lengths, axis=0), shape, rtol=five_sigma + 2 * shape)


@pytest.mark.parametrize("spread", ["mass", "centre", "shape"])
@pytest.mark.parametrize("value", [-0.1, 2.01, 1e300, np.nan, np.inf, "much", None, True])
def test_an_impossible_spread_is_refused(spread: str, value: object) -> None:
    with pytest.raises(ParameterError) as caught:
        ARMS["panda"].perturbed(np.random.default_rng(0), **{spread: value})  # type: ignore[arg-type]
    assert str(caught.value) == f"perturbation '{spread}': {value!r}, expected a number from 0 to 2"


@pytest.mark.parametrize("name", PERTURBED)
def test_the_largest_spreads_give_robots_that_can_be_computed(name: str) -> None:
    arm, rng = ARMS[name], np.random.default_rng(3)
    for _ in range(200):
        drawn = arm.perturbed(rng, mass=2.0, centre=2.0, shape=2.0)
        for body, original in zip(bodies(drawn), bodies(arm), strict=True):
            assert_possible_body(body, original)
        M = drawn.mass_matrix(rng.uniform(-3, 3, arm.n))
        scale = np.sqrt(np.diag(M))  # joints differ by many digits: M in units of their own
        assert np.linalg.eigvalsh(M / np.outer(scale, scale))[0] > 0
