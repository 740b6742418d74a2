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
from ftcfa.description.write import document
from ftcfa.errors import FtcfaError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.study.chunk import run_chunk
from ftcfa.study.plan import Plan
from ftcfa.study.probe import probe

AHEAD = 3
"""Number of chunks that wait or run for each thread of the cluster."""


def run_on_cluster(
    client: Any, loop: ClosedLoop, plan: Plan, chunks: Iterable[int], paths: int
) -> Iterator[tuple[int, xr.Dataset]]:
    """Have the workers of a cluster run chunks; yields number and Dataset of each as it is done.

    The loop travels as its description, which holds the text of its URDF. A chunk whose worker is
    lost is run by another one; workers may come and go.

    Args:
        client: A `dask.distributed.Client`.
        loop: The closed loop, made of parts of this package.
        plan: How the paths are run.
        chunks: Numbers of the chunks to run.
        paths: Number of paths of the ensemble.

    Raises:
        ParameterError: If the loop has a user's own part, which cannot be described.
        FtcfaError: If a worker has another version of ftcfa or none, or computes other bits, or
            the cluster breaks down.
    """
    from distributed import as_completed

    loop_text = json.dumps(document(loop))
    _check_versions(client)
    _check_bits(client, loop, loop_text, plan)
    queue, numbers, pending = iter(chunks), dict[Any, int](), as_completed(loop=client.loop)

    def submit() -> None:
        threads = max(1, sum(client.ncores().values()))
        for number in islice(queue, max(0, AHEAD * threads - len(numbers))):
            future = client.submit(_run_on_worker, loop_text, plan, number, paths, pure=False)
            numbers[future] = number
            pending.add(future)

    try:
        with _cluster_errors():
            submit()
        for future in pending:
            number = numbers.pop(future)
            with _cluster_errors():
                part = future.result()
                submit()
            yield number, part
    finally:
        if client.status == "running":
            client.cancel(list(numbers))


def _check_versions(client: Any) -> None:
    """Raise FtcfaError unless every worker has the same version of ftcfa."""

    # nested, so that it is pickled by value: a worker may lack ftcfa
    def installed() -> str | None:
        from importlib.metadata import PackageNotFoundError, version

        try:
            return version("ftcfa")
        except PackageNotFoundError:
            return None

    own = version("ftcfa")
    for worker, other in client.run(installed).items():
        if other != own:
            got = "no ftcfa" if other is None else f"ftcfa {other}"
            remedy = "install the same version for every worker"
            raise FtcfaError(f"worker {worker}", got, f"ftcfa {own} as here", remedy)


def _check_bits(client: Any, loop: ClosedLoop, loop_text: str, plan: Plan) -> None:
    """Raise FtcfaError unless every worker computes the same bits as this process."""
    own = probe(plan.observed(loop), plan.seed)
    for worker, other in client.run(_probe_on_worker, loop_text, plan).items():
        if other != own:
            got = f"other last bits than here: probe {other}"
            remedy = "take workers alike: a number of the loop differs in its last places"
            raise FtcfaError(f"worker {worker}", got, f"probe {own}", remedy)


def _probe_on_worker(loop_text: str, plan: Plan) -> str:
    """The probe of a loop on a worker."""
    return probe(_loop_of_thread(loop_text, plan), plan.seed)


@contextmanager
def _cluster_errors() -> Iterator[None]:
    """Turn the errors of a cluster that breaks down into an FtcfaError."""
    from distributed import CancelledError, KilledWorker
    from distributed.comm import CommClosedError

    try:
        yield
    except (CancelledError, KilledWorker, CommClosedError, ImportError, OSError) as error:
        remedy = "repair it and run again; with a store the run goes on where it was"
        raise FtcfaError(
            "cluster", f"broke down ({type(error).__name__})", remedy=remedy
        ) from error


def _run_on_worker(loop_text: str, plan: Plan, number: int, paths: int) -> xr.Dataset:
    """Run a chunk on one thread of a worker."""
    loop = _loop_of_thread(loop_text, plan)
    return run_chunk(loop, plan, plan.paths_of(number, paths), 1)


_thread = threading.local()


def _loop_of_thread(text: str, plan: Plan) -> ClosedLoop:
    """The observed loop of this thread, kept for its next chunk; threads cannot share an Arm."""
    if getattr(_thread, "key", None) != (text, plan):
        _thread.loop = plan.observed(rebuild(ClosedLoop, json.loads(text), "loop", Path()))
        _thread.key = text, plan
    return _thread.loop
