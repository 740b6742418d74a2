"""Physically consistent changes of inertia, and the bounds of the mass matrix (Assumption 3).

A body's pseudo-inertia J = integral of [x; 1][x; 1]^T dm is positive semidefinite exactly if some
distribution of mass has that mass, centre and rotational inertia (Wensing, Kim, Slotine 2018).
Deforming the body, x -> F x + d, and scaling its density maps J to s T J T^T, which stays
positive (semi)definite whatever the draw: no draw can be unphysical.
"""

from numbers import Real
from typing import Protocol

import numpy as np
from scipy.linalg import expm
from scipy.optimize import minimize

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError


def perturbed_pseudo_inertia(
    J: Array, rng: np.random.Generator, mass: float, centre: float, shape: float
) -> Array:
    """Draw a body near the body J: scaled mass, displaced centre, deformed shape.

    Args:
        J: Pseudo-inertia, shape (4, 4) [kg m^2, kg m, kg].
        rng: Source of randomness.
        mass: Standard deviation of the logarithm of the mass.
        centre: Standard deviation of each coordinate of the centre of mass [m].
        shape: Standard deviation of the logarithm of lengths, by axis and shear.

    Returns:
        The drawn pseudo-inertia, shape (4, 4); positive (semi)definite as J is.
    """
    log_mass = mass * rng.standard_normal()
    displacement = centre * rng.standard_normal(3)
    strain = shape * rng.standard_normal((3, 3))
    if J[3, 3] <= 0:
        return J
    F = expm((strain + strain.T) / 2)
    c = J[:3, 3] / J[3, 3]
    T = np.eye(4)
    T[:3, :3] = F
    T[:3, 3] = c + displacement - F @ c
    return np.exp(log_mass) * T @ J @ T.T


def pseudo_inertia(parameters: Array) -> Array:
    """Pseudo-inertias, shape (..., 4, 4), of inertial parameters as in `Arm.inertias`, (..., 10).

    J = [[tr(I)/2 1 - I, h], [h^T, m]],   I about the origin, h = m c
    """
    m, h = parameters[..., 0], parameters[..., 1:4]
    xx, xy, yy, xz, yz, zz = np.moveaxis(parameters[..., 4:], -1, 0)
    inertia = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*m.shape, 3, 3)
    J = np.empty((*m.shape, 4, 4))
    J[..., :3, :3] = ((xx + yy + zz) / 2)[..., None, None] * np.eye(3) - inertia
    J[..., :3, 3] = J[..., 3, :3] = h
    J[..., 3, 3] = m
    return J


def check_spread(**spreads: float) -> None:
    """Raise ParameterError unless every spread is a number >= 0."""
    for name, value in spreads.items():
        if not (isinstance(value, Real) and 0 <= value < np.inf):
            raise ParameterError(f"perturbation '{name}'", f"{value!r}", "a number >= 0")


class HasMassMatrix(Protocol):
    """What the bounds need of an arm."""

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


def joint_box(arm: HasMassMatrix) -> tuple[Array, Array]:
    """The joint range, shape (n,) each [rad or m]; an unlimited joint counts as [-pi, pi]."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return lower, upper


def mass_matrix_bounds(
    arm: HasMassMatrix, samples: int = 256, starts: int = 3
) -> tuple[float, float]:
    """Smallest and largest eigenvalue of M over the joint range: Mmin, Mmax of Assumption 3.

    Random sampling finds ``starts`` promising postures, a bounded quasi-Newton search improves
    each; deterministic. The result is the best posture found, not a proof of optimality.

    Returns:
        (Mmin, Mmax) [kg m^2 for revolute joints, kg for prismatic ones].
    """
    lower, upper = joint_box(arm)
    rng = np.random.default_rng(0)
    postures = rng.uniform(lower, upper, (samples, arm.n))

    def extreme(sign: float, index: int) -> float:
        def objective(q: Array) -> float:
            return sign * float(np.linalg.eigvalsh(arm.mass_matrix(q))[index])

        best = sorted(postures, key=objective)[:starts]
        bounds = list(zip(lower, upper, strict=True))
        found = [minimize(objective, q, bounds=bounds, method="L-BFGS-B").fun for q in best]
        return sign * float(min(found))

    return extreme(1.0, 0), extreme(-1.0, -1)
