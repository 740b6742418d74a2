"""The bounds of M bracket it over the joint range (Assumption 3)."""

import numpy as np
import pytest

from ftcfa import load_arm
from ftcfa.model.mass_matrix_bounds import mass_matrix_bounds, quadratic_gradient


@pytest.mark.parametrize("name", ["double_pendulum", "panda", "tiago_arm"])
def test_the_gradient_of_a_quadratic_form_is_that_of_differences(name: str) -> None:
    arm, rng, step = load_arm(name), np.random.default_rng(4), 1e-5
    for _ in range(10):
        q, x = rng.uniform(-1, 1, (2, arm.n))
        differences = [
            x @ (arm.mass_matrix(q + d) - arm.mass_matrix(q - d)) @ x / (2 * step)
            for d in step * np.eye(arm.n)
        ]
        slack = 1e-8 * np.linalg.norm(arm.mass_matrix(q))  # rounding over the step, step squared
        np.testing.assert_allclose(quadratic_gradient(arm, q, x), differences, rtol=0, atol=slack)


def test_bounds_of_the_pendulum_equal_its_closed_form() -> None:
    a, b, c = (0.6 + 0.8) * 0.8**2, 0.8 * 1.2**2, 0.8 * 0.8 * 1.2
    D = np.linspace(0, 2 * np.pi, 20001)  # absolute angles: M depends on D = q2 - q1 alone
    root = np.hypot((a - b) / 2, c * np.cos(D))
    lowest, highest = (a + b) / 2 - max(root), (a + b) / 2 + max(root)
    bounds = mass_matrix_bounds(load_arm("double_pendulum"))
    search = 1e-6  # a quasi-Newton search stops where the value no longer changes visibly
    np.testing.assert_allclose(bounds, (lowest, highest), rtol=search)


@pytest.mark.parametrize("name", ["double_pendulum", "ur5", "finger_edu"])
def test_bounds_bracket_the_mass_matrix_over_the_joint_range(name: str) -> None:
    arm = load_arm(name)
    low, high = mass_matrix_bounds(arm)
    assert 0 < low < high
    assert (low, high) == mass_matrix_bounds(arm)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    slack = 1e-3  # the search is local: another basin may be this much better
    for q in np.random.default_rng(9).uniform(lower, upper, (500, arm.n)):
        eigenvalues = np.linalg.eigvalsh(arm.mass_matrix(q))
        assert eigenvalues[0] >= low * (1 - slack)
        assert eigenvalues[-1] <= high * (1 + slack)
