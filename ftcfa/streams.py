"""Random numbers of a path: normal deviates as a function of (seed, path, stream, step).

A counter-based generator has no state: the deviates of step k of path i depend on
(seed, i, stream, k) alone, so they are the same alone or among a million paths, on one thread or
fifty workers, interpreted or compiled. The cipher is Threefry-2x64 with 20 rounds (Salmon,
Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3, SC 2011).
"""

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.portable import log, sin_cos

Words = npt.NDArray[np.uint64]

ROTATIONS = (16, 42, 12, 31, 16, 32, 24, 21)
PARITY = 0x1BD11BDAA9FC1A22
ROUNDS = 20
MANTISSA_SHIFT = 12
ONE = 0x3FF0000000000000
"""Bit pattern of 1.0; with 52 random mantissa bits it is a uniform number in [1, 2)."""

PLANT_NOISE = 0
INITIAL_STATE = 1
FIRST_ROW = 2
ROBOT = 3
SENSOR_NOISE = 4
ACTUATOR_NOISE = 5
ACCELEROMETER_NOISE = 6
SPREAD = 7
"""Numbers of the streams, one for each use of random numbers."""


def threefry2x64(counter: tuple[Words, Words], key: tuple[int, int | Words]) -> tuple[Words, Words]:
    """Encrypt counters: two 64-bit words each, under a key of two words or one key each."""
    k = [np.asarray(word, dtype=np.uint64) for word in key]
    keys = (k[0], k[1], np.uint64(PARITY) ^ k[0] ^ k[1])
    with np.errstate(over="ignore"):
        x, y = counter[0] + keys[0], counter[1] + keys[1]
        for r in range(ROUNDS):
            bits = np.uint64(ROTATIONS[r % 8])
            x = x + y
            y = ((y << bits) | (y >> (np.uint64(64) - bits))) ^ x
            if r % 4 == 3:
                injection = r // 4 + 1
                x = x + keys[injection % 3]
                y = y + (keys[(injection + 1) % 3] + np.uint64(injection))
    return x, y


def standard_normals(seed: int, path: int, stream: int, steps: range, channels: int) -> Array:
    """Independent standard normal deviates of one path, by Box and Muller.

        a, b = threefry((step, stream 2^32 + pair), (seed, path))
        r = sqrt(-2 log u),  normals = r cos(2 pi w), r sin(2 pi w),  u in (0, 1], w in [0, 1)

    Args:
        seed: Seed of the experiment, 0 <= seed < 2^64.
        path: Number of the path, 0 <= path < 2^64.
        stream: Number of the stream, such as PLANT_NOISE, 0 <= stream < 2^32.
        steps: Consecutive step numbers.
        channels: Number of deviates a step.

    Returns:
        Shape (len(steps), channels).
    """
    step = np.arange(steps.start, steps.stop, dtype=np.uint64)[:, None]
    return _normals(seed, path, stream, step, channels)


def normals_of_paths(seed: int, paths: Words, stream: int, channels: int) -> Array:
    """The `standard_normals` of step 0 of many paths, shape (paths, channels)."""
    step = np.zeros((len(paths), 1), dtype=np.uint64)
    return _normals(seed, paths[:, None], stream, step, channels)


def _normals(seed: int, path: int | Words, stream: int, step: Words, channels: int) -> Array:
    """A row of deviates for each of the steps, shape (rows, 1), of one path or one path a row."""
    pairs = (channels + 1) // 2
    pair = (np.uint64(stream) << np.uint64(32)) + np.arange(pairs, dtype=np.uint64)[None, :]
    a, b = threefry2x64((step, pair), (seed, path))
    u = 2.0 - _in_one_two(a)
    angle = 2.0 * np.pi * (_in_one_two(b) - 1.0)
    radius = np.sqrt(-2.0 * log(u))
    sine, cosine = sin_cos(angle)
    normals = np.stack([radius * cosine, radius * sine], axis=-1)
    return normals.reshape(len(step), 2 * pairs)[:, :channels]


def first_rows(seed: int, paths: Words, rows: int) -> npt.NDArray[np.int64]:
    """Row of a table at which each path begins, uniform on 0 ... rows - 1, shape (paths,)."""
    zero = np.zeros(len(paths), dtype=np.uint64)
    words, _ = threefry2x64((zero, zero + np.uint64(FIRST_ROW << 32)), (seed, paths))
    return (words % np.uint64(rows)).astype(np.int64)


def _in_one_two(words: Words) -> Array:
    """A float in [1, 2) from 52 bits of each word."""
    bits = (words >> np.uint64(MANTISSA_SHIFT)) | np.uint64(ONE)
    return bits.view(np.float64)
