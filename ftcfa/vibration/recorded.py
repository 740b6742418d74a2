"""An accelerometer's record as the excitation, each path from a moment of its own."""

from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.vibration.excitation import EACH, Excitation, Process
from ftcfa.vibration.record import Record


@dataclass(frozen=True, eq=False)
class RecordedAcceleration(Excitation):
    """A record, detrended, resampled to the integration step and repeated without end.

    Attributes:
        record: From `read_record`, or values of your own in a `Record`; an axis a channel.
        random_start: Whether each path begins at a sample of its own, keyed by (seed, path).

    Raises:
        ParameterError: If the record is none.
    """

    record: Record
    random_start: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.record, Record):
            raise ParameterError(
                "RecordedAcceleration record",
                f"a {type(self.record).__name__}",
                "a Record",
                "read_record(file) reads one; Record(step, values) holds values of your own",
            )

    def process(self, channels: int, step: float) -> "TabulatedProcess":
        """See `Excitation.process`."""
        axes = self.record.values.shape[1]
        if axes != channels:
            raise ShapeError("RecordedAcceleration", f"{axes} axes", f"{channels} channels", EACH)
        values = self.record.detrended().resampled(step).values
        following = np.roll(values, -1, axis=0)
        return TabulatedProcess(step * (values + following) / 2.0, self.random_start)


class TabulatedProcess(Process):
    """Integrals Y of xi over steps, read from rows; straight lines between a record's samples.

    What repeats must have no mean, or its integral drifts; it is taken away. A row holds Y and
    the W before it, both of mean zero over the table, shape (2 m,).

    Args:
        integrals: Y, shape (R, m).
        random_start: Whether each path begins at a row of its own.
    """

    normals = 0

    def __init__(self, integrals: Array, random_start: bool) -> None:
        Y = integrals - integrals.mean(axis=0)
        W = np.cumsum(Y, axis=0) - Y
        self.rows = np.hstack([Y, W - W.mean(axis=0)])
        self.random_start = random_start
        self.channels = Y.shape[1]
        self.integrable = frozenset(range(self.channels))

    def advance(self, state: tuple[()], normals: Array, row: Array) -> tuple[Array, tuple[()]]:  # noqa: ARG002
        """See `Process.advance`."""
        return row[: self.channels], state

    def rate(self, state: tuple[()], row: Array) -> Array:  # noqa: ARG002
        """See `Process.rate`."""
        return row[self.channels :]
