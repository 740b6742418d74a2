"""What shakes the robot: an excitation of the surroundings and how it loads the joints."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.noise_input import NoiseInput


@dataclass(frozen=True, eq=False)
class Vibration:
    """A noise input Lambda(q) and an excitation xi of its channels.

    Attributes:
        input: How the excitation loads the joints.
        excitation: What shakes.
        level: Factor on the excitation's amplitude; may differ from path to path.

    Raises:
        ParameterError: If a part is not what it should be, or the two do not go together.
        ShapeError: If they have different numbers of channels.
    """

    input: NoiseInput
    excitation: Excitation
    level: float = 1.0

    def __post_init__(self) -> None:
        if not hasattr(self.input, "matrix"):
            raise ParameterError("Vibration input", repr(self.input), "a noise input")
        if not hasattr(self.excitation, "process"):
            raise ParameterError("Vibration excitation", repr(self.excitation), "an excitation")
        if not (np.isfinite(self.level) and self.level >= 0):
            raise ParameterError("Vibration level", repr(self.level), "a number >= 0")

    def process(self, step: float) -> Process:
        """The excitation over integration steps of one length [s]."""
        return self.excitation.process(self.input.channels, step)

    def impulse(
        self, process: Process, arm: Dynamics, q: Array, state: Any, normals: Array, row: Array
    ) -> tuple[Array, Any]:
        """Joint impulse over one step, Lambda(q) times the integral of xi, and the new state.

        Args:
            process: Of `process`.
            arm: The true robot.
            q: Position at the start of the step (Ito), shape (n,) [rad or m].
            state: State of the process there.
            normals: Standard normal deviates, shape (process.normals,).
            row: The step's row of ``process.rows``.

        Returns:
            The impulse, shape (n,) [N m s or N s], and the state at the end of the step.
        """
        integral, state = process.advance(state, normals, row)
        return self.input.matrix(arm, q) @ (self.level * integral), state
