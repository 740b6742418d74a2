"""Threefry against its published answers; the normals against statistics and plain integers."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from ftcfa.streams import first_rows, normals_of_paths, standard_normals, threefry2x64

DRAWS = 200_000
SIGMAS = 5.0
"""Statistical bounds lie at 5 standard errors: a right generator fails one in 1.7 million."""
KS_SIGNIFICANCE = 1e-4
"""A right generator fails a Kolmogorov-Smirnov test one time in 10,000."""
ROUNDING = 1e-14
"""Two evaluations of the same logarithm, cosine and sine differ by some units of 2e-16."""
LARGEST = 2**64 - 1

ALL_ONES = 0xFFFFFFFFFFFFFFFF
KNOWN_ANSWERS = [  # counter, key, answer: threefry2x64 with 20 rounds in Random123's kat_vectors
    ((0, 0), (0, 0), (0xC2B6E3A8C2C69865, 0x6F81ED42F350084D)),
    ((ALL_ONES, ALL_ONES), (ALL_ONES, ALL_ONES), (0xE02CB7C4D95D277A, 0xD06633D0893B8B68)),
    (
        (0x243F6A8885A308D3, 0x13198A2E03707344),
        (0xA4093822299F31D0, 0x082EFA98EC4E6C89),
        (0x263C7D30BB0F0AF1, 0x56BE8361D3311526),
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN_ANSWERS)
def test_threefry_gives_the_published_answers(counter, key, answer):
    words = tuple(np.array([word], dtype=np.uint64) for word in counter)
    x, y = threefry2x64(words, key)
    assert (int(x[0]), int(y[0])) == answer


def threefry_of_integers(counter, key):
    """The cipher on Python's unbounded integers, from the description in the SC 2011 paper."""
    mask = LARGEST
    rotations = [16, 42, 12, 31, 16, 32, 24, 21]
    keys = [key[0], key[1], 0x1BD11BDAA9FC1A22 ^ key[0] ^ key[1]]
    x, y = (counter[0] + keys[0]) & mask, (counter[1] + keys[1]) & mask
    for group in range(5):
        for r in range(4):
            rotation = rotations[(4 * group + r) % 8]
            x = (x + y) & mask
            y = ((y << rotation) | (y >> (64 - rotation))) & mask
            y ^= x
        x = (x + keys[(group + 1) % 3]) & mask
        y = (y + keys[(group + 2) % 3] + group + 1) & mask
    return x, y


words = st.integers(0, LARGEST)


@given(
    step=st.integers(0, 2**40),
    pair=st.integers(0, 5),
    of_the_pair=st.integers(1, 2),
    seed=words,
    path=words,
    stream=st.integers(0, 2**32 - 1),
)
def test_normals_are_the_box_muller_transform_of_the_cipher(
    step, pair, of_the_pair, seed, path, stream
):
    a, b = threefry_of_integers((step, stream * 2**32 + pair), (seed, path))
    radius = math.sqrt(-2.0 * math.log(1.0 - (a >> 12) / 2**52))
    angle = 2.0 * math.pi * (b >> 12) / 2**52
    expected = [radius * math.cos(angle), radius * math.sin(angle)][:of_the_pair]
    channels = 2 * pair + of_the_pair
    got = standard_normals(seed, path, stream, range(step, step + 1), channels)[0, 2 * pair :]
    np.testing.assert_allclose(got, expected, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("channels", [1, 2, 3])
def test_moments_are_those_of_the_standard_normal(channels):
    x = standard_normals(7, 3, 0, range(DRAWS), channels)
    assert x.shape == (DRAWS, channels)
    for moment, expected, variance in [(1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)]:
        error = np.abs(np.mean(x**moment, axis=0) - expected)
        assert np.all(error < SIGMAS * math.sqrt(variance / DRAWS)), moment


@pytest.mark.parametrize(
    ("seed", "path", "stream"), [(0, 0, 0), (1, 0, 0), (0, 1, 1), (LARGEST, LARGEST, 2**32 - 1)]
)
def test_distribution_is_normal(seed, path, stream):
    x = standard_normals(seed, path, stream, range(DRAWS), 2)
    for channel in x.T:
        assert stats.kstest(channel, "norm").pvalue > KS_SIGNIFICANCE


def test_tails_reach_as_far_as_they_should():
    x = standard_normals(11, 0, 0, range(DRAWS), 2).ravel()
    beyond = 3.5
    probability = 2.0 * stats.norm.sf(beyond)
    count = np.count_nonzero(np.abs(x) > beyond)
    assert abs(count - probability * x.size) < SIGMAS * math.sqrt(probability * x.size)


def correlations_of(columns):
    """Correlations of all pairs of columns and of their squares."""
    n = columns.shape[1]
    pairs = np.triu_indices(n, 1)
    return np.concatenate([np.corrcoef(columns.T)[pairs], np.corrcoef(columns.T**2)[pairs]])


def stacked(what):
    """Columns that differ in one thing alone."""
    steps = range(DRAWS)
    match what:
        case "channels":
            return standard_normals(5, 0, 0, steps, 5)
        case "paths":
            paths = (0, 1, 2, 2**32, LARGEST)
            return np.hstack([standard_normals(5, path, 0, steps, 1) for path in paths])
        case "seeds":
            seeds = (0, 1, 2, 2**32, LARGEST)
            return np.hstack([standard_normals(seed, 0, 0, steps, 1) for seed in seeds])
        case "streams":
            return np.hstack([standard_normals(5, 0, stream, steps, 1) for stream in range(5)])
        case "steps":
            x = standard_normals(5, 0, 0, range(DRAWS + 4), 1)
            return np.hstack([x[lag : lag + DRAWS] for lag in range(5)])


@pytest.mark.parametrize("what", ["channels", "paths", "seeds", "streams", "steps"])
def test_numbers_are_independent_across(what):
    r = correlations_of(stacked(what))
    assert np.max(np.abs(r)) < SIGMAS / math.sqrt(DRAWS)


@given(
    cuts=st.lists(st.integers(0, 300), max_size=6),
    channels=st.integers(0, 5),
    start=st.integers(0, 10_000),
)
def test_any_split_of_the_steps_gives_the_same_numbers(cuts, channels, start):
    whole = standard_normals(3, 8, 1, range(start, start + 300), channels)
    edges = [0, *sorted(cuts), 300]
    parts = [
        standard_normals(3, 8, 1, range(start + a, start + b), channels) for a, b in pairwise(edges)
    ]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_no_channels_give_an_empty_row_a_step():
    assert standard_normals(0, 0, 0, range(5), 0).shape == (5, 0)


@pytest.mark.parametrize("seed", [2**32, 2**63, LARGEST])
def test_every_bit_of_a_large_seed_counts(seed):
    steps = range(100)
    large = standard_normals(seed, 0, 0, steps, 2)
    assert np.all(np.isfinite(large))
    for other in (seed - 1, seed % 2**32, seed % 2**63):
        if other != seed:
            assert not np.any(large == standard_normals(other, 0, 0, steps, 2))


def test_seed_and_path_are_not_interchangeable():
    steps = range(100)
    assert not np.any(standard_normals(1, 2, 0, steps, 2) == standard_normals(2, 1, 0, steps, 2))


@pytest.mark.parametrize("seed", [0, 2**40, LARGEST])
@pytest.mark.parametrize("channels", [0, 1, 2, 5])
def test_many_paths_at_once_have_the_numbers_of_each(seed, channels):
    paths = np.array([0, 1, 7, 2**40, 2**63, LARGEST], dtype=np.uint64)
    together = normals_of_paths(seed, paths, 3, channels)
    assert together.shape == (len(paths), channels)
    for path, row in zip(paths, together, strict=True):
        alone = standard_normals(seed, int(path), 3, range(1), channels)[0]
        np.testing.assert_array_equal(row, alone)


def test_first_rows_are_words_of_the_cipher():
    paths, rows = np.array([0, 5, 2**63, LARGEST], dtype=np.uint64), 1000
    words = [threefry_of_integers((0, 2 * 2**32), (9, int(path)))[0] for path in paths]
    np.testing.assert_array_equal(first_rows(9, paths, rows), [word % rows for word in words])
