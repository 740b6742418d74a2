"""References: desired motions q_d(t) with their first and second derivatives."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired
from ftcfa.errors import ParameterError, ShapeError


class Reference(Protocol):
    """A desired motion of n joints."""

    @property
    def n(self) -> int:
        """Number of joints."""
        ...

    def at(self, t: Array) -> Desired:
        """q_d, q_d' and q_d'' at times t of shape (T,) [s], each of shape (T, n)."""
        ...


def _row(subject: str, values: npt.ArrayLike, n: int | None = None) -> Array:
    row = np.atleast_1d(_numbers(subject, values))
    fits = row.ndim == 1 and row.size > 0 and (n is None or row.size in (1, n))
    if not fits or not np.all(np.isfinite(row)):
        expected = "finite numbers, one a joint" if n is None else f"1 or {n} finite numbers"
        raise ShapeError(subject, f"{row.tolist()}", expected)
    return row if n is None else np.broadcast_to(row, (n,)).copy()


def _numbers(subject: str, values: npt.ArrayLike) -> Array:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(subject, repr(values), "numbers") from error


@dataclass(frozen=True, eq=False)
class Constant:
    """A posture to hold: q_d(t) = q.

    Attributes:
        q: Shape (n,) [rad or m].
    """

    q: npt.ArrayLike

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", _row("Constant q", self.q))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.size(self.q))

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        still = np.zeros((len(t), self.n))
        return Desired(still + np.asarray(self.q), still, still.copy())


@dataclass(frozen=True, eq=False)
class Sinusoid:
    """q_d(t) = offset + amplitude sin(frequency t + phase), joint by joint.

    The longest parameter gives n; shorter ones hold for every joint.

    Attributes:
        amplitude: [rad or m].
        frequency: Angular frequency [rad/s].
        phase: [rad].
        offset: [rad or m], such as ``arm.home``.
    """

    amplitude: npt.ArrayLike = 0.3
    frequency: npt.ArrayLike = 1.0
    phase: npt.ArrayLike = 0.0
    offset: npt.ArrayLike = 0.0

    def __post_init__(self) -> None:
        names = ("amplitude", "frequency", "phase", "offset")
        n = max(_row(f"Sinusoid {name}", getattr(self, name)).size for name in names)
        for name in names:
            object.__setattr__(self, name, _row(f"Sinusoid {name}", getattr(self, name), n))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.size(self.offset))

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        A, w = np.asarray(self.amplitude), np.asarray(self.frequency)
        angle = np.outer(t, w) + self.phase
        q = np.asarray(self.offset) + A * np.sin(angle)
        return Desired(q, A * w * np.cos(angle), -A * w**2 * np.sin(angle))


@dataclass(frozen=True, eq=False)
class _Tabulated:
    """What references over a table of postures share: the table, checked."""

    times: npt.ArrayLike
    points: npt.ArrayLike

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
    """Way-points joined by minimum-jerk moves, at rest at each (Flash and Hogan 1985).

        q_d = p_i + (p_{i+1} - p_i) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t_i)/(t_{i+1} - t_i)

    Before the first and after the last time the end postures are held.

    Attributes:
        times: Increasing, shape (P,) [s].
        points: Shape (P, n) [rad or m].
    """

    def at(self, t: Array) -> Desired:
        """See `Reference.at`."""
        times, points = np.asarray(self.times), np.asarray(self.points)
        i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
        span = (times[i + 1] - times[i])[:, None]
        s = np.clip((t - times[i])[:, None] / span, 0.0, 1.0)
        move = points[i + 1] - points[i]
        return Desired(
            points[i] + move * s**3 * (10.0 - 15.0 * s + 6.0 * s**2),
            move / span * 30.0 * s**2 * (1.0 - s) ** 2,
            move / span**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        )


@dataclass(frozen=True, eq=False)
class Table(_Tabulated):
    """A recorded or planned motion (t, q), joined by a twice differentiable cubic spline.

    The spline starts and ends at rest; before and after, the end postures are held.

    Attributes:
        times: Increasing, shape (P,) [s].
        points: Shape (P, n) [rad or m].
    """

    @classmethod
    def from_file(cls, file: str | Path) -> "Table":
        """Read a CSV file: a column of times [s], then one a joint [rad or m]; `#` comments.

        A first line of column names, known by a first word that is no number, is skipped.

        Raises:
            ParameterError: If the file cannot be read or is not such a table.
        """
        try:
            lines = Path(file).read_text(encoding="utf-8-sig").splitlines()
            rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
            header = bool(rows) and not _is_number(rows[0].split(",")[0])
            table = np.array([row.split("#")[0].split(",") for row in rows[header:]], dtype=float)
        except (OSError, ValueError) as error:
            raise ParameterError(
                str(file), f"unreadable ({error})", "a CSV table: time, then one column a joint"
            ) from error
        if table.ndim != 2 or min(table.shape) < 2:
            raise ParameterError(str(file), f"shape {table.shape}", "two rows and columns or more")
        return cls(*_table(str(file), table[:, 0], table[:, 1:]))

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
    """Times (P,) and points (P, n), checked."""
    t, q = _numbers(f"{subject} times", times), _numbers(f"{subject} points", points)
    if t.ndim != 1 or q.ndim != 2 or len(t) != len(q) or len(t) < 2:
        raise ShapeError(subject, f"times {t.shape}, points {q.shape}", "(P,) and (P, n), P >= 2")
    finite = np.isfinite(t) & np.all(np.isfinite(q), axis=1)
    if not np.all(finite):
        row = int(np.argmin(finite))
        raise ParameterError(subject, f"row {row} is {t[row]}, {q[row].tolist()}", "finite numbers")
    if np.any(np.diff(t) <= 0):
        row = int(np.argmax(np.diff(t) <= 0))
        raise ParameterError(subject, f"time {t[row + 1]} follows {t[row]}", "increasing times")
    return t, q


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
