"""What a tuner may change: the numbers that the parts of a law declare, with their ranges.

A field of a law is tuned in the range that its `ftcfa.checks.Check` declares as ``search``; a new
law needs nothing else. A field with a number for each joint counts as so many numbers. The
logarithm of every number is searched, mapped to 0 at the smallest and 1 at the largest value.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import declared, is_number
from ftcfa.engine.compiler.trace import without_effect
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.parameters import checked_values, parameter, with_parameters
from ftcfa.parts import fields_of, parameters_of

LAW = "controller"
"""The field of a loop in which gains are looked for."""


class Range(NamedTuple):
    """Where one parameter is searched."""

    low: float
    """Smallest value."""
    high: float
    """Largest value."""
    unit: str = ""
    """Unit of both."""


def search_space(loop: ClosedLoop) -> dict[str, Range]:
    """All that can be tuned of a loop's law, by dotted name such as ``controller.gains.c1``.

    What has no effect on the motion of this loop is left out, such as the rate of an adaptation
    that is off.
    """
    found = dict(_declared(loop.controller, LAW))
    idle = without_effect(loop, tuple(found))
    return {name: it for name, it in found.items() if name not in idle}


def _declared(part: Any, above: str) -> Iterator[tuple[str, Range]]:
    """Declared ranges of the parameters of a part and of the parts in it, but for the robots."""
    kind: Any = type(part)
    for name in parameters_of(part):
        check = declared(kind).get(name)
        if check is not None and check[0].search is not None:
            yield f"{above}.{name}", Range(*check[0].search, check[0].unit)
    for name, inside in fields_of(part).items():
        if not hasattr(inside, "mass_matrix"):
            yield from _declared(inside, f"{above}.{name}")


def joint_by_joint(loop: ClosedLoop) -> ClosedLoop:
    """The loop with a number for each joint in every field that may have one and is tuned."""
    found = {}
    for name in search_space(loop):
        *words, last = name.split(".")
        part: Any = loop
        for word in words:
            part = getattr(part, word)
        if last in getattr(part, "per_joint", ()):
            found[name] = np.broadcast_to(parameter(loop, name), (loop.arm.n,)).copy()
    return with_parameters(loop, found)


class Space:
    """The numbers that are searched, each between 0 and 1.

    Args:
        loop: The loop whose law starts the search.
        ranges: Names of parameters and their ranges, ``(smallest, largest)`` or `Range`; by default
            `search_space`.

    Raises:
        ParameterError: If there is nothing to search, or a range is wrong.
        UnknownNameError: If the loop has no such parameter.
    """

    def __init__(
        self, loop: ClosedLoop, ranges: Mapping[str, tuple[float, float]] | None = None
    ) -> None:
        given = search_space(loop) if ranges is None else ranges
        if not given:
            law = type(loop.controller).__name__
            remedy = "declare ranges with Check(..., search=(low, high)), or give a space"
            raise ParameterError("tune space", f"nothing of {law}", "parameters to tune", remedy)
        self.start = {name: parameter(loop, name) for name in given}
        """Value of each parameter in the loop as given, shape () or (n,)."""
        self.ranges = check_ranges(loop, given)
        """Range of each parameter."""

    @property
    def names(self) -> list[str]:
        """Name of every number that is searched; one of a joint has its index."""
        return [
            f"{name}[{i}]" if value.ndim else name
            for name, value in self.start.items()
            for i in range(value.size)
        ]

    @property
    def unit_start(self) -> Array:
        """The loop as given as a point of the search, shape (d,); within [0, 1]."""
        return self._point(self.start)

    @property
    def widths(self) -> Array:
        """Logarithm of the largest over the smallest value of each number, shape (d,)."""
        rows = [
            np.full(value.size, np.log(self.ranges[name].high / self.ranges[name].low))
            for name, value in self.start.items()
        ]
        return np.concatenate(rows)

    def point_of(self, loop: ClosedLoop) -> Array:
        """A loop with other gains as a point of the search, shape (d,); within [0, 1]."""
        values = {name: parameter(loop, name) for name in self.start}
        return self._point(
            {name: np.broadcast_to(x, self.start[name].shape) for name, x in values.items()}
        )

    def _point(self, values: Mapping[str, Array]) -> Array:
        rows = []
        for name, value in values.items():
            low, high, *_ = self.ranges[name]
            inside = np.clip(value.ravel(), low, high)
            rows.append(np.log(inside / low) / np.log(high / low))
        return np.concatenate(rows)

    def values(self, points: Array) -> dict[str, Array]:
        """Parameters of points of the search, shape (candidates, d): each of (candidates, ...)."""
        found, first = {}, 0
        for name, value in self.start.items():
            low, high, *_ = self.ranges[name]
            columns = points[:, first : first + value.size]
            found[name] = (low * (high / low) ** columns).reshape(len(points), *value.shape)
            first += value.size
        return found

    def loop_at(self, loop: ClosedLoop, point: Array) -> ClosedLoop:
        """The loop with the parameters of a point, shape (d,)."""
        values = {name: rows[0] for name, rows in self.values(point[None]).items()}
        return with_parameters(
            loop, {name: x if x.ndim else float(x) for name, x in values.items()}
        )


def check_ranges(loop: ClosedLoop, ranges: Mapping[str, Any]) -> dict[str, Range]:
    """The ranges, whose ends the parts of a loop admit.

    Raises:
        ParameterError, UnknownNameError: If one is wrong.
    """
    return {name: _checked_range(loop, name, ends) for name, ends in ranges.items()}


def _checked_range(loop: ClosedLoop, name: str, ends: Any) -> Range:
    low_high = tuple(ends)[:2] if isinstance(ends, tuple | list) else ()
    right = len(low_high) == 2 and all(map(is_number, low_high))
    if not (right and 0 < low_high[0] < low_high[1]):
        expected = "0 < smallest < largest, the ends of a logarithmic range"
        raise ParameterError(f"tune space of {name}", repr(ends), expected)
    shape = parameter(loop, name).shape
    both = np.broadcast_to(np.reshape(low_high, (2, *(1 for _ in shape))), (2, *shape))
    checked_values(loop, {name: both}, 2)
    return Range(*low_high, *tuple(ends)[2:])
