"""States as flat lists of arrays and back: nested tuples in, leaves out."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ftcfa.arrays import Array


def leaves(tree: Any) -> list[Array]:
    """The arrays of nested tuples, left to right; None holds none."""
    if isinstance(tree, tuple):
        return [leaf for branch in tree for leaf in leaves(branch)]
    return [] if tree is None else [tree]


def like(template: Any, arrays: Iterator[Array]) -> Any:
    """The nested tuples of a template with other leaves."""
    if isinstance(template, tuple):
        branches = [like(branch, arrays) for branch in template]
        named = hasattr(template, "_fields")
        return type(template)(*branches) if named else tuple(branches)
    return None if template is None else next(arrays)


def flat(tree: Any) -> Array:
    """All numbers of nested tuples, row by row, in one vector."""
    rows = [np.ravel(np.asarray(leaf, dtype=float)) for leaf in leaves(tree)]
    return np.concatenate([*rows, np.zeros(0)])


def size(array: Array) -> int:
    """Number of entries."""
    return int(np.prod(np.shape(array)))
