"""The vibration of a robot: an excitation of the surroundings and how it loads the joints."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, about, having, not_negative
from ftcfa.errors import ShapeError
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Parameters, Part, number_fields
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.inputs.noise_input import InputFunction, NoiseInput, StepIntegrals, noise_input


class VibrationState(NamedTuple):
    """State of a vibration."""

    process: Any
    """State of the excitation's process."""
    input: Any = ()
    """State of the noise input."""


@dataclass(frozen=True, eq=False)
class Vibration(Part):
    """A noise input Lambda(q) and an excitation xi of its channels.

    Attributes:
        input: Noise input: how the excitation loads the joints. A function (arm, q) -> Lambda(q),
            or an object with such a ``matrix`` method, is accepted too.
        excitation: Excitation of the input's channels.
        level: Factor of the excitation's amplitude; may differ from path to path.

    Raises:
        ParameterError: If a part has the wrong type, or the level is negative.
    """

    input: NoiseInput | Callable[[Any, Traceable], Traceable]
    excitation: Annotated[Excitation, Check(having("process", "an excitation"))]
    level: Annotated[float, Check(not_negative)] = 1.0

    varies: ClassVar[Parameters] = number_fields("level")

    def __post_init__(self) -> None:
        if callable(self.input) and not hasattr(self.input, "matrix"):
            object.__setattr__(self, "input", InputFunction(self.input))
        _ = self._input  # checks it
        super().__post_init__()

    @property
    def _input(self) -> NoiseInput:
        return noise_input(self.input)

    def process(self, arm: Dynamics, step: float) -> Process:
        """The excitation over integration steps of one length [s].

        Raises:
            ShapeError: If it has not as many channels as the noise input.
            ParameterError: If the step is too long for it, or the input cannot take it.
        """
        with about("input"):
            shape = np.shape(self._input.matrix(arm, arm.home))
        if len(shape) != 2 or shape[0] != arm.n:
            own = getattr(self.input, "function", type(self.input))
            name = getattr(own, "__name__", type(own).__name__)
            raise ShapeError(f"matrix of {name}", f"shape {shape}", f"({arm.n}, channels)")
        with about("excitation"):
            process = self.excitation.process(shape[1], step)
        self._input.check(process)
        return process

    def init(self, process: Process, normals: Traceable) -> VibrationState:
        """State before the first step, from ``process.initial_normals`` deviates."""
        return VibrationState(process.init(normals), self._input.init())

    def impulse(
        self,
        process: Process,
        arm: Dynamics,
        q: Traceable,
        v: Traceable,
        state: VibrationState,
        normals: Traceable,
        row: Traceable,
        step: float,
    ) -> tuple[Traceable, VibrationState]:
        """Joint impulse over one step, shape (n,) [N m s or N s], and the state at its end.

        The arguments are those of `NoiseInput.impulse`, with the result of `process`, standard
        normal deviates, shape (process.normals,), and the step's row of ``process.rows``.
        """
        integrals, process_state = self._step(process, state, normals, row)
        impulse, input_state = self._input.impulse(arm, q, v, state.input, integrals, step)
        return impulse, VibrationState(process_state, input_state)

    def base_motion(
        self,
        process: Process,
        arm: Dynamics,
        state: VibrationState,
        normals: Traceable,
        row: Traceable,
        step: float,
    ) -> Traceable:
        """Mean specific force and angular velocity of the base over one step, shape (6,).

        The arguments are those of `impulse`; see `NoiseInput.base_motion`.
        """
        integrals, _ = self._step(process, state, normals, row)
        return self._input.base_motion(arm, state.input, integrals, step)

    def _step(
        self, process: Process, state: VibrationState, normals: Traceable, row: Traceable
    ) -> tuple[StepIntegrals, Any]:
        """Integrals of the excitation for one step, and the state of its process at the end."""
        increment, process_state = process.advance(state.process, normals, row)
        unscaled = (increment, *process.integrals(state.process, row))
        return StepIntegrals(*(self.level * each for each in unscaled)), process_state
