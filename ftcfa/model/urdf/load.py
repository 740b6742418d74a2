"""`load_arm` makes an Arm of a name or a URDF file, or says in one sentence what is wrong.

The source of an Arm holds the arguments that load it again, with its changes since.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, get_args
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import Check, about, known_name, vector
from ftcfa.errors import ParameterError, UrdfError
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import random_postures
from ftcfa.model.tip import tip
from ftcfa.model.urdf.blueprint import Blueprint
from ftcfa.model.urdf.bodies import Repair, body_faults, physical
from ftcfa.model.urdf.catalogue import catalogue, locate, package_folders
from ftcfa.model.urdf.description import RobotDescription, raise_all, read_urdf
from ftcfa.model.urdf.joints import (
    JointValues,
    Locks,
    check_armature,
    check_effort_limit,
    effort_faults,
    joint_rules,
    locked_joints,
    range_faults,
)
from ftcfa.model.urdf.lint import lint_bodies, lint_efforts, lint_joints
from ftcfa.model.urdf.text import is_xacro, read_bytes
from ftcfa.model.urdf.xacro import expand

SINGULAR = 1e-10
"""A mass matrix scaled to unit diagonal is singular below this eigenvalue."""
SINGULARITY_SAMPLES = 64
"""Number of random postures at which M is checked."""
ORTHOGONAL = 1e-9
"""Largest entry of R^T R - 1 for which R counts as a rotation."""
Mounting: TypeAlias = Literal["floor", "wall", "ceiling"] | npt.ArrayLike
"""Name or rotation matrix of the orientation of the base in the world."""
MOUNTINGS: Mapping[str, Array] = {
    "floor": np.eye(3),
    "wall": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    "ceiling": np.diag([1.0, -1.0, -1.0]),
}
"""Orientations of the base in the world; columns are the axes of the base. On a wall its z axis
points along the world's x and its x axis downwards; on the ceiling it is turned by pi about x."""
_as_loaded: WeakKeyDictionary[Arm, bool] = WeakKeyDictionary()
"""Arms that were compared already."""


def _gravity_field(subject: str, gravity: float | Sequence[float]) -> Array:
    """Gravity field, shape (3,) [m/s^2], of a downward acceleration or of a vector."""
    field = vector(subject, gravity, 3)
    return np.array([0.0, 0.0, -field[2]]) if np.ndim(gravity) == 0 else field


def _mounting(subject: str, mounting: Mounting) -> Array:
    """Rotation matrix of the base in the world, shape (3, 3), of a name or a matrix."""
    if isinstance(mounting, str):
        known_name(subject, mounting, MOUNTINGS)
        return MOUNTINGS[mounting]
    try:
        R = np.asarray(mounting, dtype=float)
    except (TypeError, ValueError):
        R = np.zeros(0)
    if R.shape != (3, 3) or not (
        np.abs(R.T @ R - np.eye(3)).max() <= ORTHOGONAL and np.linalg.det(R) > 0
    ):
        known = ", ".join(f'"{name}"' for name in MOUNTINGS)
        got = mounting.tolist() if isinstance(mounting, np.ndarray) else mounting
        expected = f"{known} or a rotation matrix (3, 3)"
        raise ParameterError(subject, repr(got), expected)
    return R


def load_arm(
    robot: str | os.PathLike[str],
    *,
    lock: Locks | None = None,
    package_dirs: Sequence[str | os.PathLike[str]] = (),
    gravity: float | Sequence[float] = 9.81,
    effort_limit: JointValues | None = None,
    armature: JointValues | None = None,
    mounting: Mounting = "floor",
    repair: Repair | None = None,
    xacro_args: Mapping[str, str] | None = None,
    tool: str | None = None,
) -> Arm:
    """Load a fixed-base arm from its URDF.

    Args:
        robot: An arm of the catalogue (``"panda"``), a path to a URDF or a xacro file, or a
            ``package://`` path.
        lock: Joints that do not move: names with values [rad or m], or names alone, which are
            held at their home position.
        package_dirs: Folders that are searched for ``package://NAME/...``, before those of the
            environment variable ROS_PACKAGE_PATH.
        gravity: Downward acceleration, or the gravity field in world axes, shape (3,) [m/s^2].
        effort_limit: Torque limits u* that override those of the URDF: one number, n numbers, or
            some by joint name [N m or N].
        armature: Rotor inertias J r^2 at the joints, for rotors of inertia J behind gears of ratio
            r, in the same forms [kg m^2 or kg]. Without it: the catalogue's, and those of the
            URDF's <transmission> elements (drake:rotor_inertia, drake:gear_ratio).
        mounting: Orientation of the base in the world: ``"floor"``, ``"wall"``, ``"ceiling"`` or a
            rotation matrix whose columns are the axes of the base. Gravity and the vibration
            stay in world axes, z upwards.
        repair: ``"project"`` turns inertias that no body can have into the nearest ones that some
            body has; masses and centres stay. None does so only where M changes by less than
            NEGLIGIBLE of sqrt(M_ii M_jj), and refuses the file otherwise. Warnings of the arm say
            what changed.
        xacro_args: Arguments of a xacro file by name (``{"prefix": "left_"}``). A xacro file needs
            the extra ``xacro``; it may include files of its own package and of ``package_dirs``.
        tool: Link or joint whose errors are shown in metres, such as ``"tool0"``; by default the
            one that most joints move, and of several the one farthest down the chain.

    Raises:
        UrdfError: If the URDF is unusable; the message names file, element and remedy.
        UnknownNameError: If the robot or a joint is unknown; the message lists the known ones.
        ParameterError, ShapeError: If an argument is of the wrong type, range or shape.
    """
    return arm_from_source(
        robot, lock=lock, package_dirs=package_dirs, gravity=gravity, effort_limit=effort_limit,
        armature=armature, mounting=mounting, repair=repair, xacro_args=xacro_args, tool=tool,
    )  # fmt: skip


def arm_from_source(
    robot: str | os.PathLike[str],
    *,
    urdf: str | None = None,
    lock: Locks | None = None,
    package_dirs: Sequence[str | os.PathLike[str]] = (),
    gravity: Annotated[float | Sequence[float], Check(_gravity_field)] = 9.81,
    effort_limit: Annotated[JointValues | None, Check(check_effort_limit)] = None,
    armature: Annotated[JointValues | None, Check(check_armature)] = None,
    mounting: Annotated[Mounting, Check(_mounting)] = "floor",
    repair: Repair | None = None,
    xacro_args: Mapping[str, str] | None = None,
    tool: str | None = None,
    inertias: npt.ArrayLike | None = None,
    damping: npt.ArrayLike | None = None,
    friction: npt.ArrayLike | None = None,
) -> Arm:
    """Load an arm like `load_arm`, or from a text, and replace the quantities that are given.

    The text of a URDF is ``urdf``; ``robot`` then is its name in messages. The quantities are
    ``inertias`` (see `Arm.inertias`), ``damping`` and ``friction``. Raises what `load_arm` raises.
    """
    if urdf is not None:
        content = urdf.encode()
        if is_xacro(content):
            remedy = "run `xacro FILE > arm.urdf` first"
            raise UrdfError(str(robot), "xacro, not expanded", "plain URDF", remedy)
        entry, description = None, read_urdf(Path(robot), content)
        source: dict[str, Any] = {"urdf": urdf, "robot": str(robot)}
    else:
        entry, file = locate(robot, package_dirs)
        with about("robot"):
            content = read_bytes(file)
            source = {"robot": str(robot if entry is not None else file.resolve())}
            if is_xacro(content):
                content = expand(file, package_folders(package_dirs), xacro_args or {})
                source["urdf"] = content.decode()
            description = read_urdf(file, content)
    if repair is not None:
        known_name("repair", repair, get_args(Repair), field="repair")
        source["repair"] = repair
    locks = locked_joints(description, entry, lock)
    with about("gravity"):
        field = _gravity_field("gravity", gravity)
    with about("mounting"):
        turn = _mounting("mounting", mounting)
    rules = joint_rules(description, locks)
    plan = Blueprint(description, entry, source, locks, rules, field, turn, effort_limit, armature)
    arm = _with_tool(_arm(plan, lock, repair), tool)
    if inertias is not None:
        arm = arm.with_inertias(np.asarray(inertias, dtype=float))
    if damping is None and friction is None:
        return arm
    return arm.with_joint_friction(damping, friction)


def _with_tool(arm: Arm, tool: str | None) -> Arm:
    """An arm with a tool."""
    if tool is None:
        return replace(arm, tool=tip(arm))
    known_name(f"tool of {arm.name}", tool, arm.frame_names, field="tool")
    return replace(arm, tool=tool, source={**(arm.source or {}), "tool": tool})


def _arm(plan: Blueprint, lock: Locks | None, repair: Repair | None) -> Arm:
    """The arm of a plan without faults, with its warnings."""
    description = plan.description
    if not any(rule.leader for rule in plan.rules.values()):
        raise_all([*description.faults, _nothing_moves(description, lock)])
    arm, moved = plan.arm(), plan.moved()
    names = arm.joint_names
    faults = [*description.faults, *range_faults(description, names)]
    faults += effort_faults(description, names, arm.effort_limit)
    if not any(link.inertial for link in moved) and not description.faults:
        got, expected = "no moving link has an <inertial>", "mass and inertia of links"
        remedy = "add them; CAD exporters compute them from the geometry"
        faults.append(UrdfError(str(description.file), got, expected, remedy))
    if faults:
        raise_all([*faults, *body_faults(description, moved)])
    arm, repairs = physical(plan, arm, repair)
    _refuse_singular(description, arm)
    warnings = [*description.warnings, *repairs, *lint_bodies(description, moved)]
    for name, value in description.armature.items():
        warnings.append(f"joint '{name}': rotor inertia {value:.4g} of its <transmission> is in M")
    warnings += [*lint_joints(description, names), *lint_efforts(arm)]
    return replace(arm, warnings=tuple(warnings))


def _nothing_moves(description: RobotDescription, lock: Locks | None) -> UrdfError:
    got, expected, remedy = "nothing in it can move", "a joint that is not fixed", "export it again"
    if description.moving_joints:
        got, expected, remedy = "no joint moves", "at least one free joint", "lock fewer joints"
    field = "lock" if lock else ""
    return UrdfError(str(description.file), got, expected, remedy, field=field)


def _refuse_singular(description: RobotDescription, arm: Arm) -> None:
    """Raise UrdfError unless M is positive definite at home and at random postures."""
    for q in (arm.home, *random_postures(arm, SINGULARITY_SAMPLES)):
        M = arm.mass_matrix(q)
        scale = np.sqrt(np.maximum(np.diag(M), 0.0))
        if np.all(scale > 0):
            values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
            if values[0] > SINGULAR:
                continue
            joint = int(np.argmax(np.abs(vectors[:, 0])))
        else:
            joint = int(np.argmin(scale))
        subject = description.subject(arm.joint_names[joint])
        got = f"the mass matrix is singular at q = {np.round(q, 3).tolist()}"
        expected = "links with mass and inertia beyond every joint"
        remedy = "give the links it moves an <inertial>, or lock the joint"
        raise UrdfError(subject, got, expected, remedy)


def has_path(source: Mapping[str, Any]) -> bool:
    """Whether a source has the path of a URDF instead of its text or a name of the catalogue."""
    return "urdf" not in source and source["robot"] not in catalogue()


def is_as_loaded(arm: Arm) -> bool:
    """Whether the source of an arm gives the same arm, bit for bit, when it is loaded again."""
    if arm.source is None:
        return False
    if has_path(arm.source) or arm not in _as_loaded:  # a file may change
        again = _quantities(arm_from_source(**arm.source))
        _as_loaded[arm] = all(map(np.array_equal, _quantities(arm), again))
    return _as_loaded[arm]


def _quantities(arm: Arm) -> list[Any]:
    """Quantities that must be the same when an Arm is loaded again."""
    tree = arm.tree()
    own = (arm.G, arm.g0, arm.effort_limit, arm.damping, arm.friction, arm.armature, arm.inertias)
    return [*own, tree.parents, tree.rotations, tree.translations, tree.axes, tree.gravity]
