"""Excitations xi: what shakes the robot, as the increment of its integral over a step."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields
from ftcfa.errors import ParameterError

EACH = "one for each channel of the noise input, or choose fewer of its axes"
"""Remedy where there are not as many channels as the input has."""


class Process(ABC):
    """An excitation over integration steps of one length: what the loop runs.

        Y_k, x_{k+1} = advance(x_k, n_k, row_k),      Y_k: integral of xi over step k

    Attributes:
        initial_normals: Standard normal deviates that the initial state takes.
        rows: Numbers that all paths share, a row a step, shape (R, columns); after the last row
            comes the first.
        random_start: Whether each path begins at a row of its own.
    """

    initial_normals: int = 0
    rows: Array = np.zeros((1, 0))
    random_start: bool = False

    @property
    @abstractmethod
    def normals(self) -> int:
        """Standard normal deviates a step."""

    def init(self, normals: Array) -> Any:  # noqa: ARG002
        """State before the first step: arrays in tuples, from ``initial_normals`` deviates."""
        return ()

    @abstractmethod
    def advance(self, state: Any, normals: Array, row: Array) -> tuple[Array, Any]:
        """One step: integral of xi over it, shape (m,), and the new state.

        Args:
            state: State at its start.
            normals: Standard normal deviates, shape (normals,).
            row: The step's row, shape (columns,).
        """

    def obstacle(self, channel: int) -> str:  # noqa: ARG002
        """Why a channel has not both `integrals`, and so cannot turn a base; "" if it has."""
        return "an excitation that gives no integrals"

    def integrals(self, state: Any, row: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """The stationary integrals W of xi and U of W at the start of a step, shape (m,) each.

            W_{k+1} = W_k + Y_k,   U_{k+1} = U_k + integral of W over step k

        Both are of mean zero. They have no meaning in channels with an `obstacle`; a process
        whose channels all have one need not give them.

        Args:
            state: State there.
            row: The step's row.
        """
        return np.zeros(1), np.zeros(1)


class Excitation(ABC):
    """What shakes: a description from which a `Process` is made for a step length."""

    @abstractmethod
    def process(self, channels: int, step: float) -> Process:
        """The excitation of m channels over steps of one length.

        Raises:
            ShapeError: If it has another number of channels.
            ParameterError: If the step is too long for it.
        """

    def __add__(self, other: "Excitation") -> "Excitation":
        """Both at once on the same channels, independent: a `Superposition`.

        Raises:
            ParameterError: If the other is no excitation.
        """
        return Superposition((self, other))


def checked_parts(subject: str, parts: Any) -> tuple[Excitation, ...]:
    """The parts as a tuple.

    Raises:
        ParameterError: If there is none, or one is no excitation.
    """
    found = tuple(parts) if isinstance(parts, Iterable) else (parts,)
    for part in found:
        if not hasattr(part, "process"):
            raise ParameterError(subject, repr(part), "an excitation")
    if not found:
        raise ParameterError(subject, "none", "one excitation or more")
    return found


@dataclass(frozen=True, eq=False)
class Superposition(Excitation):
    """The sum of independent excitations, such as sine on random: what ``a + b`` makes.

    Attributes:
        parts: One excitation or more; sums among them are taken apart. The same one twice is two
            independent ones.

    Raises:
        ParameterError: If a part is no excitation.
    """

    parts: Annotated[Sequence[Excitation], Check(checked_parts)]

    def __post_init__(self) -> None:
        check_fields(self)
        parts = checked_parts("Superposition parts", self.parts)
        flat = [p.parts if isinstance(p, Superposition) else (p,) for p in parts]
        object.__setattr__(self, "parts", tuple(part for some in flat for part in some))

    def process(self, channels: int, step: float) -> "SummedProcess":
        """See `Excitation.process`; at most one part may read a table."""
        return SummedProcess([part.process(channels, step) for part in self.parts])


class JointProcess(Process):
    """Independent processes side by side: states in a tuple, deviates one after the other.

    Args:
        parts: The processes.

    Raises:
        ParameterError: If more than one of them reads rows.
    """

    def __init__(self, parts: Sequence[Process]) -> None:
        self.parts = tuple(parts)
        self.initial_normals = sum(part.initial_normals for part in parts)
        tables = [part for part in parts if part.rows.shape[1]]
        if len(tables) > 1:
            raise ParameterError(
                "excitation",
                f"{len(tables)} records among its parts",
                "at most one",
                "add their values up, or make them axes of one, in a Record",
            )
        for table in tables:
            self.rows, self.random_start = table.rows, table.random_start

    @property
    def normals(self) -> int:
        """Deviates of all parts."""
        return sum(part.normals for part in self.parts)

    def init(self, normals: Array) -> tuple[Any, ...]:
        """States of all parts."""
        shares = _shares(normals, [part.initial_normals for part in self.parts])
        return tuple(part.init(own) for part, own in zip(self.parts, shares, strict=True))

    def advance_parts(
        self, state: tuple[Any, ...], normals: Array, row: Array
    ) -> tuple[list[Array], tuple[Any, ...]]:
        """Integrals and new states of all parts."""
        shares = _shares(normals, [part.normals for part in self.parts])
        steps = [
            part.advance(own, share, row)
            for part, own, share in zip(self.parts, state, shares, strict=True)
        ]
        return [Y for Y, _ in steps], tuple(after for _, after in steps)

    def integrals_of_parts(
        self, state: tuple[Any, ...], row: Array
    ) -> tuple[list[Array], list[Array]]:
        """The stationary integrals W and U of all parts."""
        both = [part.integrals(own, row) for part, own in zip(self.parts, state, strict=True)]
        return [W for W, _ in both], [U for _, U in both]


class SummedProcess(JointProcess):
    """The sum of processes of the same channels."""

    def advance(
        self, state: tuple[Any, ...], normals: Array, row: Array
    ) -> tuple[Array, tuple[Any, ...]]:
        """See `Process.advance`."""
        integrals, after = self.advance_parts(state, normals, row)
        return sum(integrals[1:], integrals[0]), after

    def obstacle(self, channel: int) -> str:
        """See `Process.obstacle`."""
        return next(filter(None, (part.obstacle(channel) for part in self.parts)), "")

    def integrals(self, state: tuple[Any, ...], row: Array) -> tuple[Array, Array]:
        """See `Process.integrals`."""
        rates, angles = self.integrals_of_parts(state, row)
        return sum(rates[1:], rates[0]), sum(angles[1:], angles[0])


def _shares(normals: Array, counts: Sequence[int]) -> list[Array]:
    """Deviates cut into each part's."""
    ends = list(accumulate(counts, initial=0))
    return [normals[i:j] for i, j in pairwise(ends)]
