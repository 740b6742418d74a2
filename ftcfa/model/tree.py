"""Constants of a tree of single-axis joints, as plain arrays."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ftcfa.arrays import Array


class BodyFrame(NamedTuple):
    """A frame fixed to a body of the tree."""

    joint: int
    """Index of the joint that carries the frame, -1 for the base."""
    rotation: Array
    """Rotation from the frame to the joint frame, shape (3, 3)."""
    translation: Array
    """Origin of the frame in the joint frame, shape (3,) [m]."""


@dataclass(frozen=True, eq=False)
class KinematicTree:
    """Tree of N joints, parents before children.

    Attributes:
        parents: Index of each joint's parent, -1 for the base.
        rotations: Rotation from the joint frame at zero to the parent frame, shape (N, 3, 3).
        translations: Origin of the joint frame in the parent frame, shape (N, 3) [m].
        axes: Unit axis in the joint frame, shape (N, 3).
        prismatic: Whether each joint slides along its axis instead of turning about it.
        gravity: Gravity field, shape (3,) [m/s^2].
        frames: Links and joints of the URDF, by name.
    """

    parents: tuple[int, ...]
    rotations: Array
    translations: Array
    axes: Array
    prismatic: tuple[bool, ...]
    gravity: Array
    frames: Mapping[str, BodyFrame]
