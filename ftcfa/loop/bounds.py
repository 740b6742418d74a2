"""Bounds of the joints: the URDF's, and the error beyond which a joint has lost track."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

QUARTER_TURN = np.pi / 2
"""Error of a revolute joint beyond which it has lost track [rad]."""
TRAVEL = 0.1
"""Error of a prismatic joint beyond which it has lost track, as a share of its travel."""


class Bounds(NamedTuple):
    """Bounds of the joints, each a number or shape (n,)."""

    error: Any = np.inf
    """Error beyond which a joint has lost track [rad or m]."""
    lower: Any = -np.inf
    """Lower limit of the position [rad or m]."""
    upper: Any = np.inf
    """Upper limit of the position [rad or m]."""
    velocity: Any = np.inf
    """Limit of the velocity [rad/s or m/s]."""


NO_BOUNDS = Bounds()
"""Bounds that every path keeps."""


def bounds_of(arm: Any, lost: npt.ArrayLike | None = None) -> Bounds:
    """The bounds of an arm.

    Args:
        arm: The arm; one without limits, such as `PaperPendulum`, breaks none.
        lost: Error beyond which a joint has lost track, one number or one for each joint [rad or
            m]; by default a quarter turn, and a tenth of the travel of a prismatic joint. A slide
            without end does not lose track.
    """
    limits = Bounds(
        lower=getattr(arm, "lower", -np.inf),
        upper=getattr(arm, "upper", np.inf),
        velocity=getattr(arm, "velocity_limit", np.inf),
    )
    if lost is None:
        lost = np.where(is_prismatic(arm), TRAVEL * (limits.upper - limits.lower), QUARTER_TURN)
    return limits._replace(error=np.asarray(lost, dtype=float))


def is_prismatic(arm: Any) -> npt.NDArray[np.bool_]:
    """Whether each joint of an arm slides, shape (n,)."""
    return np.array([kind == "prismatic" for kind in arm.joint_types])
