"""Noise inputs: how an excitation xi of the surroundings loads the joints, Lambda(q) xi."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.model.dynamics import Dynamics

AXES = ("x", "y", "z")


class NoiseInput(Protocol):
    """Lambda(q): from m channels of excitation to n joint forces."""

    @property
    def channels(self) -> int:
        """m, the number of excitation channels."""
        ...

    def matrix(self, arm: Dynamics, q: Array) -> Array:
        """Lambda(q), shape (n, m)."""
        ...


@dataclass(frozen=True)
class BaseAcceleration:
    """The base is shaken along world axes without turning; xi is its acceleration [m/s^2].

        Lambda(q) = -M_qb(q)[linear] = -sum_i m_i J_i(q)^T

    In terms of gravity: h(q; g - a) = h(q; g) - Lambda(q) a.

    Attributes:
        axes: The world axes that shake, in the order of the channels.
    """

    axes: Sequence[str] = "xyz"

    def __post_init__(self) -> None:
        axes = tuple(self.axes) if isinstance(self.axes, Sequence) else ()
        if not axes or any(axis not in AXES for axis in axes) or len(set(axes)) != len(axes):
            raise ParameterError("BaseAcceleration axes", repr(self.axes), 'such as "xyz" or "xz"')

    @property
    def channels(self) -> int:
        """One channel an axis."""
        return len(self.axes)

    def matrix(self, arm: Dynamics, q: Array) -> Array:
        """Lambda(q), shape (n, m) [kg m or kg]."""
        return -arm.base_coupling(q)[:, [AXES.index(axis) for axis in self.axes]]


@dataclass(frozen=True)
class PaperPendulumInput:
    """Lambda(q) of the paper's double pendulum as Section V prints it, in absolute angles.

        Lambda = [[-m1 l1 c1 + m2 l1 s1 sin(2D)/2,  -m1 l1 s1 - m2 l1 c1 sin(2D)/2],
                  [ m2 l2 s1 sin 2D,                -m2 l2 c1 sin 2D             ]],   D = q2 - q1

    It is not the physical matrix (`BaseAcceleration("xz")`); kept to reproduce the paper.

    Attributes:
        m: Masses [kg].
        l: Lengths [m].
    """

    m: tuple[float, float] = (0.6, 0.8)
    l: tuple[float, float] = (0.8, 1.2)  # noqa: E741 (the paper's letter)

    @property
    def channels(self) -> int:
        """Base acceleration along x and z."""
        return 2

    def matrix(self, arm: Dynamics, q: Array) -> Array:
        """Lambda(q), shape (2, 2) [kg m].

        Raises:
            ShapeError: If the arm has not two joints.
        """
        if arm.n != 2:
            raise ShapeError("PaperPendulumInput", f"an arm of {arm.n} joints", "2 joints")
        (m1, m2), (l1, l2) = self.m, self.l
        sine, cosine, double = np.sin(q[0]), np.cos(q[0]), np.sin(2.0 * (q[1] - q[0]))
        first = [
            -m1 * l1 * cosine + 0.5 * m2 * l1 * sine * double,
            -m1 * l1 * sine - 0.5 * m2 * l1 * cosine * double,
        ]
        second = [m2 * l2 * sine * double, -m2 * l2 * cosine * double]
        return np.stack([np.stack(first), np.stack(second)])
