"""Physical plausibility of a URDF: what is refused, and what only gets a warning."""

import numpy as np
from yourdfpy.urdf import Link

from ftcfa.errors import UrdfError
from ftcfa.model.urdf.description import RobotDescription, position_limits

ROUNDING = 1e-15
"""Moments of inertia of a body of one kilogram that are only rounding errors [m^2]."""
INERTIA_TOLERANCE = 1e-6
"""Slack of the inertia checks relative to the largest principal moment: CAD exporters round."""


def lint(
    description: RobotDescription, moving: set[str], coordinates: tuple[str, ...]
) -> tuple[str, ...]:
    """Warnings about an unusual but usable URDF.

    Args:
        description: The URDF.
        moving: Joints that move.
        coordinates: Those of them that are coordinates of the arm.

    Raises:
        UrdfError: If a link that moves has an unphysical inertia.
    """
    moved = description.links_moved_by(moving)
    warnings = []
    for link in description.robot.links:
        defect = _inertia_defect(link)
        if defect is not None:
            if link in moved:
                raise UrdfError(f"{description.file}: link '{link.name}'", *defect)
            got = defect[0]
            warnings.append(f"link '{link.name}': {got}; ignored because the link does not move")
    for link in moved:
        body = link.inertial
        if body is not None and body.mass > 0 and not body.inertia.any():
            warnings.append(f"link '{link.name}': no rotational inertia; taken as a point mass")
        if body is not None and body.mass == 0 and body.inertia.any():
            warnings.append(f"link '{link.name}': rotational inertia without mass")
    for name in coordinates:
        joint = description.moving_joints[name]
        if joint.type != "continuous" and position_limits(joint)[0] == -np.inf:
            warnings.append(f"joint '{name}': no position limits; taken as unlimited")
        if joint.limit is None or not joint.limit.velocity:
            warnings.append(f"joint '{name}': no velocity limit; taken as unlimited")
    return tuple(warnings)


def _inertia_defect(link: Link) -> tuple[str, str, str] | None:
    """Why a link's inertia is unphysical: (got, expected, remedy), or None.

    Mass m >= 0; the rotational inertia about the centre of mass has principal moments
    0 <= a <= b <= c with a + b >= c (the triangle inequality of any real mass distribution).
    """
    if link.inertial is None:
        return None
    if link.inertial.mass < 0:
        return f"mass is {link.inertial.mass:g} kg", "a mass >= 0", "correct <mass>"
    a, b, c = np.linalg.eigvalsh(link.inertial.inertia)
    slack = INERTIA_TOLERANCE * max(abs(a), abs(c)) + ROUNDING * link.inertial.mass
    if a < -slack:
        got = f"inertia is not positive definite (smallest eigenvalue {a:.3g} kg m^2)"
        return got, "principal moments >= 0", "correct <inertia>"
    if a < c - b - slack:
        got = f"inertia violates the triangle inequality ({a:.3g} + {b:.3g} < {c:.3g} kg m^2)"
        return got, "a tensor that a real body can have", "recompute <inertia> from the geometry"
    return None
