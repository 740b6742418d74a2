"""Excitations xi of the surroundings, and the sum of several; the loop takes their integrals."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check
from ftcfa.errors import ParameterError
from ftcfa.parts import Part

EACH = "give one for each channel of the noise input, or choose fewer of its axes"
"""Remedy where an excitation has not as many channels as the noise input."""


class Process(ABC):
    """An excitation over integration steps of one length: what the loop runs.

    Y_k, x_{k+1} = advance(x_k, n_k, row_k),      Y_k: integral of xi over step k
    """

    @property
    @abstractmethod
    def normals(self) -> int:
        """Number of standard normal deviates in each step."""

    @property
    def initial_normals(self) -> int:
        """Number of standard normal deviates that make the initial state."""
        return 0

    @property
    def rows(self) -> Array:
        """Numbers that all paths share, a row for each step in turn, shape (R, columns)."""
        return np.zeros((1, 0))

    @property
    def random_start(self) -> bool:
        """Whether each path begins at a row of its own."""
        return False

    def init(self, normals: Traceable) -> Any:  # noqa: ARG002
        """State before the first step: arrays in tuples, from ``initial_normals`` deviates."""
        return ()

    @abstractmethod
    def advance(self, state: Any, normals: Traceable, row: Traceable) -> tuple[Traceable, Any]:
        """Integral of xi over one step, shape (m,), and the state at its end.

        Args:
            state: State at its start.
            normals: Standard normal deviates, shape (normals,).
            row: The step's row, shape (columns,).
        """

    def why_no_integrals(self, channel: int) -> str:  # noqa: ARG002
        """Reason why a channel lacks `integrals` and cannot turn a base; "" if it has both."""
        return "an excitation that gives no integrals"

    def integrals(self, state: Any, row: Traceable) -> tuple[Traceable, Traceable]:  # noqa: ARG002
        """Stationary integrals W of xi and U of W at the start of a step, shape (m,) each.

            W_{k+1} = W_k + Y_k,   U_{k+1} = U_k + integral of W over step k

        Both have mean zero. They mean nothing in channels for which `why_no_integrals` gives a
        reason; a process without any other channel need not define them.

        Args:
            state: State at the start of the step.
            row: The step's row.
        """
        return np.zeros(1), np.zeros(1)


class Excitation(Part, ABC):
    """Description of an excitation, from which a `Process` is made for a step length."""

    @abstractmethod
    def process(self, channels: int, step: float) -> Process:
        """The excitation of m channels over steps of one length [s].

        Raises:
            ShapeError: If it has another number of channels.
            ParameterError: If the step is too long for it.
        """

    def __add__(self, other: "Excitation") -> "Superposition":
        """Sum of two independent excitations of the same channels.

        Raises:
            ParameterError: If the other is no excitation.
        """
        return Superposition((self, other))


def checked_parts(subject: str, parts: Any) -> tuple[Excitation, ...]:
    """The parts of an excitation as a tuple.

    Raises:
        ParameterError: If there is none, or one is no excitation.
    """
    given = tuple(parts) if isinstance(parts, Iterable) else (parts,)
    for part in given:
        if not hasattr(part, "process"):
            raise ParameterError(subject, repr(part), "an excitation")
    if not given:
        raise ParameterError(subject, "none", "one excitation or more")
    return given


@dataclass(frozen=True, eq=False)
class Superposition(Excitation):
    """Sum of independent excitations of the same channels, such as sine on random: ``a + b``.

    Attributes:
        parts: One excitation or more; the parts of a sum among them are taken one by one. The same
            excitation twice is two independent ones.

    Raises:
        ParameterError: If a part is no excitation.
    """

    parts: Annotated[Sequence[Excitation], Check(checked_parts)]

    def __post_init__(self) -> None:
        super().__post_init__()
        parts = checked_parts("Superposition parts", self.parts)
        flat = [p.parts if isinstance(p, Superposition) else (p,) for p in parts]
        object.__setattr__(self, "parts", tuple(part for some in flat for part in some))

    def process(self, channels: int, step: float) -> "SummedProcess":
        """See `Excitation.process`; at most one part may have rows."""
        return SummedProcess(tuple(part.process(channels, step) for part in self.parts))


@dataclass(frozen=True, eq=False)
class JointProcess(Process):
    """Independent processes side by side: states in a tuple, deviates one after the other.

    Attributes:
        parts: The processes.

    Raises:
        ParameterError: If more than one of them has rows.
    """

    parts: tuple[Process, ...]

    def __post_init__(self) -> None:
        tables = sum(part.rows.shape[1] > 0 for part in self.parts)
        if tables > 1:
            raise ParameterError(
                "excitation",
                f"{tables} records among its parts",
                "at most one",
                "add their values, or make them axes of one Record",
            )

    @property
    def normals(self) -> int:
        """Number of deviates of all parts."""
        return sum(part.normals for part in self.parts)

    @cached_property
    def initial_normals(self) -> int:
        """Number of deviates of all initial states."""
        return sum(part.initial_normals for part in self.parts)

    @cached_property
    def rows(self) -> Array:
        """Rows of the part that has some."""
        return max((part.rows for part in self.parts), key=lambda rows: rows.shape[1])

    @cached_property
    def random_start(self) -> bool:
        """Whether each path begins at a row of its own."""
        return any(part.random_start for part in self.parts)

    def init(self, normals: Traceable) -> tuple[Any, ...]:
        """States of all parts."""
        shares = _shares(normals, [part.initial_normals for part in self.parts])
        return tuple(part.init(own) for part, own in zip(self.parts, shares, strict=True))

    def advance_parts(
        self, state: tuple[Any, ...], normals: Traceable, row: Traceable
    ) -> tuple[list[Traceable], tuple[Any, ...]]:
        """Integrals of all parts over one step, and their states at its end."""
        shares = _shares(normals, [part.normals for part in self.parts])
        steps = [
            part.advance(own, share, row)
            for part, own, share in zip(self.parts, state, shares, strict=True)
        ]
        return [Y for Y, _ in steps], tuple(after for _, after in steps)

    def integrals_of_parts(
        self, state: tuple[Any, ...], row: Traceable
    ) -> tuple[list[Traceable], list[Traceable]]:
        """Stationary integrals W and U of all parts."""
        both = [part.integrals(own, row) for part, own in zip(self.parts, state, strict=True)]
        return [W for W, _ in both], [U for _, U in both]


class SummedProcess(JointProcess):
    """Sum of processes of the same channels."""

    def advance(
        self, state: tuple[Any, ...], normals: Traceable, row: Traceable
    ) -> tuple[Traceable, tuple[Any, ...]]:
        """See `Process.advance`."""
        integrals, after = self.advance_parts(state, normals, row)
        return sum(integrals[1:], integrals[0]), after

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`."""
        return next(filter(None, (part.why_no_integrals(channel) for part in self.parts)), "")

    def integrals(self, state: tuple[Any, ...], row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        rates, angles = self.integrals_of_parts(state, row)
        return sum(rates[1:], rates[0]), sum(angles[1:], angles[0])


def _shares(normals: Traceable, counts: Sequence[int]) -> list[Traceable]:
    """Deviates of each part."""
    ends = list(accumulate(counts, initial=0))
    return [normals[i:j] for i, j in pairwise(ends)]
