"""States, which are nested tuples of arrays, as flat lists of arrays and back."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ftcfa.arrays import Array, Traceable


def leaves(tree: Any) -> list[Traceable]:
    """Arrays of nested tuples, from left to right; None stands for no array."""
    if isinstance(tree, tuple):
        return [leaf for branch in tree for leaf in leaves(branch)]
    return [] if tree is None else [tree]


def like(template: Any, arrays: Iterator[Traceable]) -> Any:
    """Nested tuples of the template's structure that hold other arrays."""
    if isinstance(template, tuple):
        branches = [like(branch, arrays) for branch in template]
        named = hasattr(template, "_fields")
        return type(template)(*branches) if named else tuple(branches)
    return None if template is None else next(arrays)


def flat(tree: Any) -> Array:
    """All numbers of nested tuples in one vector, each array row by row."""
    rows = [np.ravel(np.asarray(leaf, dtype=float)) for leaf in leaves(tree)]
    return np.concatenate([*rows, np.zeros(0)])


def split(rows: Array, shapes: Iterable[tuple[int, ...]]) -> list[Array]:
    """Arrays, each of shape (..., *shape), whose entries are the last axis of rows; views of it."""
    arrays, start = [], 0
    for shape in shapes:
        end = start + math.prod(shape)
        arrays.append(rows[..., start:end].reshape((*rows.shape[:-1], *shape)))
        start = end
    return arrays


def size(array: Traceable) -> int:
    """Number of entries of an array."""
    return int(np.prod(np.shape(array)))
