"""Bounds of the mass matrix over the joint range (Assumption 3)."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from ftcfa.arrays import Array
from ftcfa.model.arm import Arm


def joint_box(arm: Arm) -> tuple[Array, Array]:
    """Lower and upper end of the joint range, shape (n,) each [rad or m].

    An unlimited joint has the range [-pi, pi].
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return lower, upper


def random_postures(arm: Arm, count: int) -> Array:
    """Postures of the joint range, shape (count, n) [rad or m]; always the same ones."""
    return np.random.default_rng(0).uniform(*joint_box(arm), (count, arm.n))


def mass_matrix_bounds(arm: Arm, samples: int = 256, starts: int = 3) -> tuple[float, float]:
    """Mmin and Mmax of Assumption 3: extreme eigenvalues of M over the joint range [kg m^2 or kg].

    A bounded quasi-Newton search starts from the ``starts`` best of ``samples`` random postures,
    which are always the same. The result is the best posture of these searches, without proof
    that there is no better one.
    """
    postures = random_postures(arm, samples)
    spectra = np.array([np.linalg.eigvalsh(arm.mass_matrix(q)) for q in postures])

    def extreme(sign: float, index: int) -> float:
        def objective(q: Array) -> tuple[float, Array]:
            values, vectors = np.linalg.eigh(arm.mass_matrix(q))
            return sign * values[index], sign * quadratic_gradient(arm, q, vectors[:, index])

        best = postures[np.argsort(sign * spectra[:, index])[:starts]]
        return sign * min(least(objective, q, arm)[0] for q in best)

    return extreme(1.0, 0), extreme(-1.0, -1)


def quadratic_gradient(arm: Arm, q: Array, x: Array) -> Array:
    """Gradient of x^T M(q) x for a constant x, shape (n,).

        d(v^T M v)/dq = 2 (M' v - C v) = 2 C^T v,   since M' = C + C^T

    For a unit eigenvector x it is the gradient of the eigenvalue.
    """
    return 2.0 * arm.coriolis_matrix(q, x).T @ x


def least(
    objective: Callable[[Array], tuple[float, Array]], q: Array, arm: Arm
) -> tuple[float, Array]:
    """Value and posture of a local minimum over the joint range of an arm.

    A bounded quasi-Newton search begins at q, shape (n,), and ends at a posture that is not worse.
    ``objective`` returns value and gradient.
    """
    bounds = list(zip(*joint_box(arm), strict=True))
    result = minimize(objective, q, jac=True, bounds=bounds, method="L-BFGS-B")
    return float(result.fun), result.x
