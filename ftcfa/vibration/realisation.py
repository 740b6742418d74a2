"""Realisations of an excitation: the numbers that shake a loop."""

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import counting, natural, positive
from ftcfa.errors import ParameterError
from ftcfa.streams import INITIAL_STATE, PLANT_NOISE, first_rows, standard_normals
from ftcfa.vibration.excitation import Excitation, Process

CHUNK = 4096
"""Number of steps whose noise is drawn at once."""


def realise(
    excitation: Excitation,
    channels: int,
    duration: float,
    step: float,
    *,
    seed: int = 0,
    path: int = 0,
) -> Array:
    """Mean of xi over each integration step of a path.

        Y_k/h,   Y_k = integral of xi from k h to (k + 1) h

    `simulate` uses exactly these numbers, times the vibration's ``level``, for path ``path`` of
    seed ``seed`` of a loop with this excitation and step.

    Args:
        excitation: The excitation.
        channels: m, the number of channels of the noise input.
        duration: Simulated time, rounded to whole steps [s].
        step: h, the period of a loop divided by its substeps [s].
        seed: Seed of the experiment, 0 <= seed < 2^64.
        path: Number of the path, 0 <= path < 2^64.

    Returns:
        Shape (steps, m) [unit of xi].

    Raises:
        ShapeError: If the excitation has another number of channels.
        ParameterError: If ``excitation`` is none, another argument is out of range, or the step is
            too long for the excitation.
    """
    if not hasattr(excitation, "process"):
        expected = "an excitation, such as ShapedNoise(...)"
        raise ParameterError("realise excitation", repr(excitation), expected)
    counting("channels", channels)
    positive("duration", duration, "s")
    positive("step", step, "s")
    seed, path = natural("seed", seed), natural("path", path)
    process = excitation.process(channels, step)
    state = process.init(initial_normals(process, seed, path))
    integrals = np.empty((round(duration / step), channels))
    for start in range(0, len(integrals), CHUNK):
        steps = range(start, min(start + CHUNK, len(integrals)))
        for k, normals, row in zip(steps, *noise_of_steps(process, steps, seed, path), strict=True):
            integrals[k], state = process.advance(state, normals, row)
    return integrals / step


def initial_normals(process: Process, seed: int, path: int) -> Array:
    """Standard normal deviates of a path's initial state, shape (process.initial_normals,)."""
    return standard_normals(seed, path, INITIAL_STATE, range(1), process.initial_normals)[0]


def noise_of_steps(process: Process, steps: range, seed: int, path: int) -> tuple[Array, Array]:
    """Deviates and rows that drive a process over consecutive integration steps of a path.

    Returns:
        Standard normal deviates, shape (len(steps), process.normals), and the rows of the
        process, shape (len(steps), columns).
    """
    normals = standard_normals(seed, path, PLANT_NOISE, steps, process.normals)
    start = 0
    if process.random_start:
        start = first_rows(seed, np.array([path], dtype=np.uint64), len(process.rows))[0]
    rows = process.rows[(start + np.arange(steps.start, steps.stop)) % len(process.rows)]
    return normals, rows
