"""Several excitations at once: on the same channels, or each on channels of its own."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import counting
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.excitation import EACH, Excitation, Process


@dataclass(frozen=True, eq=False)
class Superposition(Excitation):
    """The sum of independent excitations, such as sine on random: what ``a + b`` makes.

    Attributes:
        parts: One excitation or more; sums among them are taken apart. The same one twice is two
            independent ones.

    Raises:
        ParameterError: If a part is no excitation.
    """

    parts: Sequence[Excitation]

    def __post_init__(self) -> None:
        parts = checked_parts("Superposition", self.parts)
        flat = [p.parts if isinstance(p, Superposition) else (p,) for p in parts]
        object.__setattr__(self, "parts", tuple(part for some in flat for part in some))

    def process(self, channels: int, step: float) -> "SummedProcess":
        """See `Excitation.process`; at most one part may read a table."""
        return SummedProcess([part.process(channels, step) for part in self.parts])


@dataclass(frozen=True, eq=False)
class Stacked(Excitation):
    """Independent excitations for different channels of one noise input.

    ``Vibration(BaseAcceleration("xyz"), Stacked((WhiteNoise(0.1), record), (2, 1)))`` shakes x
    and y by white noise and z by a record.

    Attributes:
        parts: One excitation or more, in the order of the channels.
        channels: How many channels each takes; one number is that of every part.

    Raises:
        ParameterError: If a part is no excitation, or takes no channel.
        ShapeError: If there are not as many numbers as parts.
    """

    parts: Sequence[Excitation]
    channels: int | Sequence[int] = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", checked_parts("Stacked", self.parts))
        for count in self.shares:
            counting("Stacked channels", count)
        if len(self.shares) != len(self.parts):
            raise ShapeError(
                "Stacked channels", f"{len(self.shares)} numbers", f"{len(self.parts)} parts"
            )

    @property
    def shares(self) -> tuple[int, ...]:
        """How many channels each part takes."""
        if isinstance(self.channels, Sequence):
            return tuple(self.channels)
        return (self.channels,) * len(self.parts)

    def process(self, channels: int, step: float) -> "StackedProcess":
        """See `Excitation.process`; at most one part may read a table."""
        if sum(self.shares) != channels:
            raise ShapeError(
                "Stacked", f"{sum(self.shares)} channels", f"{channels} channels", EACH
            )
        pairs = zip(self.parts, self.shares, strict=True)
        return StackedProcess([part.process(m, step) for part, m in pairs], self.shares)


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


class StackedProcess(JointProcess):
    """Processes of different channels.

    Args:
        parts: The processes.
        channels: How many channels each has.
    """

    def __init__(self, parts: Sequence[Process], channels: Sequence[int]) -> None:
        super().__init__(parts)
        self.channels = tuple(channels)
        self.owners = [(part, k) for part, m in zip(parts, channels, strict=True) for k in range(m)]

    def advance(
        self, state: tuple[Any, ...], normals: Array, row: Array
    ) -> tuple[Array, tuple[Any, ...]]:
        """See `Process.advance`."""
        integrals, after = self.advance_parts(state, normals, row)
        return np.concatenate(integrals), after

    def obstacle(self, channel: int) -> str:
        """See `Process.obstacle`."""
        part, own = self.owners[channel]
        return part.obstacle(own)

    def integrals(self, state: tuple[Any, ...], row: Array) -> tuple[Array, Array]:
        """See `Process.integrals`."""
        zeros = [np.zeros(m) for m in self.channels]  # the size of a part without integrals
        rates, angles = self.integrals_of_parts(state, row)
        W = [zero + own for zero, own in zip(zeros, rates, strict=True)]
        U = [zero + own for zero, own in zip(zeros, angles, strict=True)]
        return np.concatenate(W), np.concatenate(U)


def checked_parts(subject: str, parts: Any) -> tuple[Excitation, ...]:
    """The parts as a tuple.

    Raises:
        ParameterError: If there is none, or one is no excitation.
    """
    found = tuple(parts) if isinstance(parts, Iterable) else (parts,)
    for part in found:
        if not hasattr(part, "process"):
            raise ParameterError(f"{subject} part", repr(part), "an excitation")
    if not found:
        raise ParameterError(f"{subject} parts", "none", "one excitation or more")
    return found


def _shares(normals: Array, counts: Sequence[int]) -> list[Array]:
    """Deviates cut into each part's."""
    ends = list(accumulate(counts, initial=0))
    return [normals[i:j] for i, j in pairwise(ends)]
