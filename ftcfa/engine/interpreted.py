"""The interpreted engine: the loop's own Python functions, step by step, on Pinocchio."""

from collections.abc import Sequence

import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired, Signals
from ftcfa.loop.closed_loop import ClosedLoop, alive
from ftcfa.vibration.streams import PLANT_NOISE, standard_normals

CHUNK = 4096
"""Samples whose noise is drawn at once."""


def run_interpreted(
    loop: ClosedLoop, samples: int, record_every: int, seed: int, path: int, names: Sequence[str]
) -> tuple[Signals, float]:
    """Run one path.

    Args:
        loop: The closed loop.
        samples: Number of samples; the first is at time zero.
        record_every: Keep every so many samples.
        seed: Seed of the experiment.
        path: Number of the path.
        names: Signals to keep.

    Returns:
        The signals over the kept samples, each of shape (kept, ...), NaN from divergence on; and
        the time of divergence [s], NaN if there was none.
    """
    kept = -(-samples // record_every)
    shapes = loop.signal_shapes()
    recorded = {name: np.full((kept, *shapes[name]), np.nan) for name in names}
    state = None
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, samples, CHUNK):
            ticks = range(start, min(start + CHUNK, samples))
            desired = loop.reference.at(np.arange(ticks.start, ticks.stop) * loop.period)
            noise = _noise(loop, ticks, seed, path)
            for k, tick in enumerate(ticks):
                now = Desired(*(row[k] for row in desired))
                state = loop.init(now) if state is None else state
                if not alive(state):
                    return recorded, tick * loop.period
                signals, state = loop.step(state, now, noise[k])
                if tick % record_every == 0:
                    for name in names:
                        recorded[name][tick // record_every] = signals[name]
    return recorded, np.nan


def _noise(loop: ClosedLoop, ticks: range, seed: int, path: int) -> Array:
    """Standard normal deviates, shape (ticks, substeps, channels)."""
    steps = range(ticks.start * loop.substeps, ticks.stop * loop.substeps)
    normals = standard_normals(seed, path, PLANT_NOISE, steps, loop.channels)
    return normals.reshape(len(ticks), loop.substeps, loop.channels)
