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
    row = np.atleast_1d(np.asarray(values, dtype=float))
    if row.ndim != 1 or not np.all(np.isfinite(row)) or (n is not None and row.size not in (1, n)):
        raise ShapeError(subject, f"{np.asarray(values).tolist()}", "finite numbers, one a joint")
    return row if n is None else np.broadcast_to(row, (n,)).copy()


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
class MinimumJerk:
    """Way-points joined by minimum-jerk moves, at rest at each (Flash and Hogan 1985).

        q_d = p_i + (p_{i+1} - p_i) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t_i)/(t_{i+1} - t_i)

    Before the first and after the last time the end postures are held.

    Attributes:
        times: Increasing, shape (P,) [s].
        points: Shape (P, n) [rad or m].
    """

    times: npt.ArrayLike
    points: npt.ArrayLike

    def __post_init__(self) -> None:
        times, points = _table("MinimumJerk", self.times, self.points)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "points", points)

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.asarray(self.points).shape[1])

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
class Table:
    """A recorded or planned motion (t, q), joined by a twice differentiable cubic spline.

    The spline starts and ends at rest; before and after, the end postures are held.

    Attributes:
        times: Increasing, shape (P,) [s].
        points: Shape (P, n) [rad or m].
    """

    times: npt.ArrayLike
    points: npt.ArrayLike

    def __post_init__(self) -> None:
        times, points = _table("Table", self.times, self.points)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "points", points)

    @classmethod
    def from_file(cls, file: str | Path) -> "Table":
        """Read a CSV file: a column of times [s], then one a joint [rad or m]; `#` comments.

        A first line of column names is skipped.

        Raises:
            ParameterError: If the file cannot be read or is not such a table.
        """
        try:
            lines = Path(file).read_text().splitlines()
            rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
            header = bool(rows) and any(c.isalpha() and c not in "eE" for c in rows[0])
            table = np.loadtxt(rows[header:], delimiter=",", ndmin=2)
        except (OSError, ValueError) as error:
            raise ParameterError(
                str(file), f"unreadable ({error})", "a CSV table: time, then one column a joint"
            ) from error
        if table.shape[0] < 2 or table.shape[1] < 2:
            raise ParameterError(str(file), f"shape {table.shape}", "two rows and columns or more")
        return cls(table[:, 0], table[:, 1:])

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(np.asarray(self.points).shape[1])

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
    t, q = np.asarray(times, dtype=float), np.asarray(points, dtype=float)
    if t.ndim != 1 or q.ndim != 2 or len(t) != len(q) or len(t) < 2:
        raise ShapeError(subject, f"times {t.shape}, points {q.shape}", "(P,) and (P, n), P >= 2")
    if not (np.all(np.isfinite(t)) and np.all(np.isfinite(q)) and np.all(np.diff(t) > 0)):
        raise ParameterError(subject, "times not increasing or values not finite", "a clean table")
    return t, q
