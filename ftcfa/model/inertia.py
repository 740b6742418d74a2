"""Inertial parameters of bodies, and physically consistent changes of them.

A body's pseudo-inertia J = integral of [x; 1][x; 1]^T dm is positive semidefinite exactly if some
distribution of mass has that mass, centre and rotational inertia (Wensing, Kim, Slotine 2018).
To deform the body, x -> F x + d, and to scale its density maps J to s T J T^T, which is always
positive (semi)definite: no draw can be unphysical.
"""

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_number
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.portable import exp, exponential, product, root

UNPHYSICAL = 1e-9
"""Negative eigenvalues of a pseudo-inertia are rounding errors up to this share of its largest
entry."""
LARGEST_SPREAD = 2.0
"""Largest spread of a logarithm, a strain or a displacement [m]. Far beyond it the bodies of one
robot differ by more digits than a double has, and M is no longer numerically positive definite."""


def changed_pseudo_inertia(J: Array, factor: Array, displacement: Array, strain: Array) -> Array:
    """Bodies of scaled mass, displaced centre and deformed shape; massless ones do not change.

        s T J T^T,   T = [[F, c + d - F c], [0, 1]],   F = exp(strain)

    The computation uses a root of the second moments about the centre of mass c, so that rounding
    cannot make the result indefinite, and arithmetic that is the same on every machine.

    Args:
        J: Pseudo-inertias, shape (..., 4, 4) [kg m^2, kg m, kg].
        factor: Factor s > 0 of the mass, shape (...).
        displacement: Displacement d of the centre, shape (..., 3) [m].
        strain: Symmetric strain, shape (..., 3, 3): logarithms of lengths, and shears.

    Returns:
        Shape (..., 4, 4), positive (semi)definite.
    """
    m = J[..., 3, 3]
    c = J[..., :3, 3] / np.where(m > 0, m, 1.0)[..., None]
    moments = root(J[..., :3, :3] - m[..., None, None] * _square(c))
    deformed, c = product(exponential(strain), moments), c + displacement
    changed = np.empty((*c.shape[:-1], 4, 4))
    second = product(deformed, np.swapaxes(deformed, -1, -2))
    changed[..., :3, :3] = second + m[..., None, None] * _square(c)
    changed[..., :3, 3] = changed[..., 3, :3] = m[..., None] * c
    changed[..., 3, 3] = m
    return np.where((m > 0)[..., None, None], factor[..., None, None] * changed, J)


def _square(c: Array) -> Array:
    """Products c c^T, shape (..., 3, 3)."""
    return c[..., :, None] * c[..., None, :]


def perturbed_inertias(
    parameters: Array, rng: np.random.Generator, mass: float, centre: float, shape: float
) -> Array:
    """Random bodies near given ones, shape (..., 10) each; `Arm.perturbed` describes the rest."""
    for name, spread in (("mass", mass), ("centre", centre), ("shape", shape)):
        check_spread(f"perturbation '{name}'", spread)
    bodies = parameters.shape[:-1]
    normals = rng.standard_normal((*bodies, 13))
    strain = shape * normals[..., 4:].reshape(*bodies, 3, 3)
    J = changed_pseudo_inertia(
        pseudo_inertia(parameters),
        exp(mass * normals[..., 0]),
        centre * normals[..., 1:4],
        (strain + np.swapaxes(strain, -1, -2)) / 2,
    )
    return inertial_parameters(J)


def pseudo_inertia(parameters: Array) -> Array:
    """Pseudo-inertias, shape (..., 4, 4), of inertial parameters as in `Arm.inertias`, (..., 10).

    J = [[tr(I)/2 1 - I, h], [h^T, m]],   I about the origin, h = m c
    """
    m, h = parameters[..., 0], parameters[..., 1:4]
    xx, xy, yy, xz, yz, zz = np.moveaxis(parameters[..., 4:], -1, 0)
    I = symmetric(xx, yy, zz, xy, xz, yz)  # noqa: E741
    J = np.empty((*m.shape, 4, 4))
    J[..., :3, :3] = ((xx + yy + zz) / 2)[..., None, None] * np.eye(3) - I
    J[..., :3, 3] = J[..., 3, :3] = h
    J[..., 3, 3] = m
    return J


def symmetric(xx: Array, yy: Array, zz: Array, xy: Array, xz: Array, yz: Array) -> Array:
    """Symmetric matrices, shape (..., 3, 3), of their entries, shape (...)."""
    rows = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1)
    return rows.reshape(*rows.shape[:-1], 3, 3)


def steiner(m: float, d: Array) -> Array:
    """What a distance d from the centre of mass adds to an inertia, m (d^T d 1 - d d^T), (3, 3)."""
    x, y, z = d
    return m * symmetric(y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)


def inertial_parameters(J: Array) -> Array:
    """Inertial parameters, shape (..., 10), of pseudo-inertias, shape (..., 4, 4).

    I = tr(S) 1 - S,   S = J[:3, :3]
    """
    xx, yy, zz = J[..., 0, 0], J[..., 1, 1], J[..., 2, 2]
    xy, xz, yz = J[..., 0, 1], J[..., 0, 2], J[..., 1, 2]
    inertia = [yy + zz, -xy, xx + zz, -xz, -yz, xx + yy]
    return np.stack([J[..., 3, 3], *np.moveaxis(J[..., :3, 3], -1, 0), *inertia], axis=-1)


def inertial_weights(parameters: Array) -> Array:
    """Scale of the inertial parameters, shape (N, 10), for an adaptive law, shape (10 N,).

        W = m (1, r^2, r^2, r^2, r^4, ..., r^4) for every body,   r^2 = tr I/(2 m)

    I is the body's inertia about the joint's origin, and so r its radius of gyration there.
    Parameters that are moved by W times a gradient move in proportion to the body's own.
    """
    mass, square = parameters[:, 0], parameters[:, [4, 6, 9]].sum(axis=1) / 2.0  # m, m r^2
    massive = mass > 0
    r2 = np.where(massive, square, 0.0) / np.where(massive, mass, 1.0)
    return np.stack([mass, *[mass * r2] * 3, *[mass * r2**2] * 6], axis=1).ravel()


def check_bodies(subject: str, parameters: Array, bodies: int) -> None:
    """Raise unless inertial parameters, shape (..., bodies, 10), are those of possible bodies.

    Raises:
        ShapeError: If the shape is wrong.
        ParameterError: If no distribution of mass has these parameters.
    """
    rows = np.asarray(parameters, dtype=float)
    if rows.shape[-2:] != (bodies, 10):
        raise ShapeError(subject, f"shape {rows.shape}", f"{(bodies, 10)}")
    smallest = np.linalg.eigvalsh(pseudo_inertia(rows))[..., 0]
    slack = UNPHYSICAL * np.abs(rows).max(axis=-1)
    if np.any(smallest < -slack) or not np.all(np.isfinite(rows)):
        got = f"a pseudo-inertia with the eigenvalue {smallest.min():.3g}"
        expected, remedy = "positive semidefinite pseudo-inertias", "draw them with Arm.perturbed"
        raise ParameterError(subject, got, expected, remedy)


def check_spread(subject: str, value: float, unit: str = "") -> None:
    """Raise ParameterError unless a spread is a number from 0 to LARGEST_SPREAD."""
    if not (is_number(value) and 0 <= value <= LARGEST_SPREAD):
        expected = f"a number from 0 to {LARGEST_SPREAD:g}{unit and f' [{unit}]'}"
        raise ParameterError(subject, repr(value), expected)
