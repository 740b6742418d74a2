"""Physically consistent changes of inertia, and the bounds of the mass matrix (Assumption 3).

A body's pseudo-inertia J = integral of [x; 1][x; 1]^T dm is positive semidefinite exactly if some
distribution of mass has that mass, centre and rotational inertia (Wensing, Kim, Slotine 2018).
Deforming the body, x -> F x + d, and scaling its density maps J to s T J T^T, which stays
positive (semi)definite whatever the draw: no draw can be unphysical.
"""

from collections.abc import Callable
from numbers import Real
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError

LARGEST_SPREAD = 2.0
"""Of a logarithm, a strain or a displacement [m]. Far beyond it the bodies of one robot differ by
more digits than a double has, and its mass matrix is no longer positive definite."""


def changed_pseudo_inertia(J: Array, factor: Array, displacement: Array, strain: Array) -> Array:
    """Bodies of scaled mass, displaced centre and deformed shape; a massless one stays as it is.

        s T J T^T,   T = [[F, c + d - F c], [0, 1]],   F = exp(strain)

    Computed about the centre of mass c and from a root of the second moments there, so that
    rounding cannot make it indefinite either.

    Args:
        J: Pseudo-inertias, shape (..., 4, 4) [kg m^2, kg m, kg].
        factor: s > 0, shape (...).
        displacement: d, shape (..., 3) [m].
        strain: Symmetric, shape (..., 3, 3): logarithms of lengths, and shears.

    Returns:
        Shape (..., 4, 4), positive (semi)definite.
    """
    m = J[..., 3, 3]
    c = J[..., :3, 3] / np.where(m > 0, m, 1.0)[..., None]
    moments, axes = np.linalg.eigh(J[..., :3, :3] - m[..., None, None] * _square(c))
    root = axes * np.sqrt(np.maximum(moments, 0.0))[..., None, :]
    logarithms, axes = np.linalg.eigh(strain)
    F = (axes * np.exp(logarithms)[..., None, :]) @ np.swapaxes(axes, -1, -2)
    root, c = F @ root, c + displacement
    changed = np.empty((*c.shape[:-1], 4, 4))
    changed[..., :3, :3] = root @ np.swapaxes(root, -1, -2) + m[..., None, None] * _square(c)
    changed[..., :3, 3] = changed[..., 3, :3] = m[..., None] * c
    changed[..., 3, 3] = m
    return np.where((m > 0)[..., None, None], factor[..., None, None] * changed, J)


def _square(c: Array) -> Array:
    """The products c c^T, shape (..., 3, 3)."""
    return c[..., :, None] * c[..., None, :]


def perturbed_pseudo_inertia(
    J: Array, rng: np.random.Generator, mass: float, centre: float, shape: float
) -> Array:
    """Draw bodies near the bodies J: scaled mass, displaced centre, deformed shape.

    Args:
        J: Pseudo-inertias, shape (..., 4, 4) [kg m^2, kg m, kg].
        rng: Source of randomness.
        mass: Standard deviation of the logarithm of the mass.
        centre: Standard deviation of each coordinate of the centre of mass [m].
        shape: Standard deviation of the logarithm of lengths, along any direction.

    Returns:
        The drawn pseudo-inertias, shape (..., 4, 4); positive (semi)definite as J are.
    """
    normals = rng.standard_normal((*J.shape[:-2], 13))
    strain = shape * normals[..., 4:].reshape(*J.shape[:-2], 3, 3)
    return changed_pseudo_inertia(
        J,
        np.exp(mass * normals[..., 0]),
        centre * normals[..., 1:4],
        (strain + np.swapaxes(strain, -1, -2)) / 2,
    )


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


def inertial_parameters(J: Array) -> Array:
    """The inverse of `pseudo_inertia`: shape (..., 10) of shape (..., 4, 4).

    I = tr(S) 1 - S,   S = J[:3, :3]
    """
    xx, yy, zz = J[..., 0, 0], J[..., 1, 1], J[..., 2, 2]
    xy, xz, yz = J[..., 0, 1], J[..., 0, 2], J[..., 1, 2]
    inertia = [yy + zz, -xy, xx + zz, -xz, -yz, xx + yy]
    return np.stack([J[..., 3, 3], *np.moveaxis(J[..., :3, 3], -1, 0), *inertia], axis=-1)


def check_spread(subject: str, value: float) -> None:
    """Raise ParameterError unless a spread is a number from 0 to LARGEST_SPREAD."""
    number = isinstance(value, Real) and not isinstance(value, bool)
    if not (number and 0 <= value <= LARGEST_SPREAD):
        raise ParameterError(subject, repr(value), f"a number from 0 to {LARGEST_SPREAD:g}")


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

    def coriolis_matrix(self, q: Array, v: Array) -> Array:
        """C(q, v) with M' - 2 C skew-symmetric, shape (n, n)."""
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
    """A local minimum over the joint range, by a bounded quasi-Newton search from a posture.

    Args:
        objective: Gives value and gradient at a posture.
        q: Where the search begins, shape (n,).
        arm: Whose joint range it is.

    Returns:
        The value and the posture, never worse than the first one.
    """
    bounds = list(zip(*joint_box(arm), strict=True))
    found = minimize(objective, q, jac=True, bounds=bounds, method="L-BFGS-B")
    return float(found.fun), found.x
