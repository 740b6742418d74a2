"""The interpreted engine: the loop's own Python functions, step by step, on Pinocchio."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired, Signals
from ftcfa.engine.parameters import with_parameter
from ftcfa.loop.closed_loop import ClosedLoop, LoopState, alive
from ftcfa.streams import INITIAL_STATE, PLANT_NOISE, first_rows, standard_normals

CHUNK = 4096
"""Samples whose noise is drawn at once."""


def run_interpreted(
    loop: ClosedLoop,
    samples: int,
    record_every: int,
    seed: int,
    paths: npt.NDArray[np.uint64],
    names: Sequence[str],
    varied: Mapping[str, Array],
) -> tuple[Signals, Array]:
    """Run paths one after the other.

    Args, returns: as of `ftcfa.engine.compiled.run_compiled`.
    """
    kept = -(-samples // record_every)
    shapes = loop.signal_shapes()
    record = {name: np.full((len(paths), kept, *shapes[name]), np.nan) for name in names}
    died = np.full(len(paths), np.nan)
    for i, path in enumerate(paths):
        own = loop
        for name, values in varied.items():
            own = with_parameter(own, name, values[i])
        rows = {name: record[name][i] for name in names}
        died[i] = _run_path(own, samples, record_every, seed, int(path), rows)
    return record, died


def _run_path(
    loop: ClosedLoop, samples: int, record_every: int, seed: int, path: int, rows: Signals
) -> float:
    """Fill the rows of one path; returns the time at which it diverged [s], NaN if it did not."""
    state = None
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, samples, CHUNK):
            ticks = range(start, min(start + CHUNK, samples))
            desired = loop.reference.at(np.arange(ticks.start, ticks.stop) * loop.period)
            noise, rows_of_noise = _noise(loop, ticks, seed, path)
            for k, tick in enumerate(ticks):
                now = Desired(*(row[k] for row in desired))
                state = _initial(loop, now, seed, path) if state is None else state
                if not alive(state):
                    return tick * loop.period
                signals, state = loop.step(state, now, noise[k], rows_of_noise[k])
                if tick % record_every == 0:
                    for name, row in rows.items():
                        row[tick // record_every] = signals[name]
    return np.nan


def _initial(loop: ClosedLoop, desired: Desired, seed: int, path: int) -> LoopState:
    count = loop.process.initial_normals
    return loop.init(desired, standard_normals(seed, path, INITIAL_STATE, range(1), count)[0])


def _noise(loop: ClosedLoop, ticks: range, seed: int, path: int) -> tuple[Array, Array]:
    """Standard normal deviates and rows of the process, shapes (ticks, substeps, ...)."""
    process, shape = loop.process, (len(ticks), loop.substeps)
    steps = range(ticks.start * loop.substeps, ticks.stop * loop.substeps)
    normals = standard_normals(seed, path, PLANT_NOISE, steps, process.normals)
    start = 0
    if process.random_start:
        start = first_rows(seed, np.array([path], dtype=np.uint64), len(process.rows))[0]
    rows = process.rows[(start + np.arange(steps.start, steps.stop)) % len(process.rows)]
    return normals.reshape(*shape, process.normals), rows.reshape(*shape, rows.shape[1])
