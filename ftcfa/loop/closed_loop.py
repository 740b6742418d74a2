"""The closed loop: one sampled step of controller, saturation, noise and plant."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import (
    Check,
    about,
    check_fields,
    counting,
    having,
    known_name,
    positive,
    vector,
)
from ftcfa.control.protocol import Controller, Desired, Quantity, Signals, quantities
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.loop.plant import INTEGRATORS
from ftcfa.loop.references import Reference
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.uncertainty import Uncertainty
from ftcfa.parts import Parameters, number_fields
from ftcfa.vibration.excitation import Process
from ftcfa.vibration.excitations.white_noise import WhiteProcess
from ftcfa.vibration.vibration import Vibration

STILL = WhiteProcess(np.zeros((0, 0)), 1.0)
"""The process of a loop that nothing shakes."""
A_LAW = "a control law with init and step, such as FTCF(arm)"
A_REFERENCE = "a reference, such as Sinusoid(offset=arm.home)"
LOOP_QUANTITIES: Mapping[str, Quantity] = {
    "q": Quantity("rad", "position"),
    "q_d": Quantity("rad", "desired position"),
    "v": Quantity("rad/s", "velocity"),
    "u": Quantity("N m", "torque that acts, within the effort limits"),
    "u_command": Quantity("N m", "torque that the controller commands"),
}
"""Unit and meaning of the signals that every loop has; for prismatic joints m replaces rad."""
DIVERGED = 1e4
"""A path whose |q| or |v| leaves this bound has diverged [rad, rad/s, m or m/s]."""


class Motion(NamedTuple):
    """What an integration step advances: the robot and what shakes it."""

    q: Array
    """Position, shape (n,) [rad or m]."""
    v: Array
    """Velocity, shape (n,) [rad/s or m/s]."""
    vibration: Any = ()
    """State of the vibration."""


class Observer(Protocol):
    """Watches a path as it runs: its state at the end is a result, such as a largest error."""

    def init(self, n: int) -> Any:
        """State before the first sample, for n joints: arrays in tuples."""
        ...

    def step(self, state: Any, signals: Signals, period: float) -> Any:
        """New state after a sample; plain NumPy without branches on values.

        Args:
            state: State before it.
            signals: Of the sample, as `ClosedLoop.step` gives them.
            period: Sampling period [s].
        """
        ...


class LoopState(NamedTuple):
    """State of the closed loop at a sample."""

    motion: Motion
    """Of the plant."""
    controller: Any
    """Of the controller."""
    observer: Any = ()
    """Of the observer."""

    @property
    def q(self) -> Array:
        """Position, shape (n,) [rad or m]."""
        return self.motion.q

    @property
    def v(self) -> Array:
        """Velocity, shape (n,) [rad/s or m/s]."""
        return self.motion.v


def check_integrator(subject: str, name: Any) -> None:
    """Raise UnknownNameError unless a name is that of an integrator."""
    known_name(subject, name, INTEGRATORS)


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """An arm, its controller, its reference and what shakes it, sampled.

    The controller reads q and v every ``period`` and its torque, clipped at the arm's effort
    limit, is held; the plant takes ``substeps`` integration steps in between. A measurement that
    is not finite or beyond DIVERGED gives no torque, and the controller sees the desired motion
    in its place, so that it does not remember what was none.

    Attributes:
        arm: The true robot.
        controller: The control law; it holds the nominal robot.
        reference: The desired motion.
        vibration: What shakes the robot, or None.
        period: Sampling period of the controller [s].
        substeps: Integration steps a period.
        integrator: ``"euler-maruyama"`` or ``"semi-implicit"``.
        q0: Initial position, shape (n,) [rad or m]; the arm's home posture by default.
        v0: Initial velocity, shape (n,) [rad/s or m/s]; at rest by default.
        uncertainty: The robots around ``arm`` of which every path has its own, or None. The
            controller's nominal robot stays.
        observer: What watches every path, or None.
    """

    arm: Annotated[Dynamics, Check(having("mass_matrix", "an Arm, such as load_arm gives"))]
    controller: Annotated[Controller, Check(having("step", A_LAW))]
    reference: Annotated[Reference, Check(having("at", A_REFERENCE))]
    vibration: Annotated[
        Vibration | None, Check(having("excitation", "a Vibration(input, excitation), or None"))
    ] = None
    period: Annotated[float, Check(positive, "s")] = 1e-3
    substeps: Annotated[int, Check(counting)] = 1
    integrator: Annotated[str, Check(check_integrator)] = "euler-maruyama"
    q0: npt.ArrayLike | None = None
    v0: npt.ArrayLike | None = None
    uncertainty: Annotated[Uncertainty | None, Check(having("draw", "an Uncertainty, or None"))] = (
        None
    )
    observer: Observer | None = None

    varies: ClassVar[Parameters] = number_fields("q0", "v0")

    def __post_init__(self) -> None:
        check_fields(self)
        if self.uncertainty is not None:
            with about("uncertainty"):
                self.uncertainty.check(cast(Arm, self.arm))
        n, joints = self.arm.n, ", ".join(self.arm.joint_names)
        if self.reference.n != n:
            got = f"{self.reference.n} joints"
            raise ShapeError("ClosedLoop reference", got, f"{n}: {joints}", field="reference")
        q0 = self.arm.home if self.q0 is None else self.q0
        v0 = 0.0 if self.v0 is None else self.v0
        object.__setattr__(self, "q0", vector("ClosedLoop q0", q0, n, field="q0"))
        object.__setattr__(self, "v0", vector("ClosedLoop v0", v0, n, field="v0"))
        with about("vibration"):
            _ = self.process  # checks that the excitation goes with the step

    @cached_property
    def process(self) -> Process:
        """What shakes, over integration steps of this loop's length."""
        if self.vibration is None:
            return STILL
        return self.vibration.process(self.arm, self.step_length)

    def with_process(self, process: Process) -> "ClosedLoop":
        """This loop, shaken by another process than the one of its excitation."""
        loop = copy.copy(self)
        object.__setattr__(loop, "process", process)  # where cached_property keeps it
        return loop

    @property
    def step_length(self) -> float:
        """Length of an integration step [s]."""
        return self.period / self.substeps

    def init(self, desired: Desired, normals: Array | None = None) -> LoopState:
        """The state at the first sample.

        Args:
            desired: Desired motion there.
            normals: Standard normal deviates, shape (process.initial_normals,); zeros if None.
        """
        q, v = cast(Array, self.q0), cast(Array, self.v0)
        if normals is None:
            normals = np.zeros(self.process.initial_normals)
        shaken = () if self.vibration is None else self.vibration.init(self.process, normals)
        observer = () if self.observer is None else self.observer.init(self.arm.n)
        return LoopState(Motion(q, v, shaken), self.controller.init(q, v, desired), observer)

    def step(
        self, state: LoopState, desired: Desired, normals: Array, rows: Array | None = None
    ) -> tuple[Signals, LoopState]:
        """One sample: what was measured and computed there, and the state at the next.

        Args:
            state: State at this sample.
            desired: Desired motion at this sample.
            normals: Standard normal deviates of the period, shape (substeps, process.normals).
            rows: Rows of the process for its steps, shape (substeps, columns); its first ones
                if None.

        Returns:
            The signals of this sample and the state at the next one. ``u`` is the torque that
            acts, within the effort limits; ``u_command`` is what the controller asked for.
        """
        if rows is None:
            rows = np.resize(self.process.rows, (self.substeps, self.process.rows.shape[1]))
        signals, state = self.control(state, desired)
        motion = state.motion
        for k in range(self.substeps):
            motion = self.advance(motion, signals["u"], normals[k], rows[k])
        return signals, state._replace(motion=motion)

    def control(self, state: LoopState, desired: Desired) -> tuple[Signals, LoopState]:
        """The part of `step` at the sample: signals, and the state but for the motion."""
        q, v, usable = state.q, state.v, alive(state) > 0.0
        measured = np.where(usable, q, desired.q), np.where(usable, v, desired.v)
        given = self.controller.step(state.controller, *measured, desired, self.period)
        pair = isinstance(given, tuple) and len(given) == 2
        if not (pair and isinstance(given[0], dict) and "u" in given[0]):
            raise ParameterError(
                f"step of {type(self.controller).__name__}",
                f"a {type(given).__name__} without a dictionary that holds 'u'",
                '({"u": torque, ...}, state)',
            )
        signals, controller = given
        command = signals["u"]
        shape = command.shape if hasattr(command, "shape") else np.shape(command)
        if shape != q.shape:
            raise ShapeError("u of the controller", f"shape {shape}", f"{q.shape}")
        limit = self.arm.effort_limit
        u = np.where(usable, np.clip(command, -limit, limit), 0.0)
        motion = {"q": q, "q_d": desired.q, "v": v, "u": u, "u_command": command}
        signals = {**signals, **motion}
        observer = state.observer
        if self.observer is not None:
            observer = self.observer.step(observer, signals, self.period)
        return signals, LoopState(state.motion, controller, observer)

    def advance(self, motion: Motion, u: Array, normals: Array, row: Array) -> Motion:
        """One integration step of the plant under torque u.

        Args:
            motion: At the start of the step.
            u: Torque, shape (n,) [N m or N].
            normals: Standard normal deviates, shape (process.normals,).
            row: The step's row of the process, shape (columns,).
        """
        q, v, shaken = motion
        step = self.step_length
        impulse = np.zeros_like(q)
        if self.vibration is not None:
            impulse, shaken = self.vibration.impulse(
                self.process, self.arm, q, v, shaken, normals, row, step
            )
        q, v = INTEGRATORS[self.integrator](self.arm, q, v, u, impulse, step)
        return Motion(q, v, shaken)

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Unit and meaning of the signals of `step`; a law's own part need not list its signals."""
        return {**quantities(self.controller), **LOOP_QUANTITIES}

    def signal_shapes(self) -> dict[str, tuple[int, ...]]:
        """Name and shape of every signal that `step` gives, found by one sample of the law."""
        desired = Desired(*(row[0] for row in self.reference.at(np.zeros(1))))
        signals, _ = self.control(self.init(desired), desired)
        return {name: np.shape(value) for name, value in signals.items()}


def alive(state: LoopState) -> Array:
    """1.0 while |q| and |v| are finite and within DIVERGED, else 0.0."""
    largest = np.max(np.abs(np.concatenate([state.q, state.v])))
    return np.where(largest < DIVERGED, 1.0, 0.0)
