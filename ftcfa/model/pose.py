"""Where a frame is, and how far one place is from another."""

from typing import NamedTuple

import numpy as np

from ftcfa.arrays import Array, Traceable


class Pose(NamedTuple):
    """Place of a frame in world axes, from the origin of the base."""

    rotation: Traceable
    """Rotation from the frame to the world, shape (3, 3)."""
    position: Traceable
    """Origin of the frame, shape (3,) [m]."""

    @property
    def matrix(self) -> Array:
        """The homogeneous matrix, shape (4, 4)."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.rotation, self.position
        return T


def distance(a: Pose, b: Pose) -> Traceable:
    """Distance of the origins, shape (1,) [m]."""
    return np.reshape(np.sqrt(np.sum((a.position - b.position) ** 2)), (1,))


def angle(a: Pose, b: Pose) -> Traceable:
    """Angle of the rotation from one to the other, shape (1,) [rad].

    |R_a - R_b| (Frobenius) = 2 sqrt(2) sin(angle/2), which is exact also for tiny angles.
    """
    chord = np.sqrt(np.sum((a.rotation - b.rotation) ** 2)) / np.sqrt(8.0)
    return np.reshape(2.0 * np.arcsin(np.minimum(chord, 1.0)), (1,))
