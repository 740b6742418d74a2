"""An accelerometer's record as the excitation, each path from a moment of its own."""

from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ShapeError
from ftcfa.vibration.excitation import Excitation, Process
from ftcfa.vibration.record import Record


@dataclass(frozen=True, eq=False)
class RecordedAcceleration(Excitation):
    """A record, detrended, resampled to the integration step and repeated without end.

    Attributes:
        record: From `read_record`, or values of your own in a `Record`; an axis a channel.
        random_start: Whether each path begins at a sample of its own, keyed by (seed, path).
    """

    record: Record
    random_start: bool = True

    def process(self, channels: int, step: float) -> "TabulatedProcess":
        """See `Excitation.process`."""
        axes = self.record.values.shape[1]
        if axes != channels:
            raise ShapeError("RecordedAcceleration", f"{axes} axes", f"{channels} channels")
        values = self.record.detrended().resampled(step).values
        following = np.roll(values, -1, axis=0)
        return TabulatedProcess(step * (values + following) / 2.0, self.random_start)


class TabulatedProcess(Process):
    """Integrals of xi over steps, read from rows; straight lines between a record's samples."""

    normals = 0

    def __init__(self, rows: Array, random_start: bool) -> None:
        self.rows = rows
        self.random_start = random_start

    def advance(self, state: tuple[()], normals: Array, row: Array) -> tuple[Array, tuple[()]]:  # noqa: ARG002
        """See `Process.advance`."""
        return row, state
