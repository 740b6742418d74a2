"""The interpreted engine: the loop's own Python, step by step, on Pinocchio."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired, Signals
from ftcfa.engine.compiler.flatten import flat
from ftcfa.engine.paths import Paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.parameters import with_parameters
from ftcfa.loop.state import LoopState, bounded
from ftcfa.streams import standard_normals
from ftcfa.vibration.realisation import initial_normals, noise_of_steps

CHUNK = 4096
"""Number of samples whose noise is drawn at once."""


def run_interpreted(
    loop: ClosedLoop,
    samples: int,
    record_every: int,
    seed: int,
    paths: npt.NDArray[np.uint64],
    names: Sequence[str],
    varied: Mapping[str, Array],
) -> Paths:
    """Run paths one after the other.

    Args, returns: As for `ftcfa.engine.compiled.run_compiled`.
    """
    kept = -(-samples // record_every)
    shapes = loop.signal_shapes()
    record = {name: np.full((len(paths), kept, *shapes[name]), np.nan) for name in names}
    diverged_at = np.full(len(paths), np.nan)
    start = _start(loop, seed, 0)
    observed = np.full((len(paths), flat(start.observer).size), np.nan)
    for i, path in enumerate(paths):
        own = with_parameters(loop, {name: values[i] for name, values in varied.items()})
        rows = {name: record[name][i] for name in names}
        diverged_at[i], state = _run_path(own, samples, record_every, seed, int(path), rows)
        observed[i] = flat(state.observer)
    return Paths.of(record, diverged_at, observed, start.observer)


def _run_path(
    loop: ClosedLoop, samples: int, record_every: int, seed: int, path: int, rows: Signals
) -> tuple[float, LoopState]:
    """Fill the rows of one path.

    Returns:
        The time at which the path diverged [s], NaN if it did not, and its state at the end.
    """
    state = _start(loop, seed, path)
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, samples, CHUNK):
            ticks = range(start, min(start + CHUNK, samples))
            desired = loop.reference.at(np.arange(ticks.start, ticks.stop) * loop.period)
            noise, rows_of_noise = _noise(loop, ticks, seed, path)
            deviates = _deviates(loop, ticks, seed, path)
            for k, tick in enumerate(ticks):
                now = Desired(*(row[k] for row in desired))
                if not bounded(state):
                    return tick * loop.period, state
                signals, state = loop.step(state, now, noise[k], rows_of_noise[k], deviates[k])
                if tick % record_every == 0:
                    for name, row in rows.items():
                        row[tick // record_every] = signals[name]
    return np.nan, state


def _start(loop: ClosedLoop, seed: int, path: int) -> LoopState:
    """State of a path at the first sample."""
    desired = loop.first_desired
    return loop.init(desired, initial_normals(loop.process, seed, path))


def _noise(loop: ClosedLoop, ticks: range, seed: int, path: int) -> tuple[Array, Array]:
    """Standard normal deviates and rows of the process, shapes (ticks, substeps, ...)."""
    shape = (len(ticks), loop.substeps)
    steps = range(ticks.start * loop.substeps, ticks.stop * loop.substeps)
    normals, rows = noise_of_steps(loop.process, steps, seed, path)
    return normals.reshape(*shape, normals.shape[1]), rows.reshape(*shape, rows.shape[1])


def _deviates(loop: ClosedLoop, ticks: range, seed: int, path: int) -> Array:
    """Standard normal deviates of samples, shape (ticks, all of `ClosedLoop.streams`)."""
    streams = loop.streams.items()
    drawn = [standard_normals(seed, path, stream, ticks, count) for stream, count in streams]
    return np.concatenate([np.zeros((len(ticks), 0)), *drawn], axis=1)
