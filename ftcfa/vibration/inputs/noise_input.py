"""Noise inputs: how an excitation xi of the surroundings loads the joints, Lambda(q) xi."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, known_name
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Parameters, Part, number_fields
from ftcfa.vibration.excitation import Process

AXES = ("x", "y", "z")
EXPECTED_AXES = 'such as "xyz" or "xz"'


def check_axes(subject: str, axes: Any) -> None:
    """Raise ParameterError unless axes are some of x, y, z, each once, or none."""
    given = tuple(axes) if isinstance(axes, Sequence) else (None,)
    if not (all(axis in AXES for axis in given) and len(set(given)) == len(given)):
        raise ParameterError(subject, repr(axes), EXPECTED_AXES)


def check_some_axis(subject: str, *groups: Sequence[str]) -> None:
    """Raise ParameterError unless one of the groups of axes has an axis."""
    if not any(groups):
        raise ParameterError(subject, ", ".join(map(repr, groups)), EXPECTED_AXES)


class StepIntegrals(NamedTuple):
    """Integrals of an excitation for one integration step, shape (m,) each."""

    increment: Traceable
    """Y, integral of xi over the step."""
    rate: Traceable
    """W, stationary integral of xi, at the start of the step; see `Process.integrals`."""
    angle: Traceable
    """U, stationary integral of W, at the start of the step."""


class NoiseInput(Part, ABC):
    """Matrix Lambda(q) from m channels of excitation to n joint forces.

    A noise input of your own needs `matrix` only. An input with a state, such as a base that
    turns, defines `init` and `impulse` too.
    """

    @abstractmethod
    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (n, m)."""

    def check(self, process: Process) -> None:
        """Raise ParameterError if this input cannot take an excitation; it takes any by default."""

    def init(self) -> Any:
        """State of the input before the first step: arrays in tuples."""
        return ()

    def impulse(
        self,
        arm: Dynamics,
        q: Traceable,
        v: Traceable,
        state: Any,
        integrals: StepIntegrals,
        step: float,
    ) -> tuple[Traceable, Any]:
        """Joint impulse Lambda(q) Y over one step, and the state of the input at its end.

        Args:
            arm: The true robot.
            q: Position at the start of the step (Ito), shape (n,) [rad or m].
            v: Velocity at the start, shape (n,) [rad/s or m/s].
            state: State of the input at the start.
            integrals: Integrals of the excitation.
            step: h [s].
        """
        return self.matrix(arm, q) @ integrals.increment, state

    def base_motion(
        self, arm: Dynamics, state: Any, integrals: StepIntegrals, step: float
    ) -> Traceable:
        """Mean motion of the base over one step, as an accelerometer at its origin feels it.

        Specific force R^T (a_b - g) [m/s^2], then angular velocity [rad/s], in axes that turn with
        the base, shape (6,). By default the base is level and at rest.

        Args:
            arm: The true robot, whose gravity counts.
            state: State of the input at the start of the step.
            integrals: Integrals of the excitation.
            step: h [s].
        """
        return specific_force(arm, np.zeros(3))


def specific_force(arm: Dynamics, acceleration: Traceable) -> Traceable:
    """Specific force of a level base, a - g, and no angular velocity, shape (6,)."""
    gravity = arm_attribute(arm, "gravity", "an accelerometer")
    return np.concatenate([acceleration - gravity, np.zeros(3)])


def noise_input(given: Any) -> NoiseInput:
    """A noise input as it is, or made of an object with ``matrix``; ParameterError if neither."""
    if isinstance(given, NoiseInput):
        return given
    if not hasattr(given, "matrix"):
        expected = "a noise input, or a function (arm, q) -> Lambda(q)"
        raise ParameterError("Vibration input", repr(given), expected, field="input")
    return InputFunction(given.matrix)


@dataclass(frozen=True, eq=False)
class InputFunction(NoiseInput):
    """A user's own function as Lambda(q).

    Attributes:
        function: (arm, q) -> Lambda(q), shape (n, m), plain NumPy without branches on values.
    """

    function: Callable[[Any, Traceable], Traceable]

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (n, m)."""
        return self.function(arm, q)


@dataclass(frozen=True, eq=False)
class BaseAcceleration(NoiseInput):
    """Base that is shaken without turning; xi is its acceleration [m/s^2].

        Lambda(q) = -M_qb(q)[linear] = -sum_i m_i J_i(q)^T

    In terms of gravity: h(q; g - a) = h(q; g) - Lambda(q) a. The axes are the world's, z upwards,
    however the base is mounted (`load_arm`'s ``mounting``).

    Attributes:
        axes: Axes of the acceleration, in the order of the channels.
    """

    axes: Annotated[str | Sequence[str], Check(check_axes)] = "xyz"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_some_axis("BaseAcceleration axes", self.axes)

    @property
    def axes_of_motion(self) -> tuple[Sequence[str], Sequence[str]]:
        """Axes of linear and of angular acceleration, in the order of the channels."""
        return self.axes, ""

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (n, m) [kg m or kg]."""
        return -arm.base_coupling(q)[:, columns(self.axes)]

    def base_motion(
        self, arm: Dynamics, state: Any, integrals: StepIntegrals, step: float
    ) -> Traceable:
        """See `NoiseInput.base_motion`."""
        return specific_force(arm, placed(self.axes, integrals.increment) / step)


@dataclass(frozen=True, eq=False)
class JointTorque(NoiseInput):
    """Noise of the motors: xi acts on the joints directly [N m or N].

        Lambda(q) = columns of the identity

    Attributes:
        joints: Names of the joints, one for each channel; all joints of the arm by default. A
            single name needs no brackets.
    """

    joints: Sequence[str] | None = None

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (n, m) [1].

        Raises:
            UnknownNameError: If the arm has no such joint; it lists the joints of the arm.
        """
        names = arm.joint_names if self.joints is None else self.joints
        names = (names,) if isinstance(names, str) else names
        for name in names:
            known_name("JointTorque joint", name, arm.joint_names, field="joints")
        return np.eye(arm.n)[:, [arm.joint_names.index(name) for name in names]]


@dataclass(frozen=True, eq=False)
class FrameWrench(NoiseInput):
    """Force [N] and moment [N m] on a link, such as wind on the forearm or a chattering tool.

        Lambda(q) = J(q)^T,   J: the frame's Jacobian in world axes, shape (6, n)

    Attributes:
        frame: Name of a link or joint of the URDF (`Arm.frame_names`); the force acts at its
            origin.
        force: Axes of the force, in the order of the channels.
        moment: Axes of the moment, channels after those of the force.
    """

    frame: str
    force: Annotated[str | Sequence[str], Check(check_axes)] = "xyz"
    moment: Annotated[str | Sequence[str], Check(check_axes)] = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_some_axis("FrameWrench force and moment", self.force, self.moment)

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (n, m) [m, or 1].

        Raises:
            UnknownNameError: If the arm has no such frame; it lists the frames of the arm.
        """
        jacobian = arm_attribute(arm, "frame_jacobian", "FrameWrench")
        return jacobian(self.frame, q).T[:, columns(self.force, self.moment)]


@dataclass(frozen=True, eq=False)
class PaperPendulumInput(NoiseInput):
    """Lambda(q) of the paper's double pendulum as printed in Section V, in absolute angles.

        Lambda = [[-m1 l1 c1 + m2 l1 s1 sin(2D)/2,  -m1 l1 s1 - m2 l1 c1 sin(2D)/2],
                  [ m2 l2 s1 sin 2D,                -m2 l2 c1 sin 2D             ]],   D = q2 - q1

    It differs from the physical matrix, `BaseAcceleration("xz")`, and serves to reproduce the
    paper.

    Attributes:
        m: Masses [kg].
        l: Lengths [m].
    """

    m: tuple[float, float] = (0.6, 0.8)
    l: tuple[float, float] = (0.8, 1.2)  # noqa: E741 (the paper's letter)

    varies: ClassVar[Parameters] = number_fields("m", "l")

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q), shape (2, 2) [kg m].

        Raises:
            ShapeError: If the arm has not two joints.
        """
        if arm.n != 2:
            raise ShapeError("PaperPendulumInput", f"an arm of {arm.n} joints", "2 joints")
        (m1, m2), (l1, l2) = self.m, self.l
        sine, cosine, double = np.sin(q[0]), np.cos(q[0]), np.sin(2.0 * (q[1] - q[0]))
        x = [-m1 * l1 * cosine + 0.5 * m2 * l1 * sine * double, m2 * l2 * sine * double]
        z = [-m1 * l1 * sine - 0.5 * m2 * l1 * cosine * double, -m2 * l2 * cosine * double]
        return np.stack([np.stack(x), np.stack(z)], axis=1)


def arm_attribute(arm: Dynamics, name: str, subject: str) -> Any:
    """A method or quantity that not every arm has; ParameterError if this arm lacks it."""
    if not hasattr(arm, name):
        got = f"a {type(arm).__name__} without {name}"
        raise ParameterError(f"arm of {subject}", got, "an Arm, such as load_arm gives")
    return getattr(arm, name)


def placed(axes: Sequence[str], values: Traceable) -> Traceable:
    """Values of some axes as a vector of all three, shape (3,)."""
    return np.eye(3)[:, columns(axes)] @ values


def columns(linear: Sequence[str], angular: Sequence[str] = "") -> list[int]:
    """Indices of linear and angular axes in a six-vector (linear, then angular)."""
    return [AXES.index(axis) for axis in linear] + [3 + AXES.index(axis) for axis in angular]
