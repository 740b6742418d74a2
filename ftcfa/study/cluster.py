"""Chunks of an ensemble on a cluster of `dask.distributed` workers."""

import json
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from typing import Any

import xarray as xr

from ftcfa.description.read import rebuild
from ftcfa.description.write import describe, document, self_contained
from ftcfa.errors import FtcfaError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.study.chunk import Plan, run_chunk

AHEAD = 3
"""Chunks that a thread of the cluster has waiting."""


def run_on_cluster(
    client: Any, loop: ClosedLoop, plan: Plan, chunks: Iterable[int], paths: int
) -> Iterator[tuple[int, xr.Dataset]]:
    """Have chunks run by the workers of a cluster; they come as they are done.

    The loop travels as its description, URDF text and all. A chunk whose worker dies is run by
    another; workers may come and go.

    Args:
        client: A `dask.distributed.Client`.
        loop: The closed loop, made of parts of this package.
        plan: How it is run.
        chunks: Numbers of the chunks to run.
        paths: Number of paths of the ensemble.

    Raises:
        ParameterError: If the loop holds a part of a user's own, which cannot be described.
        FtcfaError: If a worker has another ftcfa or none, or the cluster breaks down.
    """
    from distributed import as_completed

    text = json.dumps(self_contained(document(loop)))
    told = json.dumps(describe(plan))
    _check_workers(client)
    queue, numbers, pending = iter(chunks), dict[Any, int](), as_completed(loop=client.loop)

    def submit() -> None:
        threads = max(1, sum(client.ncores().values()))
        for number in islice(queue, max(0, AHEAD * threads - len(numbers))):
            future = client.submit(_run_there, text, told, number, paths, pure=False)
            numbers[future] = number
            pending.add(future)

    try:
        with _unbroken():
            submit()
        for future in pending:
            number = numbers.pop(future)
            with _unbroken():
                part = future.result()
                submit()
            yield number, part
    finally:
        if client.status == "running":
            client.cancel(list(numbers))


def _check_workers(client: Any) -> None:
    """Refuse workers on which a loop would be another one."""

    def installed() -> str | None:  # inside, so that it travels whole to where no ftcfa is
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("ftcfa")
        except PackageNotFoundError:
            return None

    own = version("ftcfa")
    for worker, found in client.run(installed).items():
        if found != own:
            raise FtcfaError(
                f"worker {worker}",
                "no ftcfa" if found is None else f"ftcfa {found}",
                f"ftcfa {own} as here",
                "install the same version for every worker",
            )


@contextmanager
def _unbroken() -> Iterator[None]:
    """One sentence for a cluster that breaks down."""
    from distributed import CancelledError, KilledWorker
    from distributed.comm import CommClosedError

    try:
        yield
    except (CancelledError, KilledWorker, CommClosedError, ImportError, OSError) as error:
        raise FtcfaError(
            "cluster",
            f"broke down ({type(error).__name__})",
            "",
            "mend it and run again; with a store the run goes on where it was",
        ) from error


def _run_there(text: str, told: str, number: int, paths: int) -> xr.Dataset:
    """A chunk, on one thread of the worker."""
    keywords = json.loads(told)
    keywords.pop("type")
    plan = Plan(**keywords)
    return run_chunk(_watched(text, plan), plan, plan.paths_of(number, paths), 1)


_here = threading.local()


def _watched(text: str, plan: Plan) -> ClosedLoop:
    """The loop of this thread: an Arm is no thing to share."""
    if getattr(_here, "told", None) != (text, plan):
        _here.loop = plan.watched(rebuild(ClosedLoop, json.loads(text), "loop", Path()))
        _here.told = text, plan
    return _here.loop
