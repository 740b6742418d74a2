"""The hardware of a loop that has none: it answers as `Hardware` does, and changes nothing."""

from typing import Any

from ftcfa.arrays import Array, Traceable
from ftcfa.control.protocol import Measured
from ftcfa.model.dynamics import Dynamics


class Ideal:
    """No hardware: the law reads the true motion, and its torque within the limits acts."""

    senses_base = False
    note, name = "", "ideal"

    def limit(self, arm_limit: Traceable) -> Traceable:
        """The arm's own limits."""
        return arm_limit

    def check_duration(self, duration: float) -> None:
        """No delay is too long."""

    def streams(self, n: int) -> dict[int, int]:
        """No deviates."""
        return {}

    def init(self, arm: Dynamics, q: Array, v: Array, step: float) -> tuple[Any, Any]:
        """No state."""
        return (), ()

    def read(self, memory: Any, *_: Any) -> Any:
        """No memory."""
        return memory

    def measured(self, memory: Any, q: Traceable, v: Traceable) -> Measured:
        """The true motion."""
        return Measured(q, v)

    def drive(self, memory: Any, wanted: Traceable, *_: Any) -> tuple[Traceable, Any]:
        """The command itself."""
        return wanted, memory

    def signals(self, memory: Any, *_: Any) -> dict[str, Traceable]:
        """No signals of its own."""
        return {}

    def acting(self, motion: Any, drive: Traceable, *_: Any) -> tuple[Traceable, Any]:
        """The command itself."""
        return drive, ()

    def advanced(self, motion: Any, *_: Any) -> Any:
        """No state."""
        return motion


IDEAL = Ideal()
"""The hardware of a loop that has none."""
