"""Bounds of the mass matrix over the joint range (Assumption 3)."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from ftcfa.arrays import Array


class HasMassMatrix(Protocol):
    """The part of an arm that the bounds need."""

    @property
    def n(self) -> int:
        """Number of coordinates."""
        ...

    @property
    def lower(self) -> Array:
        """Lower limits, shape (n,)."""
        ...

    @property
    def upper(self) -> Array:
        """Upper limits, shape (n,)."""
        ...

    def mass_matrix(self, q: Array) -> Array:
        """M(q), shape (n, n)."""
        ...

    def coriolis_matrix(self, q: Array, v: Array) -> Array:
        """C(q, v) with M' - 2 C skew-symmetric, shape (n, n)."""
        ...


def joint_box(arm: HasMassMatrix) -> tuple[Array, Array]:
    """Lower and upper end of the joint range, shape (n,) each [rad or m].

    An unlimited joint has the range [-pi, pi].
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return lower, upper


def mass_matrix_bounds(
    arm: HasMassMatrix, samples: int = 256, starts: int = 3
) -> tuple[float, float]:
    """Smallest and largest eigenvalue of M over the joint range: Mmin, Mmax of Assumption 3.

    A bounded quasi-Newton search starts from the ``starts`` best of ``samples`` random postures,
    which are always the same. The result is the best posture of these searches, without proof
    that there is no better one.

    Returns:
        (Mmin, Mmax) [kg m^2 for revolute joints, kg for prismatic ones].
    """
    postures = np.random.default_rng(0).uniform(*joint_box(arm), (samples, arm.n))
    spectra = np.array([np.linalg.eigvalsh(arm.mass_matrix(q)) for q in postures])

    def extreme(sign: float, index: int) -> float:
        def objective(q: Array) -> tuple[float, Array]:
            values, vectors = np.linalg.eigh(arm.mass_matrix(q))
            return sign * values[index], sign * quadratic_gradient(arm, q, vectors[:, index])

        best = postures[np.argsort(sign * spectra[:, index])[:starts]]
        return sign * min(least(objective, q, arm)[0] for q in best)

    return extreme(1.0, 0), extreme(-1.0, -1)


def quadratic_gradient(arm: HasMassMatrix, q: Array, x: Array) -> Array:
    """Gradient of x^T M(q) x for a constant x, shape (n,).

        d(v^T M v)/dq = 2 (M' v - C v) = 2 C^T v,   since M' = C + C^T

    For a unit eigenvector x it is the gradient of the eigenvalue.
    """
    return 2.0 * arm.coriolis_matrix(q, x).T @ x


def least(
    objective: Callable[[Array], tuple[float, Array]], q: Array, arm: HasMassMatrix
) -> tuple[float, Array]:
    """Local minimum over the joint range, by a bounded quasi-Newton search from a posture.

    Args:
        objective: Function of a posture that returns value and gradient.
        q: Posture at which the search begins, shape (n,).
        arm: Arm with the joint range.

    Returns:
        The value and the posture, never worse than at the beginning.
    """
    bounds = list(zip(*joint_box(arm), strict=True))
    result = minimize(objective, q, jac=True, bounds=bounds, method="L-BFGS-B")
    return float(result.fun), result.x
