"""Lemma 5 over drawn robots, and the bounds of Assumption 3 against closed forms."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ftcfa import (
    Arm,
    InertiaSplit,
    ParameterError,
    Uncertainty,
    inertia_bounds,
    inertia_split,
    load_arm,
)
from ftcfa.arrays import Array
from tests.model.texts import BASE, SHOULDER, link, robot

ROBOTS, POSTURES = 1_000, 10
"""10,000 mass matrices for each spread."""
LEMMA = 1e-12
"""Relative; two ways to the inverse of matrices whose condition number is below 1e4."""
SEARCH = 1e-6
"""Relative; a quasi-Newton search stops where the value no longer changes visibly."""
PANDA = load_arm("panda")
PENDULUM = load_arm("double_pendulum", gravity=9.8)
SPREADS = [
    Uncertainty(mass=0.5, centre=0.05, shape=0.5),
    Uncertainty(mass=0.5, centre=0.05, shape=0.5, distribution="bounded"),
    Uncertainty(mass=0.2, centre=0.02, shape=0.1, payload=(0.0, 3.0)),
]


def splits(uncertainty: Uncertainty) -> tuple[list[InertiaSplit], Array]:
    """M at random postures of drawn Pandas: split, and whole."""
    rng = np.random.default_rng(0)
    inertias = uncertainty.draw(PANDA, 1, range(ROBOTS))["inertias"]
    split, whole = [], []
    for rows in inertias:
        true = PANDA.with_inertias(rows)
        for q in rng.uniform(PANDA.lower, PANDA.upper, (POSTURES, PANDA.n)):
            split.append(inertia_split(PANDA, true, q))
            whole.append(true.mass_matrix(q))
    return split, np.array(whole)


@pytest.mark.parametrize("uncertainty", SPREADS, ids=["log-normal", "bounded", "payload"])
def test_lemma_5_gives_the_inverse(uncertainty: Uncertainty) -> None:
    all_splits, whole = splits(uncertainty)
    inverses = np.linalg.inv(whole)
    scales = np.abs(inverses).max(axis=(1, 2))
    nominal = np.array([split.nominal for split in all_splits])
    changes = np.array([split.inverse_change for split in all_splits])
    rounding = 1e-14 * np.abs(whole).max()
    np.testing.assert_allclose(
        nominal + [split.change for split in all_splits], whole, rtol=0, atol=rounding
    )
    errors = np.abs(np.linalg.inv(nominal) + changes - inverses).max(axis=(1, 2)) / scales
    assert np.max(errors) < LEMMA

    dM = np.array([split.change for split in all_splits])
    inverse = np.linalg.inv(nominal)
    printed = -inverse @ dM @ np.linalg.inv(np.eye(7) + nominal @ dM) @ inverse  # (2) as printed
    misses = np.abs(inverse + printed - inverses).max(axis=(1, 2)) / scales
    assert np.min(misses) > 1e3 * LEMMA
    assert np.median(misses) > 0.01


def test_a_robot_that_is_its_model_is_not_split() -> None:
    split = inertia_split(PANDA, PANDA, PANDA.home)
    np.testing.assert_array_equal(split.change, 0.0)
    np.testing.assert_array_equal(split.inverse_change, 0.0)


def pendulum_inertia(D: Array) -> Array:
    """The paper's closed form over D = q2 - q1, shape (..., 2, 2)."""
    m, l = (0.6, 0.8), (0.8, 1.2)  # noqa: E741 (the paper's letter)
    c = m[1] * l[0] * l[1] * np.cos(D)
    M = np.empty((*D.shape, 2, 2))
    M[..., 0, 0], M[..., 1, 1] = (m[0] + m[1]) * l[0] ** 2, m[1] * l[1] ** 2
    M[..., 0, 1] = M[..., 1, 0] = c
    return M


def test_bounds_of_the_pendulum_equal_its_closed_form() -> None:
    spectrum = np.linalg.eigvalsh(pendulum_inertia(np.linspace(0, 2 * np.pi, 20_001)))
    bounds = inertia_bounds(PENDULUM)
    np.testing.assert_allclose(
        (bounds.smallest, bounds.largest), (spectrum.min(), spectrum.max()), rtol=SEARCH
    )
    assert (bounds.change, bounds.draws, bounds.path, bounds.posture) == (0.0, 0, None, None)


def test_the_largest_change_of_a_single_pendulum(urdf: Callable[..., Path]) -> None:
    """One body on one joint: M = I + m r^2, so that dM = (factor - 1) M whatever the posture."""
    arm = load_arm(str(urdf(robot(BASE, link("upper"), SHOULDER))))
    M, spread, draws = 0.1 + 1.0 * (0.1**2 + 0.2**2), 0.3, 1000
    uncertainty = Uncertainty(mass=spread, distribution="bounded")
    bounds = inertia_bounds(arm, uncertainty, draws=draws, seed=4)
    factors = uncertainty.draw(arm, 4, range(draws))["inertias"][:, 0, 0]
    assert bounds.smallest == pytest.approx(M)
    assert bounds.largest == pytest.approx(M)
    assert bounds.change == pytest.approx(M * np.max(np.abs(factors - 1)), rel=SEARCH)
    missed = 1 - 1e-6 ** (1 / draws)  # the largest of so many is nearer, but once in a million
    assert (1 - missed) * spread * M <= bounds.change <= spread * M * (1 + SEARCH)
    assert bounds.draws == draws


def test_the_largest_change_by_a_payload_is_found_in_its_posture() -> None:
    """A point mass at the tip adds p x x^T there, |x|^2 = l1^2 + l2^2 where the rods align."""
    uncertainty = Uncertainty(
        payload=(0.0, 2.0), payload_frame="lower_rod", payload_offset=(0.0, 0.0, -1.2)
    )
    draws = 300
    bounds = inertia_bounds(PENDULUM, uncertainty, draws=draws, seed=1)
    loads = uncertainty.draw(PENDULUM, 1, range(draws))["inertias"][:, 2, 0] - 0.8
    assert bounds.path == np.argmax(loads)
    assert bounds.change == pytest.approx(loads.max() * (0.8**2 + 1.2**2), rel=SEARCH)
    assert bounds.posture is not None
    D = bounds.posture[1] - bounds.posture[0]
    assert abs(np.sin(D)) < 0.01  # flat there: the value is found far more exactly
    worst = uncertainty.robot(PENDULUM, 1, bounds.path)
    change = inertia_split(PENDULUM, worst, bounds.posture).change
    assert np.linalg.norm(change, 2) == pytest.approx(bounds.change, rel=SEARCH)


@pytest.mark.parametrize("name", ["panda", "tiago_arm"])
def test_no_random_posture_of_a_drawn_robot_exceeds_the_largest_change(name: str) -> None:
    arm, uncertainty = load_arm(name), Uncertainty(mass=0.2, centre=0.02, shape=0.1)
    bounds = inertia_bounds(arm, uncertainty, draws=50)
    rng, slack = np.random.default_rng(5), 1e-3  # another basin may be this much better
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    norms = []
    for path in range(50):
        true = uncertainty.robot(arm, 0, path)
        for q in rng.uniform(low, high, (100, arm.n)):
            norms.append(np.linalg.norm(inertia_split(arm, true, q).change, 2))
    assert max(norms) <= bounds.change * (1 + slack)
    assert max(norms) > 0.5 * bounds.change


def test_more_draws_never_give_less_and_the_same_draws_the_same(urdf: Callable[..., Path]) -> None:
    arm = load_arm(str(urdf(robot(BASE, link("upper"), SHOULDER))))
    few, many = (inertia_bounds(arm, Uncertainty(mass=0.3), draws=d).change for d in (20, 400))
    assert 0 < few <= many * (1 + SEARCH)
    assert inertia_bounds(arm, Uncertainty(mass=0.3), draws=20).change == few


@pytest.mark.parametrize("draws", [0, -1, 1.5, True])
def test_a_number_of_draws_that_is_no_count_is_refused(draws: object) -> None:
    arm: Arm = PENDULUM
    with pytest.raises(ParameterError, match=f"draws: {draws!r}, expected an integer >= 1"):
        inertia_bounds(arm, Uncertainty(mass=0.1), draws=draws)  # type: ignore[arg-type]
