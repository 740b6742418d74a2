"""References: desired motions q_d(t) with their first and second derivatives."""

from dataclasses import InitVar, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from ftcfa.arrays import Array
from ftcfa.checks import Check, numbers
from ftcfa.control.protocol import Desired
from ftcfa.errors import ParameterError, ShapeError
from ftcfa.parts import Part
from ftcfa.portable import sin_cos
from ftcfa.vibration.records.columns import read_text_columns

Posture: TypeAlias = npt.ArrayLike | Literal["home"]
"""Numbers, one for each joint [rad or m]; in files also "home", the arm's home posture."""


class Reference(Protocol):
    """A desired motion of n joints."""

    @property
    def n(self) -> int:
        """Number of joints."""
        ...

    def at(self, t: Array) -> Desired:
        """q_d, q_d' and q_d'' at times t of shape (T,) [s], each of shape (T, n)."""
        ...


def joint_values(subject: str, values: npt.ArrayLike, unit: str = "") -> Array:
    """A number for each joint, shape (n,); a single number gives n = 1.

    Raises:
        ParameterError: If an entry is no number.
        ShapeError: If there is none, one is not finite, or there is more than one dimension.
    """
    row = np.atleast_1d(numbers(subject, values))
    if row.ndim != 1 or row.size == 0 or not np.all(np.isfinite(row)):
        expected = f"finite numbers, one for each joint [{unit}]"
        raise ShapeError(subject, f"{row.tolist()}", expected)
    return row


@dataclass(frozen=True, eq=False)
class Constant(Part):
    """A posture to hold: q_d(t) = q.

    Attributes:
        q: Shape (n,) [rad or m].
    """

    q: Annotated[Posture, Check(joint_values, "rad or m")]

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "q", joint_values("Constant q", self.q))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.size(self.q))

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        still = np.zeros((len(t), self.n))
        return Desired(still + np.asarray(self.q), still, still.copy())


@dataclass(frozen=True, eq=False)
class Sinusoid(Part):
    """A sinusoid in each joint.

        q_d(t) = offset + amplitude sin(angular_frequency t + phase)

    Each parameter is one number for all joints, or a number for each.

    Attributes:
        amplitude: [rad or m].
        angular_frequency: [rad/s].
        phase: [rad].
        offset: [rad or m], such as ``arm.home``.

    Raises:
        ParameterError: If a parameter is no number, or ``frequency`` is given.
        ShapeError: If two parameters have different numbers of joints.
    """

    amplitude: Annotated[npt.ArrayLike, Check(joint_values, "rad or m")] = 0.3
    angular_frequency: Annotated[npt.ArrayLike, Check(joint_values, "rad/s")] = 1.0
    phase: Annotated[npt.ArrayLike, Check(joint_values, "rad")] = 0.0
    offset: Annotated[Posture, Check(joint_values, "rad or m")] = 0.0
    frequency: InitVar[None] = field(default=None, kw_only=True)  # refused: it could mean Hz

    def __post_init__(self, frequency: None) -> None:
        if frequency is not None:
            got, remedy = repr(frequency), "multiply a frequency in Hz by 2 pi"
            expected, key = "angular_frequency [rad/s]", "frequency"
            raise ParameterError("Sinusoid frequency", got, expected, remedy, field=key)
        super().__post_init__()
        names = ("amplitude", "angular_frequency", "phase", "offset")
        rows = {name: joint_values(f"Sinusoid {name}", getattr(self, name)) for name in names}
        n = max(row.size for row in rows.values())
        for name, row in rows.items():
            if row.size not in (1, n):
                expected = f"1 or {n} finite numbers"
                raise ShapeError(f"Sinusoid {name}", f"{row.tolist()}", expected, field=name)
            object.__setattr__(self, name, np.broadcast_to(row, (n,)).copy())

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.size(self.offset))

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        A, w = np.asarray(self.amplitude), np.asarray(self.angular_frequency)
        sine, cosine = sin_cos(np.outer(t, w) + np.asarray(self.phase, dtype=float))
        q = np.asarray(self.offset) + A * sine
        return Desired(q, A * w * cosine, -A * (w * w) * sine)


@dataclass(frozen=True, eq=False)
class _Tabulated:
    """Postures at given times, checked: the base of `MinimumJerk` and `Table`."""

    times: npt.ArrayLike
    points: Posture

    def __post_init__(self) -> None:
        times, points = _table(type(self).__name__, self.times, self.points)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "points", points)

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.asarray(self.points).shape[1])


@dataclass(frozen=True, eq=False)
class MinimumJerk(_Tabulated):
    """Way-points joined by minimum-jerk moves, at rest at each of them (Flash and Hogan 1985).

        q_d = p_i + (p_{i+1} - p_i) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t_i)/(t_{i+1} - t_i)

    The first posture is held before the first time, the last posture after the last time.

    Attributes:
        times: Rising times, shape (P,) [s].
        points: Posture at each time, shape (P, n) [rad or m].
    """

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        times, points = np.asarray(self.times), np.asarray(self.points)
        i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
        span = (times[i + 1] - times[i])[:, None]
        s = np.clip((t - times[i])[:, None] / span, 0.0, 1.0)
        move = points[i + 1] - points[i]
        return Desired(
            points[i] + move * (s * s * s) * (10.0 - 15.0 * s + 6.0 * (s * s)),
            move / span * 30.0 * (s * s) * ((1.0 - s) * (1.0 - s)),
            move / (span * span) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        )


@dataclass(frozen=True, eq=False)
class Table(_Tabulated):
    """A recorded or planned motion (t, q), joined by a twice differentiable cubic spline.

    The spline starts and ends at rest. The first posture is held before it, the last after it.

    Attributes:
        times: Rising times, shape (P,) [s].
        points: Posture at each time, shape (P, n) [rad or m].
        joints: Names of the joints in the order of the columns, which a loop matches with those
            of its arm; without names they go by position.
    """

    joints: tuple[str, ...] = ()

    @classmethod
    def from_file(cls, file: str | Path) -> "Table":
        """Read a CSV file: a column of times [s], then one for each joint [rad or m].

        Comments begin with ``#``. A first line of words names the columns; units in brackets are
        left out.

        Raises:
            ParameterError: If the file cannot be read or is not such a table.
        """
        columns = read_text_columns(Path(file))
        if len(columns.names) < 2:
            expected = "a column of times, then one column for each joint"
            raise ParameterError(str(file), "1 column", expected)
        times, *joints = (columns.numbers(k) for k in range(len(columns.names)))
        names, points = columns.names[1:], np.column_stack(joints)
        return cls(*_table(str(file), times, points), joints=names if columns.header else ())

    def of_joints(self, names: tuple[str, ...]) -> "Table":
        """The table with its columns in the order of an arm's joints, by name.

        Raises:
            ParameterError: If its names are not those of the joints.
        """
        if self.joints in ((), names):
            return self
        if sorted(self.joints) != sorted(names):
            strange = [name for name in self.joints if name not in names]
            absent = [name for name in names if name not in self.joints]
            got = f"columns {', '.join(self.joints)}" + "".join(
                f"; {word} {', '.join(some)}"
                for word, some in (("unknown:", strange), ("missing:", absent))
                if some
            )
            remedy = "name the columns after the joints, or leave the header out to go by position"
            expected = f"one column for each of {', '.join(names)}"
            raise ParameterError("joints of the Table", got, expected, remedy)
        order = [self.joints.index(name) for name in names]
        return Table(self.times, np.asarray(self.points)[:, order], names)

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(np.asarray(self.times), np.asarray(self.points), bc_type="clamped")

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        first, last = np.asarray(self.times)[[0, -1]]
        inside = ((t >= first) & (t <= last))[:, None]
        clipped = np.clip(t, first, last)
        return Desired(
            self._spline(clipped),
            np.where(inside, self._spline(clipped, 1), 0.0),
            np.where(inside, self._spline(clipped, 2), 0.0),
        )


def _table(subject: str, times: npt.ArrayLike, points: npt.ArrayLike) -> tuple[Array, Array]:
    """Checked times, shape (P,), and points, shape (P, n)."""
    t = numbers(f"{subject} times", times, field="times")
    q = numbers(f"{subject} points", points, field="points")
    if t.ndim != 1 or q.ndim != 2 or len(t) != len(q) or len(t) < 2:
        raise ShapeError(subject, f"times {t.shape}, points {q.shape}", "(P,) and (P, n), P >= 2")
    finite = np.isfinite(t) & np.all(np.isfinite(q), axis=1)
    if not np.all(finite):
        row = int(np.argmin(finite))
        raise ParameterError(subject, f"row {row} is {t[row]}, {q[row].tolist()}", "finite numbers")
    if np.any(np.diff(t) <= 0):
        row = int(np.argmax(np.diff(t) <= 0))
        got = f"time {t[row + 1]} follows {t[row]}"
        raise ParameterError(subject, got, "increasing times", field="times")
    return t, q


def of_joints(reference: Reference, names: tuple[str, ...]) -> Reference:
    """A reference for the joints of some names; the columns of a `Table` are put in their order.

    Raises:
        ShapeError: If it has another number of joints.
        ParameterError, UnknownNameError: If a table has other joints.
    """
    if isinstance(reference, Table):
        reference = reference.of_joints(names)
    if reference.n != len(names):
        expected = f"{len(names)}: {', '.join(names)}"
        raise ShapeError("ClosedLoop reference", f"{reference.n} joints", expected)
    return reference
