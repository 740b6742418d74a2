"""Bodies that no distribution of mass can have, and the nearest ones that some can.

A body of mass m > 0 is physical exactly if its second moments about the centre of mass,
S = tr(I)/2 1 - I, are positive semidefinite (Wensing, Kim, Slotine 2018): the principal moments
a <= b <= c of I are then not negative and a + b >= c.
"""

import copy
from collections.abc import Iterable
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np
from yourdfpy.urdf import Link

from ftcfa.arrays import Array
from ftcfa.errors import UrdfError
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import random_postures
from ftcfa.model.urdf.blueprint import Blueprint
from ftcfa.model.urdf.description import RobotDescription, raise_all

Repair: TypeAlias = Literal["project"]
"""How unphysical inertias are made physical."""
NEGLIGIBLE = 1e-3
"""Repairs that change M by less, relative to sqrt(M_ii M_jj), are made without being asked for."""
ROUNDING = 1e-15
"""Moments of inertia of a body of one kilogram that are only rounding errors [m^2]."""
TOLERANCE = 1e-6
"""Slack of the checks relative to the largest principal moment: CAD exporters round."""
POSTURES = 256
"""Number of random postures in which the change of M is computed."""
GRID = 2.0**-40
"""Grid of a repaired inertia as a share of its largest entry's power of two: the last digits of
eigenvectors depend on the machine."""
ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}


def defect(link: Link) -> tuple[str, str, str] | None:
    """Why a link's inertia is unphysical: (got, expected, remedy), or None."""
    if link.inertial is None:
        return None
    if link.inertial.mass < 0:
        return f"mass is {link.inertial.mass:g} kg", "a mass >= 0", "correct <mass>"
    a, b, c = np.linalg.eigvalsh(link.inertial.inertia)
    slack = TOLERANCE * max(abs(a), abs(c)) + ROUNDING * link.inertial.mass
    if a < -slack:
        got = f"inertia is not positive definite (smallest eigenvalue {a:.3g} kg m^2)"
        return got, "principal moments >= 0", "correct <inertia>"
    if a < c - b - slack:
        got = f"inertia violates the triangle inequality ({a:.3g} + {b:.3g} < {c:.3g} kg m^2)"
        return got, "a tensor that a real body can have", "recompute <inertia> from the geometry"
    return None


def projected(inertia: Array) -> Array:
    """The nearest inertia of a real body with the same mass and centre of mass, shape (3, 3).

    Second moments S = tr(I)/2 1 - I lose their negative eigenvalues, which is the nearest
    positive semidefinite matrix in the Frobenius norm; so is, with mass and first moment held, the
    pseudo-inertia.
    """
    values, vectors = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    S = (vectors * np.maximum(values, 0.0)) @ vectors.T
    physical = np.trace(S) * np.eye(3) - S
    grid = GRID * 2.0 ** np.frexp(np.abs(physical).max())[1]
    return np.asarray(np.round(physical / grid) * grid)


def body_faults(description: RobotDescription, links: Iterable[Link]) -> list[UrdfError]:
    """A fault for each unphysical link."""
    found = {link.name: defect(link) for link in links}
    return [
        UrdfError(f"{description.file}: link '{name}'", *why) for name, why in found.items() if why
    ]


def physical(plan: Blueprint, arm: Arm, repair: Repair | None) -> tuple[Arm, list[str]]:
    """The arm of a plan with the nearest physical inertias, and warnings of what changed.

    Raises:
        UrdfError: If a mass is not positive, or M changes by NEGLIGIBLE or more and no repair was
            asked for.
    """
    description, links = plan.description, [link for link in plan.moved() if defect(link)]
    faults = body_faults(description, links)
    raise_all([f for f, link in zip(faults, links, strict=True) if link.inertial.mass <= 0])
    if not links:
        return arm, []
    nearest = replace(plan, description=_repaired(description, links)).arm()
    home, worst = _change_of_inertia(arm, nearest)
    price = f"M changes by {home:.2g} at home and {worst:.2g} at worst, of sqrt(M_ii M_jj)"
    if repair is None and worst >= NEGLIGIBLE:
        option = f'or pass repair="project" (--repair): {price}'
        raise_all(
            [UrdfError(f.subject, f.got, f.expected, f"{f.remedy}, {option}") for f in faults]
        )
    return nearest, [f"link '{link.name}': {_change(link)}; {price}" for link in links]


def _repaired(description: RobotDescription, links: Iterable[Link]) -> RobotDescription:
    """A description in which the inertias of some links are the nearest physical ones."""
    root = copy.deepcopy(description.root)
    elements = {link.get("name"): link for link in root.iterchildren("link")}
    for link in links:
        inertia = projected(link.inertial.inertia)
        for key, entry in ENTRIES.items():
            elements[link.name].find("inertial/inertia").set(key, repr(float(inertia[entry])))
    return replace(description, root=root)


def _change(link: Link) -> str:
    """How the nearest inertia differs from a link's own."""
    before, after = (
        ", ".join(f"{x:.3g}" for x in np.linalg.eigvalsh(inertia))
        for inertia in (link.inertial.inertia, projected(link.inertial.inertia))
    )
    return f"principal moments ({before}) become ({after}) kg m^2"


def _change_of_inertia(before: Arm, after: Arm) -> tuple[float, float]:
    """How much M changes at home, and at worst over random postures of the range.

    The largest |dM_ij| / sqrt(M_ii M_jj), with M of the arm ``after``.
    """
    shares = []
    for q in (after.home, *random_postures(after, POSTURES)):
        M = after.mass_matrix(q)
        scale = np.sqrt(np.maximum(np.diag(M), np.finfo(float).tiny))
        shares.append(float(np.max(np.abs(before.mass_matrix(q) - M) / np.outer(scale, scale))))
    return shares[0], max(shares)
