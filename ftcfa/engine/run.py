"""Runs of many paths by either engine, each with its own robot where robots are uncertain."""

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import is_integer, natural, not_negative
from ftcfa.engine.compiled import run_compiled
from ftcfa.engine.interpreted import run_interpreted
from ftcfa.engine.paths import Paths
from ftcfa.errors import ParameterError, TracingError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.parameters import checked_values
from ftcfa.loop.spread import draw
from ftcfa.model.arm import Arm
from ftcfa.streams import Words

Engine = Literal["compiled", "interpreted"]
MOST_STEPS = 1e15
"""Largest number of integration steps of a call."""
FEWER = "raise record_every, or run fewer paths at a time"
"""What makes a result smaller."""


class Run(NamedTuple):
    """Paths, what varied among them, and the engine that ran them."""

    paths: Paths
    varied: dict[str, Array]
    """Parameters that differed from path to path, by dotted name, each of shape (paths, ...)."""
    engine: Engine


def run_paths(
    loop: ClosedLoop,
    samples: int,
    record_every: int,
    seed: int,
    paths: Words,
    names: Sequence[str],
    vary: Mapping[str, npt.ArrayLike],
    threads: int | None = None,
    engine: Engine = "compiled",
) -> Run:
    """Run many paths, each with the robot that the loop's uncertainty draws for it.

    A law that cannot be compiled runs interpreted, with a warning that says why.

    Args: As for `ftcfa.engine.compiled.run_compiled`; ``vary`` is unchecked.
    """
    check_work(loop, len(paths), samples)
    varied = checked_values(loop, {**vary, **_robots(loop, vary, seed, paths)}, len(paths))
    arguments = (loop, samples, record_every, seed, paths, names, varied)
    if engine == "compiled":
        try:
            return Run(run_compiled(*arguments, threads), varied, engine)
        except TracingError as error:
            warnings.warn(f"running interpreted, which is far slower: {error}", stacklevel=4)
    return Run(run_interpreted(*arguments), varied, "interpreted")


def _robots(
    loop: ClosedLoop, vary: Mapping[str, npt.ArrayLike], seed: int, paths: Words
) -> dict[str, Array]:
    """Parameters that the loop draws for each path, by dotted name; none if all are certain."""
    drawn = draw(loop, seed, paths)
    if loop.uncertainty is not None:
        robots = loop.uncertainty.draw(cast(Arm, loop.arm), seed, paths)
        drawn |= {f"arm.{name}": values for name, values in robots.items()}
    for name in drawn.keys() & vary.keys():
        got, expected = "drawn for every path", "one source of each path's value"
        remedy = "leave it out, or take a loop without uncertainty or spread"
        raise ParameterError(f"varied {name}", got, expected, remedy)
    return drawn


def path_numbers(paths: Any) -> Words:
    """Path numbers 0, 1, ... for a number of paths, or the given path numbers."""
    if is_integer(paths) and paths >= 0:
        return np.arange(int(paths), dtype=np.uint64)
    if isinstance(paths, Iterable) and not isinstance(paths, str):
        return np.array([natural("path", path) for path in paths], dtype=np.uint64)
    raise ParameterError("paths", repr(paths), "a number of paths, or path numbers")


def samples_of(loop: ClosedLoop, duration: float) -> int:
    """Number of samples of a run, at 0, period, ... up to and including the duration [s]."""
    not_negative("duration", duration, "s")
    loop.interface.check_duration(duration)
    samples = round(duration / loop.period) + 1
    remedy = "take a shorter duration or a longer period"
    check_memory("reference at every sample", 8 * 3 * loop.arm.n * samples, remedy)
    return samples


def check_work(loop: ClosedLoop, paths: int, samples: int) -> None:
    """Raise ParameterError if paths take more integration steps than MOST_STEPS."""
    steps = paths * samples * loop.substeps
    if steps > MOST_STEPS:
        got = f"{steps:.3g} integration steps"
        expected = f"at most {MOST_STEPS:.0e}, a year of a fast machine"
        remedy = "take fewer paths, a shorter duration, a longer period or fewer substeps"
        raise ParameterError("paths, duration and substeps together", got, expected, remedy)


def check_memory(subject: str, needed: int, remedy: str = FEWER) -> None:
    """Raise ParameterError if a result of some bytes needs more than half of the memory."""
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > present / 2:
        expected = f"at most half of the machine's {present / 2**30:.1f} GiB"
        raise ParameterError(subject, f"{needed / 2**30:.1f} GiB", expected, remedy)
