"""Independent excitations for different channels of one noise input."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, counting
from ftcfa.errors import ShapeError
from ftcfa.vibration.excitation import EACH, Excitation, JointProcess, checked_parts


def check_shares(subject: str, channels: int | Sequence[int]) -> None:
    """Raise ParameterError unless every number of channels is one or more."""
    for count in channels if isinstance(channels, Sequence) else (channels,):
        counting(subject, count)


@dataclass(frozen=True, eq=False)
class Stacked(Excitation):
    """Independent excitations for different channels of one noise input.

    ``Vibration(BaseAcceleration("xyz"), Stacked((WhiteNoise(0.1), record), (2, 1)))`` shakes x
    and y by white noise and z by a record.

    Attributes:
        parts: One excitation or more, in the order of the channels.
        channels: Number of channels of each part; a single number holds for all parts.

    Raises:
        ParameterError: If a part is no excitation, or has no channel.
        ShapeError: If there are not as many numbers as parts.
    """

    parts: Annotated[Sequence[Excitation], Check(checked_parts)]
    channels: Annotated[int | Sequence[int], Check(check_shares)] = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "parts", checked_parts("Stacked parts", self.parts))
        if len(self.shares) != len(self.parts):
            got = f"{len(self.shares)} numbers"
            raise ShapeError("Stacked channels", got, f"{len(self.parts)} parts", field="channels")

    @property
    def shares(self) -> tuple[int, ...]:
        """Number of channels of each part."""
        if isinstance(self.channels, Sequence):
            return tuple(self.channels)
        return (self.channels,) * len(self.parts)

    def process(self, channels: int, step: float) -> "StackedProcess":
        """See `Excitation.process`; at most one part may have rows."""
        if sum(self.shares) != channels:
            raise ShapeError(
                "Stacked", f"{sum(self.shares)} channels", f"{channels} channels", EACH
            )
        pairs = zip(self.parts, self.shares, strict=True)
        return StackedProcess(tuple(part.process(m, step) for part, m in pairs), self.shares)


@dataclass(frozen=True, eq=False)
class StackedProcess(JointProcess):
    """Processes of different channels.

    Attributes:
        parts: The processes.
        channels: Number of channels of each.
    """

    channels: tuple[int, ...]

    def advance(
        self, state: tuple[Any, ...], normals: Traceable, row: Traceable
    ) -> tuple[Traceable, tuple[Any, ...]]:
        """See `Process.advance`."""
        integrals, after = self.advance_parts(state, normals, row)
        return np.concatenate(integrals), after

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`."""
        pairs = zip(self.parts, self.channels, strict=True)
        owners = [(part, own) for part, count in pairs for own in range(count)]
        part, own = owners[channel]
        return part.why_no_integrals(own)

    def integrals(self, state: tuple[Any, ...], row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        zeros = [np.zeros(m) for m in self.channels]  # the size of a part without integrals
        rates, angles = self.integrals_of_parts(state, row)
        W = [zero + own for zero, own in zip(zeros, rates, strict=True)]
        U = [zero + own for zero, own in zip(zeros, angles, strict=True)]
        return np.concatenate(W), np.concatenate(U)
