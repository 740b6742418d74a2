"""The closed loop: one sampled step of controller, saturation, noise and plant."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Annotated, Any, ClassVar, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable, is_off
from ftcfa.checks import Check, about, counting_to, having, known_name, number, positive, vector
from ftcfa.control.protocol import A_LAW, Controller, Desired, Quantity, Signals, quantities
from ftcfa.hardware.hardware import HARDWARE_QUANTITIES, Hardware
from ftcfa.hardware.ideal import IDEAL
from ftcfa.hardware.profiles import as_hardware
from ftcfa.loop.command import LOOP_QUANTITIES, commanded
from ftcfa.loop.plant import INTEGRATORS
from ftcfa.loop.references import Posture, Reference, of_joints
from ftcfa.loop.spread import check_spread
from ftcfa.loop.state import HALF, LoopState, Motion, Observer, bounded
from ftcfa.loop.tool import tool_signals
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.uncertainty import Uncertainty
from ftcfa.parts import Parameters, Part, any_finite, number_field, number_fields
from ftcfa.vibration.excitation import Process
from ftcfa.vibration.excitations.white_noise import WhiteProcess
from ftcfa.vibration.inputs.noise_input import specific_force
from ftcfa.vibration.vibration import Vibration

STILL = WhiteProcess(np.zeros((0, 0)), 1.0)
"""The process of a loop without vibration."""
A_REFERENCE = "a reference, such as Sinusoid(offset=arm.home)"
MOST_SUBSTEPS = 1_000_000
"""Largest number of integration steps a period."""


@dataclass(frozen=True, eq=False)
class ClosedLoop(Part):
    """An arm, its controller, its reference and its vibration, sampled.

    The controller reads q and v every ``period``. Its torque, clipped at the arm's effort limit,
    is held while the plant takes ``substeps`` integration steps. Where a measurement is not finite
    or beyond DIVERGED, the torque is zero and the controller sees the desired motion instead of
    the measurement, which keeps its own state finite. Where a controller commands a torque that is
    not finite, the torque is zero, and its `init` gives it a new state at the next good
    measurement.

    Attributes:
        arm: The true robot.
        controller: The control law; it holds the nominal robot.
        reference: The desired motion; the columns of a `Table` with names are put into the order
            of the arm's joints.
        vibration: The vibration of the robot, or None.
        period: Sampling period of the controller [s].
        substeps: Integration steps a period.
        integrator: ``"euler-maruyama"`` or ``"semi-implicit"``.
        q0: Initial position, shape (n,) [rad or m]; the arm's home posture by default.
        v0: Initial velocity, shape (n,) [rad/s or m/s]; at rest by default.
        uncertainty: Distribution from which every path draws its own robot, or None. The nominal
            robot of the controller stays the same.
        observer: Computes results of every path as it runs, or None.
        hardware: What the robot measures and what its motors can do, or the name of a profile, such
            as ``"fr3"``; without it the controller reads the true motion and its torque acts at
            once.
        reference_scale: Scale of the desired motion about its first posture: with 0 it stands still
            there.
        spread: Smallest and largest value of numbers that differ from path to path, by dotted name,
            such as ``{"reference_scale": (0.5, 1.5), "hardware.sensors.latency": (0.0, 0.003)}``;
            see `ftcfa.loop.spread`.
    """

    arm: Annotated[Dynamics, Check(having("mass_matrix", "an Arm, such as load_arm gives"))]
    controller: Annotated[Controller, Check(having("step", A_LAW))]
    reference: Annotated[Reference, Check(having("at", A_REFERENCE))]
    vibration: Annotated[
        Vibration | None, Check(having("excitation", "a Vibration(input, excitation), or None"))
    ] = None
    period: Annotated[float, Check(positive, "s")] = 1e-3
    substeps: Annotated[int, Check(counting_to(MOST_SUBSTEPS))] = 1
    integrator: Annotated[str, Check(partial(known_name, known=INTEGRATORS))] = "euler-maruyama"
    q0: Posture | None = None
    v0: npt.ArrayLike | None = None
    uncertainty: Annotated[Uncertainty | None, Check(having("draw", "an Uncertainty, or None"))] = (
        None
    )
    observer: Observer | None = None
    hardware: Annotated[Hardware | str | None, Check(as_hardware)] = None
    reference_scale: Annotated[float, Check(number)] = 1.0
    spread: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    varies: ClassVar[Parameters] = {
        **number_fields("q0", "v0"),
        "reference_scale": number_field("reference_scale", any_finite),
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty is not None:
            with about("uncertainty"):
                self.uncertainty.check(cast(Arm, self.arm))
        n = self.arm.n
        with about("reference"):
            reference = of_joints(self.reference, tuple(self.arm.joint_names))
        object.__setattr__(self, "reference", reference)
        q0 = self.arm.home if self.q0 is None else self.q0
        v0 = 0.0 if self.v0 is None else self.v0
        object.__setattr__(self, "q0", vector("ClosedLoop q0", q0, n, field="q0"))
        object.__setattr__(self, "v0", vector("ClosedLoop v0", v0, n, field="v0"))
        with about("vibration"):
            _ = self.process  # checks that the excitation goes with the step
        if self.hardware is not None:
            with about("hardware"):
                hardware = as_hardware("ClosedLoop hardware", self.hardware)
                hardware.check(n, self.period, self.step_length)
            object.__setattr__(self, "hardware", hardware)
        with about("spread"):
            check_spread(self, self.spread)

    def desired(self, t: Array) -> Desired:
        """The desired motion at times of shape (T,) [s], each of its parts of shape (T, n)."""
        return self._scaled(self.reference.at(t))

    @property
    def first_desired(self) -> Desired:
        """Motion of the reference at the first sample, each part of shape (n,)."""
        return Desired(*(row[0] for row in self.reference.at(np.zeros(1))))

    def _scaled(self, desired: Desired) -> Desired:
        """The desired motion of a path, of that of the reference."""
        scale = self.reference_scale
        if is_off(scale, 1.0):
            return desired
        (q, v, a), first = desired, self.first_desired.q
        return Desired(first + scale * (q - first), scale * v, scale * a)

    @property
    def interface(self) -> Any:
        """The hardware, or its ideal."""
        return IDEAL if self.hardware is None else self.hardware

    @property
    def streams(self) -> Mapping[int, int]:
        """Random streams of a sample, and the number of deviates of each."""
        return self.interface.streams(self.arm.n)

    @cached_property
    def process(self) -> Process:
        """The excitation over integration steps of this loop's length."""
        if self.vibration is None:
            return STILL
        return self.vibration.process(self.arm, self.step_length)

    def with_process(self, process: Process) -> "ClosedLoop":
        """This loop with another process than that of its excitation."""
        loop = copy.copy(self)
        object.__setattr__(loop, "process", process)  # where cached_property keeps it
        return loop

    @property
    def step_length(self) -> float:
        """Length of an integration step [s]."""
        return self.period / self.substeps

    def init(self, desired: Desired, normals: Traceable | None = None) -> LoopState:
        """The state at the first sample.

        Args:
            desired: Motion of the reference at the first sample.
            normals: Standard normal deviates, shape (process.initial_normals,); zeros if None.
        """
        desired = self._scaled(desired)
        q, v = cast(Array, self.q0), cast(Array, self.v0)
        if normals is None:
            normals = np.zeros(self.process.initial_normals)
        vibration = () if self.vibration is None else self.vibration.init(self.process, normals)
        observer = () if self.observer is None else self.observer.init(self.arm.n)
        memory, motion = self.interface.init(self.arm, q, v, self.step_length)
        controller = self.controller.init(self.interface.measured(memory, q, v), desired)
        state = Motion(q, v, vibration, motion)
        return LoopState(state, controller, np.zeros(1), memory, observer)

    def step(
        self,
        state: LoopState,
        desired: Desired,
        normals: Array,
        rows: Array | None = None,
        deviates: Array | None = None,
    ) -> tuple[Signals, LoopState]:
        """Signals of one sample, and the state at the next.

        Args:
            state: State at this sample.
            desired: Motion of the reference at this sample.
            normals: Standard normal deviates of the period, shape (substeps, process.normals).
            rows: Rows of the process for the steps of the period, shape (substeps, columns); the
                first ones if None.
            deviates: Standard normal deviates of the sample, one after the other as `streams` lists
                them; zeros if None.

        Returns:
            The signals, see `LOOP_QUANTITIES` for those of every loop, and the state.
        """
        if rows is None:
            rows = np.resize(self.process.rows, (self.substeps, self.process.rows.shape[1]))
        signals, drive, state = self.control(self.restarted(state, desired), desired, deviates)
        motion = state.motion
        for k in range(self.substeps):
            motion = self.advance(motion, drive, normals[k], rows[k])
        return signals, state._replace(motion=motion)

    def control(
        self, state: LoopState, desired: Desired, deviates: Traceable | None = None
    ) -> tuple[Signals, Any, LoopState]:
        """Signals of a sample, what drives the motors, and the state after the controller.

        The arguments are those of `step`.
        """
        if deviates is None:
            deviates = np.zeros(sum(self.streams.values()))
        desired = self._scaled(desired)
        usable, steps = bounded(state) > 0.0, (self.period, self.step_length)
        q, v, hardware = state.q, state.v, self.interface
        memory = hardware.read(state.hardware, state.motion.hardware, q, v, deviates, *steps)
        shown = hardware.measured(memory, q, v)
        q_m, v_m = np.where(usable, shown.q, desired.q), np.where(usable, shown.v, desired.v)
        measured = shown._replace(q=q_m, v=v_m)
        signals, controller = commanded(
            self.controller, state.controller, measured, desired, self.period
        )
        command, limit = signals["u"], hardware.limit(self.arm.effort_limit)
        finite = np.max(np.abs(command)) < np.inf
        wanted = np.where(np.logical_and(usable, finite), np.clip(command, -limit, limit), 0.0)
        drive, memory = hardware.drive(memory, wanted, deviates, self.period)
        u, _ = hardware.acting(state.motion.hardware, drive, limit, self.step_length)
        own = {"q": q, "q_d": desired.q, "v": v, "u": u, "u_command": command, "u_wanted": wanted}
        signals = {**signals, **own, **tool_signals(self.arm, q, desired.q)}
        signals |= hardware.signals(memory, wanted, drive)
        observer = state.observer
        if self.observer is not None:
            observer = self.observer.step(observer, signals, self.period)
        restart = np.where(finite, state.restart, np.ones(1))
        return signals, drive, LoopState(state.motion, controller, restart, memory, observer)

    def restarted(self, state: LoopState, desired: Desired) -> LoopState:
        """The state at a sample, where a law that waits for a good measurement starts anew.

        It waits since a sample at which it commanded a torque that is not finite.
        """
        due = np.max(np.where(bounded(state) > 0.0, state.restart, 0.0)) > HALF
        if not due:
            return state
        return state._replace(controller=self.renewed(state, desired), restart=np.zeros(1))

    def renewed(self, state: LoopState, desired: Desired) -> Any:
        """The state of a controller that starts anew with what the sensors showed last."""
        measured = self.interface.measured(state.hardware, state.q, state.v)
        return self.controller.init(measured, self._scaled(desired))

    def advance(self, motion: Motion, drive: Any, normals: Traceable, row: Traceable) -> Motion:
        """One integration step of the plant.

        Args:
            motion: State at its start.
            drive: What drives the motors, as `control` gives it.
            normals: Standard normal deviates of the step, shape (process.normals,).
            row: Row of the process for the step, shape (columns,).
        """
        q, v, vibration, hardware = motion
        step, interface = self.step_length, self.interface
        u, motors = interface.acting(hardware, drive, interface.limit(self.arm.effort_limit), step)
        impulse = np.zeros_like(q)
        base = self._base_motion(vibration, normals, row) if interface.senses_base else None
        if self.vibration is not None:
            parts = self.process, self.arm, q, v, vibration
            impulse, vibration = self.vibration.impulse(*parts, normals, row, step)
        hardware = interface.advanced(hardware, q, v, motors, base, step)
        q, v = INTEGRATORS[self.integrator](self.arm, q, v, u, impulse, step)
        return Motion(q, v, vibration, hardware)

    def _base_motion(self, state: Any, normals: Traceable, row: Traceable) -> Traceable:
        """Mean specific force and angular velocity of the base in a step, shape (6,)."""
        if self.vibration is None:
            return specific_force(self.arm, np.zeros(3))
        parts = self.process, self.arm, state, normals, row, self.step_length
        return self.vibration.base_motion(*parts)

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Unit and meaning of the signals of `step`, except those that a law leaves out."""
        own = {} if self.hardware is None else HARDWARE_QUANTITIES
        return {**quantities(self.controller), **LOOP_QUANTITIES, **own}

    def signal_shapes(self) -> dict[str, tuple[int, ...]]:
        """Name and shape of every signal of `step`, from one sample of the law."""
        signals, *_ = self.control(self.init(self.first_desired), self.first_desired)
        return {name: np.shape(value) for name, value in signals.items()}
