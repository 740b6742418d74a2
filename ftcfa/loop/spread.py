"""Numbers of a loop that differ from path to path: a gain, a delay, an amplitude.

    ClosedLoop(..., spread={"reference_scale": (0.5, 1.5), "hardware.sensors.latency": (0.0, 2e-3)})

They are uniform between the smallest and the largest value, and independent: for each joint, where
a number is given for each. Times of sensors and motors are rounded to whole integration steps. The
bodies of the robot are drawn by `ftcfa.model.uncertainty.Uncertainty` instead, as bodies.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_number
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.parts import Parameter, fields_of, parameters_of
from ftcfa.portable import normal_cdf
from ftcfa.streams import SPREAD, Words, normals_of_paths

Spread = Mapping[str, tuple[float, float]]
"""Smallest and largest value of numbers, by dotted name."""


def check_spread(loop: Any, spread: Spread) -> None:
    """Raise an FtcfaError unless every name is that of a parameter, and its values are right."""
    for name, ends in spread.items():
        low_high = tuple(ends) if isinstance(ends, tuple | list) else ()
        if not (len(low_high) == 2 and all(map(is_number, low_high)) and ends[0] <= ends[1]):
            got, expected = repr(ends), "a smallest and a largest number"
            raise ParameterError(f"spread of {name}", got, expected)
        part, value, declared = _parameter(loop, name)
        shape = np.shape(value)
        values = np.broadcast_to(np.array(low_high).reshape(2, *(1 for _ in shape)), (2, *shape))
        declared.check(part, values)


def draw(loop: Any, seed: int, paths: Words) -> dict[str, Array]:
    """Values of the numbers that differ, by name, each of shape (paths, ...).

    Args:
        loop: The closed loop.
        seed: Seed of the experiment.
        paths: Numbers of the paths.
    """
    drawn, first = {}, 0
    for name in sorted(loop.spread):
        low, high = loop.spread[name]
        _, value, declared = _parameter(loop, name)
        shape = np.shape(value)
        count = int(np.prod(shape))
        normals = normals_of_paths(seed, paths, SPREAD, first + count)[:, first:]
        values = low + (high - low) * normal_cdf(normals).reshape(len(paths), *shape)
        if declared.whole_steps:
            values = np.round(values / loop.step_length) * loop.step_length
        drawn[name], first = values, first + count
    return drawn


def _parameter(loop: Any, name: str) -> tuple[Any, Any, Parameter]:
    """The part that declares a parameter, its value there, and its declaration.

    Raises:
        UnknownNameError: If there is none.
    """
    *words, last = name.split(".")
    part = loop
    for word in words:
        part = fields_of(part).get(word)
    if last not in parameters_of(part):
        raise UnknownNameError("spread of", name, tuple(_names(loop)))
    return part, getattr(part, last), parameters_of(part)[last]


def _names(part: Any, above: str = "") -> list[str]:
    """Dotted names of the parameters of a part and of the parts in it, but for the robots."""
    names = [f"{above}{name}" for name in parameters_of(part)]
    for name, inside in fields_of(part).items():
        if not hasattr(inside, "mass_matrix"):
            names += _names(inside, f"{above}{name}.")
    return names
