"""Split of the inertia, M = Mbar + dM: Lemma 5, and the bounds of Assumption 3 in numbers."""

from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import counting
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import (
    least,
    mass_matrix_bounds,
    quadratic_gradient,
    random_postures,
)
from ftcfa.model.uncertainty import Uncertainty

POSTURES = 64
"""Postures at which every drawn robot is compared with the nominal one."""
IMPROVED = 8
"""Number of drawn robots, the worst ones, whose posture is then optimised."""


@dataclass(frozen=True, eq=False)
class InertiaSplit:
    """Inertia of an arm at a posture, M = Mbar + dM (Assumption 2).

    Attributes:
        nominal: Mbar, the inertia that the controller knows, shape (n, n) [kg m^2 or kg].
        change: dM = M - Mbar, shape (n, n) [kg m^2 or kg].
    """

    nominal: Array
    change: Array

    @property
    def inverse_change(self) -> Array:
        """Lemma 5: M^-1 - Mbar^-1, shape (n, n); the paper prints I + Mbar dM in it.

        -Mbar^-1 dM (I + Mbar^-1 dM)^-1 Mbar^-1                                        (2)
        """
        identity = np.eye(len(self.nominal))
        inverse = np.linalg.solve(self.nominal, identity)
        relative = np.linalg.solve(self.nominal, self.change)
        return -relative @ np.linalg.solve(identity + relative, inverse)


def inertia_split(nominal: Arm, arm: Arm, q: Array) -> InertiaSplit:
    """Inertia of an arm at a posture, split into the nominal inertia and the rest.

    Args:
        nominal: The robot that the controller knows.
        arm: The true robot, with as many joints.
        q: Posture, shape (n,) [rad or m].

    Raises:
        ShapeError: If q is of another shape.
    """
    Mbar = nominal.mass_matrix(q)
    return InertiaSplit(Mbar, arm.mass_matrix(q) - Mbar)


@dataclass(frozen=True, eq=False)
class InertiaBounds:
    """Assumption 3 in numbers: Mmin |x|^2 <= x^T Mbar x <= Mmax |x|^2 and |dM| <= dM*.

    All are in kg m^2 for revolute joints and in kg for prismatic ones.

    Attributes:
        smallest: Mmin of the nominal arm over its joint range.
        largest: Mmax of the nominal arm over its joint range.
        change: dM*, the largest spectral norm of dM over the joint range and the robots drawn.
        draws: Number of robots drawn; 0 without uncertainty.
        path: Path number of the robot with the largest dM, for `Uncertainty.robot`; None without
            uncertainty.
        posture: Posture of the largest dM, shape (n,) [rad or m]; None without uncertainty.
    """

    smallest: float
    largest: float
    change: float = 0.0
    draws: int = 0
    path: int | None = None
    posture: Array | None = None


def inertia_bounds(
    arm: Arm, uncertainty: Uncertainty | None = None, *, draws: int = 1000, seed: int = 0
) -> InertiaBounds:
    """Mmin, Mmax and dM* of Assumption 3, by search over postures and robots.

    All three are extremes that the search found, not proven bounds. dM* is the largest norm among
    the robots drawn: each is compared with the nominal arm at POSTURES postures, and for the
    IMPROVED worst ones the posture is optimised over the joint range. More draws can only raise
    it. A log-normal distribution has no largest dM; the result is then the largest of the draws.

    Args:
        arm: The nominal arm.
        uncertainty: Distribution of the robots around it; if None, dM* is zero.
        draws: Number of robots, those of the paths 0, 1, ...
        seed: Seed of the draws, 0 <= seed < 2^64.

    Raises:
        ParameterError, UnknownNameError: If `Uncertainty.draw` refuses the arm, or ``draws`` is not
            an integer >= 1.
    """
    smallest, largest = mass_matrix_bounds(arm)
    if uncertainty is None:
        return InertiaBounds(smallest, largest)
    counting("draws", draws)
    inertias = uncertainty.draw(arm, seed, range(draws))["inertias"]
    postures = random_postures(arm, POSTURES)
    norms = np.array([_norms(arm, arm.with_inertias(rows), postures) for rows in inertias])
    worst = np.argsort(norms.max(axis=1))[::-1][:IMPROVED]
    changes = [
        (*_largest_change(arm, inertias[path], postures[norms[path].argmax()]), int(path))
        for path in worst
    ]
    change, posture, path = max(changes, key=lambda each: each[0])
    return InertiaBounds(smallest, largest, change, draws, path, posture)


def _norms(nominal: Arm, robot: Arm, postures: Array) -> Array:
    """Spectral norm of dM at some postures, shape (postures,)."""
    changes = np.array([inertia_split(nominal, robot, q).change for q in postures])
    return np.abs(np.linalg.eigvalsh(changes)).max(axis=1)


def _largest_change(nominal: Arm, inertias: Array, start: Array) -> tuple[float, Array]:
    """Local maximum over postures of the norm of dM, and its posture."""
    robot = nominal.with_inertias(inertias)

    def objective(q: Array) -> tuple[float, Array]:
        values, vectors = np.linalg.eigh(inertia_split(nominal, robot, q).change)
        k = np.abs(values).argmax()
        x = vectors[:, k]
        gradient = quadratic_gradient(robot, q, x) - quadratic_gradient(nominal, q, x)
        return -np.abs(values[k]), -np.sign(values[k]) * gradient

    negative, posture = least(objective, start, nominal)
    return -negative, posture
