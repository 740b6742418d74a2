"""The closed loop: one sampled step of controller, saturation, noise and plant."""

from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, counting, positive, vector
from ftcfa.control.protocol import Controller, Desired, Signals
from ftcfa.errors import ShapeError, UnknownNameError
from ftcfa.loop.plant import INTEGRATORS
from ftcfa.loop.references import Reference
from ftcfa.model.dynamics import Dynamics
from ftcfa.vibration.excitation import Vibration

DIVERGED = 1e4
"""A path whose |q| or |v| leaves this bound has diverged [rad, rad/s, m or m/s]."""


class LoopState(NamedTuple):
    """State of the closed loop at a sample."""

    q: Array
    """Position, shape (n,) [rad or m]."""
    v: Array
    """Velocity, shape (n,) [rad/s or m/s]."""
    controller: Any
    """State of the controller."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """An arm, its controller, its reference and what shakes it, sampled.

    The controller reads q and v every ``period`` and its torque, clipped at the arm's effort
    limit, is held; the plant takes ``substeps`` integration steps in between.

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
    """

    arm: Dynamics
    controller: Controller
    reference: Reference
    vibration: Vibration | None = None
    period: float = 1e-3
    substeps: int = 1
    integrator: str = "euler-maruyama"
    q0: npt.ArrayLike | None = None
    v0: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        n = self.arm.n
        positive("period", self.period, "[s]")
        counting("substeps", self.substeps)
        if self.integrator not in INTEGRATORS:
            raise UnknownNameError("integrator", self.integrator, list(INTEGRATORS))
        if self.reference.n != n:
            raise ShapeError(
                "reference", f"{self.reference.n} joints", f"{n}: {', '.join(self.arm.joint_names)}"
            )
        q0 = self.arm.home if self.q0 is None else self.q0
        object.__setattr__(self, "q0", vector("q0", q0, n))
        object.__setattr__(self, "v0", vector("v0", 0.0 if self.v0 is None else self.v0, n))

    @property
    def channels(self) -> int:
        """Standard normal deviates an integration step."""
        return 0 if self.vibration is None else self.vibration.channels

    def init(self, desired: Desired) -> LoopState:
        """The state at the first sample, given the desired motion there."""
        q, v = cast(Array, self.q0), cast(Array, self.v0)
        return LoopState(q, v, self.controller.init(q, v, desired))

    def step(self, state: LoopState, desired: Desired, normals: Array) -> tuple[Signals, LoopState]:
        """One sample: what was measured and computed there, and the state at the next.

        Args:
            state: State at this sample.
            desired: Desired motion at this sample.
            normals: Standard normal deviates of the period, shape (substeps, channels).

        Returns:
            The signals of this sample and the state at the next one. ``u`` is the torque that
            acts, within the effort limits; ``u_command`` is what the controller asked for.
        """
        signals, controller = self.control(state, desired)
        q, v = state.q, state.v
        for k in range(self.substeps):
            q, v = self.advance(q, v, signals["u"], normals[k])
        return signals, LoopState(q, v, controller)

    def control(self, state: LoopState, desired: Desired) -> tuple[Signals, Any]:
        """The controller's part of `step`: signals, and the controller's new state."""
        q, v = state.q, state.v
        signals, controller = self.controller.step(state.controller, q, v, desired, self.period)
        command = signals["u"]
        shape = command.shape if hasattr(command, "shape") else np.shape(command)
        if shape != q.shape:
            raise ShapeError("u of the controller", f"shape {shape}", f"{q.shape}")
        limit = self.arm.effort_limit
        u = np.clip(command, -limit, limit)
        measured = {"q": q, "q_d": desired.q, "v": v, "u": u, "u_command": command}
        return {**signals, **measured}, controller

    def advance(self, q: Array, v: Array, u: Array, normals: Array) -> tuple[Array, Array]:
        """One integration step of the plant under torque u, shapes (n,), normals (channels,)."""
        step = self.period / self.substeps
        impulse = self._impulse(q, step, normals)
        return INTEGRATORS[self.integrator](self.arm, q, v, u, impulse, step)

    def signal_shapes(self) -> dict[str, tuple[int, ...]]:
        """Name and shape of every signal that `step` gives, found by one sample of the law."""
        desired = Desired(*(row[0] for row in self.reference.at(np.zeros(1))))
        signals, _ = self.control(self.init(desired), desired)
        return {name: np.shape(value) for name, value in signals.items()}

    def _impulse(self, q: Array, step: float, normals: Array) -> Array:
        if self.vibration is None:
            return np.zeros_like(q)
        return self.vibration.impulse(self.arm, q, step, normals)


def alive(state: LoopState) -> Array:
    """1.0 while |q| and |v| are finite and within DIVERGED, else 0.0."""
    largest = np.max(np.abs(np.concatenate([state.q, state.v])))
    return np.where(largest < DIVERGED, 1.0, 0.0)
