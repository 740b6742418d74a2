"""Excitations xi of the surroundings, their sums, and several side by side.

The loop takes their integrals over its steps.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.checks import Check, counting
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.parts import Part


def check_channels(subject: str, got: int, channels: int, *, word: str = "channels") -> None:
    """Raise ShapeError unless an excitation has as many channels as the noise input."""
    if got != channels:
        remedy = "give one for each channel of the noise input, or choose fewer of its axes"
        raise ShapeError(subject, f"{got} {word}", f"{channels} channels", remedy)


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

    def init(self, normals: Traceable) -> Any:
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

    def why_no_integrals(self, channel: int) -> str:
        """Reason why a channel lacks `integrals` and cannot turn a base; "" if it has both."""
        return "an excitation that gives no integrals"

    def integrals(self, state: Any, row: Traceable) -> tuple[Traceable, Traceable]:
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

    def process(self, channels: int, step: float) -> "JointProcess":
        """See `Excitation.process`; at most one part may have rows."""
        return JointProcess(tuple(part.process(channels, step) for part in self.parts))


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

    def process(self, channels: int, step: float) -> "JointProcess":
        """See `Excitation.process`; at most one part may have rows."""
        check_channels("Stacked", sum(self.shares), channels)
        pairs = zip(self.parts, self.shares, strict=True)
        return JointProcess(tuple(part.process(m, step) for part, m in pairs), self.shares)


@dataclass(frozen=True, eq=False)
class JointProcess(Process):
    """Independent processes, added up or side by side.

    Their states are in a tuple, their deviates one after the other.

    Attributes:
        parts: The processes.
        shares: Number of channels of each, side by side; empty for the sum of all.

    Raises:
        ParameterError: If more than one of them has rows.
    """

    parts: tuple[Process, ...]
    shares: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        tables = sum(part.rows.shape[1] > 0 for part in self.parts)
        if tables > 1:
            got, remedy = f"{tables} records among its parts", "add their values, or make them axes"
            raise ParameterError("excitation", got, "at most one", f"{remedy} of one Record")

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
        shares = _split(normals, [part.initial_normals for part in self.parts])
        return tuple(part.init(own) for part, own in zip(self.parts, shares, strict=True))

    def advance(
        self, state: tuple[Any, ...], normals: Traceable, row: Traceable
    ) -> tuple[Traceable, tuple[Any, ...]]:
        """See `Process.advance`."""
        shares = _split(normals, [part.normals for part in self.parts])
        triples = zip(self.parts, state, shares, strict=True)
        steps = [part.advance(own, share, row) for part, own, share in triples]
        return self._joined([Y for Y, _ in steps]), tuple(after for _, after in steps)

    def why_no_integrals(self, channel: int) -> str:
        """See `Process.why_no_integrals`."""
        owners = [(part, channel) for part in self.parts]
        if self.shares:
            pairs = zip(self.parts, self.shares, strict=True)
            owners = [[(part, own) for part, count in pairs for own in range(count)][channel]]
        return next(filter(None, (part.why_no_integrals(own) for part, own in owners)), "")

    def integrals(self, state: tuple[Any, ...], row: Traceable) -> tuple[Traceable, Traceable]:
        """See `Process.integrals`."""
        both = [part.integrals(own, row) for part, own in zip(self.parts, state, strict=True)]
        if self.shares:  # a part without integrals gives one zero for all of its channels
            zeros = [np.zeros(m) for m in self.shares]
            both = [(zero + W, zero + U) for zero, (W, U) in zip(zeros, both, strict=True)]
        return self._joined([W for W, _ in both]), self._joined([U for _, U in both])

    def _joined(self, values: list[Traceable]) -> Traceable:
        """Values of all parts, side by side or added up."""
        return np.concatenate(values) if self.shares else sum(values[1:], values[0])


def _split(normals: Traceable, counts: Sequence[int]) -> list[Traceable]:
    """Deviates of each part."""
    ends = list(accumulate(counts, initial=0))
    return [normals[i:j] for i, j in pairwise(ends)]
