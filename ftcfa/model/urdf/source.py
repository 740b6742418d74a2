"""Arms and their source: the arguments that load an arm again, with its changes since."""

import os
from collections.abc import Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from ftcfa.model.arm import Arm
from ftcfa.model.urdf.catalogue import catalogue
from ftcfa.model.urdf.coordinates import EffortLimit
from ftcfa.model.urdf.joints import Locks
from ftcfa.model.urdf.load import Mounting, arm_from_text, load_arm

COMPARED = ("G", "g0", "effort_limit", "damping", "friction", "inertias")
"""Quantities that must be the same when an Arm is loaded again."""
_as_loaded: WeakKeyDictionary[Arm, bool] = WeakKeyDictionary()
"""Arms that were compared already."""


def arm_from_source(
    robot: str | os.PathLike[str],
    *,
    urdf: str | None = None,
    lock: Locks | None = None,
    package_dirs: Sequence[str | os.PathLike[str]] = (),
    gravity: float | Sequence[float] = 9.81,
    effort_limit: EffortLimit | None = None,
    mounting: Mounting = "floor",
    inertias: npt.ArrayLike | None = None,
    damping: npt.ArrayLike | None = None,
    friction: npt.ArrayLike | None = None,
) -> Arm:
    """Load an arm from the arguments of `load_arm`, or from a text and those of `arm_from_text`.

    Args:
        robot: As in `load_arm`, like the rest; beside ``urdf`` how messages name the text.
        urdf: Text of a URDF.
        lock: See there.
        package_dirs: See there.
        gravity: See there.
        effort_limit: See there.
        mounting: See there.
        inertias: Inertias that replace the loaded ones; see `Arm.inertias`.
        damping: Damping that replaces the URDF's.
        friction: Coulomb friction that replaces the URDF's.

    Raises:
        UrdfError, UnknownNameError, ParameterError, ShapeError: As `load_arm`.
    """
    options: dict[str, Any] = {
        "lock": lock, "gravity": gravity, "effort_limit": effort_limit, "mounting": mounting
    }  # fmt: skip
    if urdf is None:
        arm = load_arm(robot, package_dirs=package_dirs, **options)
    else:
        arm = arm_from_text(urdf, robot=str(robot), **options)
    if inertias is not None:
        arm = arm.with_inertias(np.asarray(inertias, dtype=float))
    changed = {"damping": damping, "friction": friction}
    given = {k: np.asarray(it, dtype=float) for k, it in changed.items() if it is not None}
    return arm.with_joint_friction(**given) if given else arm


def has_path(source: Mapping[str, Any]) -> bool:
    """Whether a source has the path of a URDF instead of its text or a name of the catalogue."""
    return "urdf" not in source and source["robot"] not in catalogue()


def is_as_loaded(arm: Arm) -> bool:
    """Whether the source of an arm gives the same arm when it is loaded again."""
    if arm.source is None:
        return False
    if has_path(arm.source) or arm not in _as_loaded:  # a file may change
        _as_loaded[arm] = _same(arm, arm_from_source(**arm.source))
    return _as_loaded[arm]


def _same(first: Arm, second: Arm) -> bool:
    """Whether two arms have the same quantities, bit for bit."""
    return all(map(np.array_equal, _quantities(first), _quantities(second)))


def _quantities(arm: Arm) -> list[Any]:
    tree = arm.tree()
    constants = (tree.parents, tree.rotations, tree.translations, tree.axes, tree.gravity)
    return [*(getattr(arm, name) for name in COMPARED), *constants]
