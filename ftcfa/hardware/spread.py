"""Numbers of the hardware that differ from path to path: a sensor's offset, a delay, a limit."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import is_number
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.parts import fields_of, parameters_of
from ftcfa.portable import normal_cdf
from ftcfa.streams import HARDWARE_SPREAD, Words, normals_of_paths

Spread = Mapping[str, tuple[float, float]]
"""Smallest and largest value of numbers, by their names in `Hardware`, such as
``sensors.latency``."""


def check_spread(hardware: Any, spread: Spread) -> None:
    """Raise an FtcfaError unless every name is that of a parameter, and its values are right."""
    for name, ends in spread.items():
        low_high = tuple(ends)
        if not (len(low_high) == 2 and all(map(is_number, low_high)) and ends[0] <= ends[1]):
            got, expected = repr(ends), "a smallest and a largest number"
            raise ParameterError(f"Hardware spread of {name}", got, expected, field="spread")
        part, word = _holder(hardware, name)
        shape = np.shape(getattr(part, word))
        values = np.broadcast_to(np.array(low_high).reshape(2, *(1 for _ in shape)), (2, *shape))
        parameters_of(part)[word].check(part, values)


def draw(hardware: Any, seed: int, paths: Words, step: float) -> dict[str, Array]:
    """Values of the numbers that differ, uniform and independent, for each path.

    Args:
        hardware: The hardware.
        seed: Seed of the experiment.
        paths: Numbers of the paths.
        step: Integration step; times are rounded to whole ones [s].

    Returns:
        By name, each of shape (paths, ...).
    """
    drawn, first = {}, 0
    for name in sorted(hardware.spread):
        low, high = hardware.spread[name]
        part, word = _holder(hardware, name)
        shape = np.shape(getattr(part, word))
        count = int(np.prod(shape))
        normals = normals_of_paths(seed, paths, HARDWARE_SPREAD, first + count)[:, first:]
        values = low + (high - low) * normal_cdf(normals).reshape(len(paths), *shape)
        if parameters_of(part)[word].whole_steps:
            values = np.round(values / step) * step
        drawn[name], first = values, first + count
    return drawn


def _holder(hardware: Any, name: str) -> tuple[Any, str]:
    """The part that declares a parameter, and its name there; UnknownNameError if there is none."""
    *words, last = name.split(".")
    part = hardware
    for word in words:
        part = fields_of(part).get(word)
    if last not in parameters_of(part):
        known = [
            f"{group}.{word}"
            for group in ("sensors", "actuators", "accelerometer")
            for word in parameters_of(getattr(hardware, group))
        ]
        raise UnknownNameError("Hardware spread of", name, known, field="spread")
    return part, last
