"""`load_arm`: from a name or a URDF file to an Arm, or to one sentence that says what is wrong."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import vector
from ftcfa.errors import ParameterError, UnknownNameError, UrdfError
from ftcfa.model.arm import Arm
from ftcfa.model.mass_matrix_bounds import joint_box
from ftcfa.model.pinocchio_model import model_of_urdf
from ftcfa.model.urdf.catalogue import CatalogueEntry, catalogue, find_arm
from ftcfa.model.urdf.description import (
    RobotDescription,
    inertia_defect,
    position_limits,
    read_urdf,
)
from ftcfa.model.urdf.joints import JointRule, joint_rules

SINGULAR = 1e-10
"""A mass matrix scaled to unit diagonal is singular below this eigenvalue."""
SINGULARITY_SAMPLES = 64
ORTHOGONAL = 1e-9
"""Largest entry of R^T R - 1 of a rotation."""
MOUNTINGS: Mapping[str, Array] = {
    "floor": np.eye(3),
    "wall": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
    "ceiling": np.diag([1.0, -1.0, -1.0]),
}
"""Orientations of the base in the world by name, columns its axes: on a wall its z points along
the world's x and its x downwards; at the ceiling it is turned over about x."""

Locks = Mapping[str, float] | Iterable[str]
EffortLimit = float | Sequence[float] | Mapping[str, float]


def load_arm(
    robot: str | os.PathLike[str],
    *,
    lock: Locks | None = None,
    package_dirs: Sequence[str | os.PathLike[str]] = (),
    gravity: float | Sequence[float] = 9.81,
    effort_limit: EffortLimit | None = None,
    mounting: str | npt.ArrayLike = "floor",
) -> Arm:
    """Load a fixed-base arm from its URDF.

    Args:
        robot: An arm of the catalogue (``"panda"``), a path to a URDF, or a ``package://`` path.
        lock: Joints that do not move: names with values [rad or m], or names alone (held at
            their home posture, zero by default).
        package_dirs: Folders in which ``package://NAME/...`` is looked for, before those of the
            environment variable ROS_PACKAGE_PATH.
        gravity: Downward acceleration, or the gravity field in world axes, shape (3,) [m/s^2].
        effort_limit: Torque limits u* that replace the URDF's: one number, n numbers, or some by
            joint name [N m or N].
        mounting: Orientation of the base in the world: ``"floor"``, ``"wall"``, ``"ceiling"`` or a
            rotation matrix whose columns are the axes of the base. Gravity and what shakes the
            base stay in world axes, z upwards.

    Raises:
        UrdfError: If the URDF is unusable; the sentence names file, element and remedy.
        UnknownNameError: If the robot or a joint is not known; it lists the known ones.
        ParameterError, ShapeError: If an argument is of the wrong type, range or shape.
    """
    entry, file = _locate(robot, package_dirs)
    description = read_urdf(file)
    source = {"robot": str(robot if entry is not None else file.resolve())}
    return _arm(description, entry, source, lock, gravity, effort_limit, mounting)


def arm_from_text(
    urdf: str,
    *,
    robot: str = "robot.urdf",
    lock: Locks | None = None,
    gravity: float | Sequence[float] = 9.81,
    effort_limit: EffortLimit | None = None,
    mounting: str | npt.ArrayLike = "floor",
) -> Arm:
    """Load an arm from the text of a URDF, such as a description that was sent carries.

    Args:
        urdf: The text.
        robot: What messages call it.
        lock: As in `load_arm`, like the rest.
        gravity: See there.
        effort_limit: See there.
        mounting: See there.

    Raises:
        UrdfError, UnknownNameError, ParameterError, ShapeError: As `load_arm`.
    """
    description = read_urdf(Path(robot), urdf.encode())
    source = {"urdf": urdf, "robot": robot}
    return _arm(description, None, source, lock, gravity, effort_limit, mounting)


def _arm(
    description: RobotDescription,
    entry: CatalogueEntry | None,
    source: Mapping[str, str],
    lock: Locks | None,
    gravity: float | Sequence[float],
    effort_limit: EffortLimit | None,
    mounting: str | npt.ArrayLike,
) -> Arm:
    """The arm of a URDF that was read; ``source`` says where it came from."""
    file = description.file
    locks = _locks(description, entry, lock)
    rules = joint_rules(description, locks)
    moving = {name for name, rule in rules.items() if rule.leader is not None}
    if not moving:
        raise UrdfError(str(file), "no joint moves", "at least one free joint", "lock fewer joints")
    warnings = _lint_links(description, moving)
    field = _gravity_field(gravity)
    turn = _mounting(mounting)
    model = model_of_urdf(description.pinocchio_xml(), field, turn)
    names = tuple(name for name in model.names[1:] if rules[name].leader == name)
    G, g0 = _coordinate_map(list(model.names[1:]), names, rules)
    lower, upper, velocity = _limits(description, names, warnings)
    effort = _effort_limit(description, names, effort_limit)
    arm = Arm(
        name=description.robot.name if entry is None else source["robot"],
        model=model,
        G=G,
        g0=g0,
        joint_names=names,
        joint_types=tuple(description.moving_joints[name].type for name in names),
        lower=lower,
        upper=upper,
        velocity_limit=velocity,
        effort_limit=effort,
        damping=_dynamics(description, model.names[1:], "damping"),
        friction=_dynamics(description, model.names[1:], "friction"),
        home=np.array([_home(description, entry, name) for name in names]),
        warnings=tuple(warnings),
        source={
            **source,
            "lock": dict(locks),
            "gravity": field.tolist(),
            "effort_limit": effort.tolist(),
            "mounting": turn.tolist(),
        },
    )
    _refuse_singular(file, arm)
    return arm


def _locate(
    robot: str | os.PathLike[str], package_dirs: Sequence[str | os.PathLike[str]]
) -> tuple[CatalogueEntry | None, Path]:
    if not isinstance(robot, (str, os.PathLike)):
        raise ParameterError("robot", repr(robot), "a name or the path of a URDF")
    text = os.fspath(robot)
    if text.startswith("package://"):
        return None, _find_in_packages(text, package_dirs)
    if isinstance(robot, str) and robot in catalogue():
        entry = find_arm(robot)
        return entry, entry.path()
    if text.lstrip().startswith("<"):
        raise ParameterError("robot", "XML text", "a name or a path", "write the text to a file")
    path = Path(text)
    exists = os.path.exists(path)  # noqa: PTH110 (pathlib's raises where a name is too long)
    if isinstance(robot, str) and len(path.parts) == 1 and not path.suffix and not exists:
        find_arm(robot)  # raises, and lists the known ones
    return None, path


def _find_in_packages(uri: str, package_dirs: Sequence[str | os.PathLike[str]]) -> Path:
    package, _, inside = uri.removeprefix("package://").partition("/")
    from_ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    if isinstance(package_dirs, (str, os.PathLike)):
        package_dirs = [package_dirs]
    folders = [Path(folder).resolve() for folder in (*package_dirs, *from_ros) if folder]
    for folder in folders:
        for root in (folder / package, *([folder] if folder.name == package else [])):
            if (root / inside).is_file():
                return root / inside
    looked = ", ".join(map(str, folders)) or "nowhere"
    raise UrdfError(uri, f"not found (looked in: {looked})", "", "give package_dirs=[...]")


def _locks(
    description: RobotDescription, entry: CatalogueEntry | None, lock: Locks | None
) -> dict[str, float]:
    """Joint values to hold: what the catalogue locks, then what the user asks for."""
    locks: dict[str, float] = {}
    if entry is not None and entry.joints:
        independent = (j.name for j in description.moving_joints.values() if j.mimic is None)
        locked = (name for name in independent if name not in entry.joints)
        locks = {name: _home(description, entry, name) for name in locked}
    if isinstance(lock, str):
        lock = [lock]
    elif lock is None:
        lock = []
    if not isinstance(lock, Iterable):
        raise ParameterError("lock", repr(lock), "joint names, or names with values [rad or m]")
    if not isinstance(lock, Mapping):
        lock = {name: _home(description, entry, name) for name in map(str, lock)}
    for name, value in lock.items():
        numeric = isinstance(value, int | float | np.integer | np.floating)
        if not numeric or isinstance(value, bool) or not np.isfinite(value):
            raise ParameterError(f"lock of joint '{name}'", repr(value), "a number [rad or m]")
    return locks | {name: float(value) for name, value in lock.items()}


def _gravity_field(gravity: float | Sequence[float]) -> Array:
    """The field, shape (3,) [m/s^2], of a downward acceleration or of a vector."""
    field = vector("gravity", gravity, 3)
    return np.array([0.0, 0.0, -field[2]]) if np.ndim(gravity) == 0 else field


def _mounting(mounting: str | npt.ArrayLike) -> Array:
    """Orientation of the base in the world, shape (3, 3)."""
    if isinstance(mounting, str):
        if mounting not in MOUNTINGS:
            raise UnknownNameError("mounting", mounting, tuple(MOUNTINGS))
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
        raise ParameterError("mounting", repr(got), f"{known} or a rotation matrix (3, 3)")
    return R


def _lint_links(description: RobotDescription, moving: set[str]) -> list[str]:
    """Refuse unphysical links that move; warn of the odd ones."""
    moved = description.links_moved_by(moving)
    warnings = []
    for link in description.robot.links:
        defect = inertia_defect(link)
        if defect is not None:
            if link in moved:
                raise UrdfError(f"{description.file}: link '{link.name}'", *defect)
            warnings.append(f"link '{link.name}': {defect[0]}; ignored, it does not move")
    for link in moved:
        body = link.inertial
        if body is not None and body.mass > 0 and not body.inertia.any():
            warnings.append(f"link '{link.name}': no rotational inertia, a point mass")
        if body is not None and body.mass == 0 and body.inertia.any():
            warnings.append(f"link '{link.name}': rotational inertia without mass")
    return warnings


def _coordinate_map(
    joints: list[str], names: tuple[str, ...], rules: Mapping[str, JointRule]
) -> tuple[Array, Array]:
    """G (N, n) and g0 (N,) of q_model = G q + g0."""
    G = np.zeros((len(joints), len(names)))
    for row, joint in enumerate(joints):
        rule = rules[joint]
        if rule.leader is not None:
            G[row, names.index(rule.leader)] = rule.multiplier
    return G, np.array([rules[joint].offset for joint in joints])


def _limits(
    description: RobotDescription, names: tuple[str, ...], warnings: list[str]
) -> tuple[Array, Array, Array]:
    """Lower, upper and velocity limits, shape (n,) each; infinite where the URDF gives none."""
    n = len(names)
    lower, upper, velocity = np.empty(n), np.empty(n), np.full(n, np.inf)
    for i, name in enumerate(names):
        joint = description.moving_joints[name]
        lower[i], upper[i] = position_limits(joint)
        if lower[i] == upper[i]:
            raise UrdfError(
                f"{description.file}: joint '{name}'",
                f"lower and upper limit are both {lower[i]:g}",
                "a range to move in",
                "widen it, or lock the joint",
            )
        if joint.type != "continuous" and lower[i] == -np.inf:
            warnings.append(f"joint '{name}': no position limits, taken as unlimited")
        if joint.limit is not None and joint.limit.velocity:
            velocity[i] = joint.limit.velocity
        else:
            warnings.append(f"joint '{name}': no velocity limit, taken as unlimited")
    return lower, upper, velocity


def _effort_limit(
    description: RobotDescription, names: tuple[str, ...], given: EffortLimit | None
) -> Array:
    """u*, shape (n,): what the user gives, else the URDF's."""
    if given is None or isinstance(given, Mapping):
        by_name = dict(given or {})
        for name in by_name.keys() - set(names):
            raise UnknownNameError("effort_limit of joint", name, names)
        given = [
            by_name[name] if name in by_name else _urdf_effort(description, name) for name in names
        ]
    limits = vector("effort_limit", given, len(names))
    if not np.all(limits > 0):
        raise ParameterError("effort_limit", f"{limits.tolist()}", "positive numbers [N m or N]")
    return limits


def _urdf_effort(description: RobotDescription, joint: str) -> float:
    limit = description.moving_joints[joint].limit
    if limit is None or not limit.effort:
        raise UrdfError(
            f"{description.file}: joint '{joint}'",
            "effort limit missing or zero",
            "a positive effort",
            'write <limit effort="..."> or pass effort_limit',
        )
    return float(limit.effort)


def _dynamics(description: RobotDescription, joints: Iterable[str], name: str) -> Array:
    """Damping or friction of the model's joints; zero where the URDF gives none."""
    tags = [description.moving_joints[joint].dynamics for joint in joints]
    return np.array([float(getattr(tag, name, None) or 0.0) for tag in tags])


def _home(description: RobotDescription, entry: CatalogueEntry | None, joint: str) -> float:
    """The catalogue's value, else zero, else the middle of a range that excludes zero."""
    lower, upper = position_limits(description.moving_joint(joint))
    fallback = 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2
    return entry.home.get(joint, fallback) if entry is not None else fallback


def _refuse_singular(file: Path, arm: Arm) -> None:
    """M must be positive definite at the home posture and at random ones in the joint range."""
    rng = np.random.default_rng(0)
    postures = [arm.home, *rng.uniform(*joint_box(arm), (SINGULARITY_SAMPLES, arm.n))]
    for q in postures:
        M = arm.mass_matrix(q)
        scale = np.sqrt(np.maximum(np.diag(M), 0.0))
        if np.all(scale > 0):
            values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
            if values[0] > SINGULAR:
                continue
            joint = int(np.argmax(np.abs(vectors[:, 0])))
        else:
            joint = int(np.argmin(scale))
        raise UrdfError(
            f"{file}: joint '{arm.joint_names[joint]}'",
            f"the mass matrix is singular at q = {np.round(q, 3).tolist()}",
            "links with mass and inertia beyond every joint",
            "give the links it moves an <inertial>, or lock the joint",
        )
