"""The constants of a tree of single-axis joints, as plain arrays."""

from dataclasses import dataclass

from ftcfa.arrays import Array


@dataclass(frozen=True, eq=False)
class KinematicTree:
    """N joints, parents before children.

    Attributes:
        parents: Index of each joint's parent, -1 for the base.
        rotations: From joint frame at zero to parent frame, shape (N, 3, 3).
        translations: Origin of the joint frame in the parent frame, shape (N, 3) [m].
        axes: Unit axis in the joint frame, shape (N, 3).
        prismatic: Whether a joint slides along its axis rather than turns about it.
        gravity: Gravity field in the base frame, shape (3,) [m/s^2].
    """

    parents: tuple[int, ...]
    rotations: Array
    translations: Array
    axes: Array
    prismatic: tuple[bool, ...]
    gravity: Array
