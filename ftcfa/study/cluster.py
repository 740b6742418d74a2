"""Chunks of an ensemble on a cluster of `dask.distributed` workers."""

import json
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import islice
from pathlib import Path
from threading import get_ident
from typing import Any

import xarray as xr

from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.describe import describe, document, self_contained
from ftcfa.loop.rebuild import rebuild
from ftcfa.study.chunk import Plan, run_chunk

AHEAD = 3
"""Chunks that a thread of the cluster has waiting."""


def run_on_cluster(
    client: Any, loop: ClosedLoop, plan: Plan, chunks: Iterable[int], paths: int
) -> Iterator[tuple[int, xr.Dataset]]:
    """Have chunks run by the workers of a cluster; they come as they are done.

    The loop travels as its description, URDF text and all. A chunk whose worker dies is run by
    another.

    Args:
        client: A `dask.distributed.Client`.
        loop: The closed loop, made of parts of this package.
        plan: How it is run.
        chunks: Numbers of the chunks to run.
        paths: Number of paths of the ensemble.

    Raises:
        ParameterError: If the loop holds a part of a user's own, which cannot be described.
    """
    from distributed import as_completed

    text = json.dumps(self_contained(document(loop)))
    told = json.dumps(describe(plan))
    queue, numbers, pending = iter(chunks), {}, as_completed()

    def submit(number: int) -> None:
        future = client.submit(_run_there, text, told, number, paths, pure=False)
        numbers[future] = number
        pending.add(future)

    for number in islice(queue, AHEAD * max(1, sum(client.ncores().values()))):
        submit(number)
    try:
        for future in pending:
            yield numbers.pop(future), future.result()
            for number in islice(queue, 1):
                submit(number)
    finally:
        client.cancel(list(numbers))


def _run_there(text: str, told: str, number: int, paths: int) -> xr.Dataset:
    """A chunk, on the worker's one thread."""
    keywords = json.loads(told)
    keywords.pop("type")
    plan = Plan(**keywords)
    return run_chunk(_watched(text, plan, get_ident()), plan, plan.paths_of(number, paths), 1)


@lru_cache(maxsize=16)
def _watched(text: str, plan: Plan, thread: int) -> ClosedLoop:  # noqa: ARG001 (an Arm a thread)
    return plan.watched(rebuild(ClosedLoop, json.loads(text), "loop", Path()))
