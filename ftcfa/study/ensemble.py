"""`ensemble`: statistics over any number of paths, run in chunks and resumed from a store."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import asdict
from functools import partial
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.checks import counting, positive_numbers, probability, vector
from ftcfa.description.write import provenance
from ftcfa.engine.dataset import versions
from ftcfa.engine.run import check_memory, check_work, path_numbers, samples_of
from ftcfa.engine.simulate import simulate_paths
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.feasibility import warn_of_doubts
from ftcfa.statistics.estimate import CONFIDENCE
from ftcfa.statistics.quantile_sketch import BINS
from ftcfa.study.chunk import count_chunk, quantities, run_chunk, simulate_chunk
from ftcfa.study.cluster import run_on_cluster
from ftcfa.study.metrics.table import METRICS
from ftcfa.study.outcomes import VARIABLES
from ftcfa.study.plan import Plan
from ftcfa.study.probe import probe
from ftcfa.study.progress import Interrupted, Progress
from ftcfa.study.store import Store
from ftcfa.study.summary import QUANTILES, summarise
from ftcfa.study.tally import Tally

SAME = 1e-6
"""Relative tolerance of metrics that another processor computes again."""


def ensemble(
    loop: ClosedLoop,
    paths: int,
    duration: float,
    *,
    seed: int = 0,
    record_every: int = 0,
    tolerance: float = 0.05,
    after: float | None = None,
    lost: npt.ArrayLike | None = None,
    quantiles: Sequence[float] = QUANTILES,
    confidence: float = CONFIDENCE,
    trajectories: Iterable[int] = (),
    threads: int | None = None,
    chunk: int = 4096,
    client: Any = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Simulate many paths: statistics over time and metrics of each path, with intervals.

    Path i of a seed is that of `simulate`, so any path can be run again (`replay`).

    Args:
        loop: The closed loop.
        paths: Number of paths; they are numbered 0, 1, ...
        duration: Simulated time [s].
        seed: Seed of the experiment.
        record_every: Number of samples from one recorded time to the next; 0 records about 200
            times.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        after: Time from which errors count as late [s]; half of the duration by default.
        lost: Error beyond which a joint has lost track, one number or one for each joint [rad or
            m]; by default a quarter turn, and a tenth of the travel of prismatic joints.
        quantiles: Probabilities of the quantiles over time.
        confidence: Confidence of every interval.
        trajectories: Numbers of the paths whose whole trajectories are kept.
        threads: Number of threads; by default all that this process may use.
        chunk: Number of paths that are computed, stored and sent at once. Results of different
            chunks are equal to rounding, those of equal chunks bit for bit.
        client: A `dask.distributed.Client`, whose cluster runs the chunks instead of threads of
            this process. The loop travels as its description; a chunk whose worker is lost is run
            by another one.
        store: A folder for the chunks. The same call, or one with more paths, goes on from what it
            holds, on any machine that computes the same bits. One process writes to it at a time. A
            damaged chunk is run again, with a warning.
        progress: Called with the number of paths that are done and the number of all.

    Returns:
        A Dataset; see `ftcfa.study.summary.summarise`.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If an argument is out of range, or the store
            holds another experiment.
        FtcfaError: If the store cannot be written or another process writes to it, the cluster
            breaks down, or its workers have another version of ftcfa or compute other bits.
        Interrupted: At Ctrl-C between chunks. Its ``partial`` is the Dataset of the chunks that are
            done, or None if no chunk is.
    """
    counting("paths", paths)
    check_work(loop, paths, samples_of(loop, duration))
    probability("confidence", confidence)
    for p in quantiles:
        probability("quantile", p)
    if client is not None and threads is not None:
        remedy = "leave threads out: the workers of the cluster have their own"
        raise ParameterError("threads", "given together with client", "one of them", remedy)
    whole = path_numbers(trajectories)
    beyond = None if lost is None else _positive_for_joints(lost, loop.arm.n)
    plan = Plan(float(duration), seed, record_every, tolerance, chunk, after, beyond)
    times = len(plan.times(loop))
    check_memory("quantiles over time", 4 * BINS * times * quantities(loop.arm.n))
    check_memory("metrics of all paths", 8 * paths * len(METRICS) * loop.arm.n)
    check_memory("a chunk", 16 * min(chunk, paths) * times * quantities(loop.arm.n))
    warn_of_doubts(loop, duration)
    tally, interrupted = Tally(times, loop.arm.n), False
    with nullcontext() if store is None else Store(store, _identity(loop, plan)) as place:
        try:
            with _Bookkeeper(tally, place) as books:
                for _ in _run(books, loop, plan, paths, threads, client, place):
                    if progress is not None:
                        progress(tally.paths, paths)
        except KeyboardInterrupt:
            interrupted = True
        if interrupted and not tally.paths:
            raise Interrupted("ensemble")
        dataset = summarise(loop, plan, tally, quantiles, confidence)
        if len(whole):
            kept = simulate_paths(loop, whole.tolist(), duration, seed=seed, threads=threads)
            dataset = dataset.assign(_trajectories(kept))
        if place is not None:
            place.write_result(dataset)
    if interrupted:
        raise Interrupted("ensemble", dataset)
    return dataset


def _positive_for_joints(lost: npt.ArrayLike, n: int) -> tuple[float, ...]:
    """The error beyond which each of n joints has lost track, checked."""
    errors = vector("lost", lost, n)
    positive_numbers("lost", errors, "rad or m")
    return tuple(errors.tolist())


def _identity(loop: ClosedLoop, plan: Plan) -> dict[str, Any]:
    """What the stored numbers of an ensemble depend on."""
    return {
        "loop": provenance(loop),
        "plan": asdict(plan),
        "metrics": [*METRICS, *VARIABLES],
        **versions(),
        "probe": probe(plan.observed(loop), plan.seed),
    }


class _Bookkeeper:
    """A thread that counts, stores and adds up a chunk while the next one runs.

    Ctrl-C reaches the main thread only, so a chunk is added whole or not at all.
    """

    def __init__(self, tally: Tally, store: Store | None) -> None:
        self._tally = tally
        self._store = store
        self._pool = ThreadPoolExecutor(max_workers=1)
        self._pending: Future[None] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()

    def take(self, number: int, count: Callable[[], xr.Dataset], keep: bool) -> None:
        """Take over a chunk, which ``count`` returns, once the one before is done."""
        self.settle()
        self._pending = self._pool.submit(self._enter, number, count, keep)

    def settle(self) -> None:
        """Wait for the chunk that is being counted; raise its error, if any."""
        if self._pending is not None:
            self._pending.result()

    def _enter(self, number: int, count: Callable[[], xr.Dataset], keep: bool) -> None:
        part = count()
        if keep and self._store is not None:
            self._store.write(number, part)
        self._tally.add(number, part)


def _run(
    books: _Bookkeeper,
    loop: ClosedLoop,
    plan: Plan,
    paths: int,
    threads: int | None,
    client: Any,
    store: Store | None,
) -> Iterator[None]:
    """Have all chunks counted, first those in the store; yields whenever one is taken over."""
    observed, chunks = plan.observed(loop), plan.chunks(paths)
    taken, longer, checked = set[int](), set[int](), False
    if store is not None:
        for number in filter(chunks.__contains__, sorted(store.numbers())):
            size, part = len(plan.paths_of(number, paths)), store.read(number)
            stored = 0 if part is None else part.sizes["path"]
            if part is not None and stored == size:
                if not checked:
                    _check_same(observed, plan, part, store)
                    checked = True
                books.take(number, partial(_given, part), keep=False)
                taken.add(number)
                yield
            elif stored > size:
                longer.add(number)
    missing = (number for number in chunks if number not in taken)
    if client is not None:
        for number, part in run_on_cluster(client, loop, plan, missing, paths):
            books.take(number, partial(_given, part), number not in longer)
            yield
    else:
        for number in missing:
            numbers = plan.paths_of(number, paths)
            run = simulate_chunk(observed, plan, numbers, threads)
            counted = partial(count_chunk, observed, plan, numbers, run)
            books.take(number, counted, number not in longer)
            yield
    books.settle()
    yield


def _given(part: xr.Dataset) -> xr.Dataset:
    return part


def _check_same(observed: ClosedLoop, plan: Plan, part: xr.Dataset, store: Store) -> None:
    """Run the first path of a stored chunk again: a user's own part has no full description.

    Raises:
        ParameterError: If its metrics differ.
    """
    first = int(part["path"][0])
    again = run_chunk(observed, plan, range(first, first + 1), 1)
    for name, rows in again.data_vars.items():
        if "path" in rows.dims:
            stored = part[name].values[:1]
            if not np.allclose(stored, rows.values, rtol=SAME, atol=0.0, equal_nan=True):
                raise store.other_experiment(f"path {first} comes out with another {name}")


def _trajectories(kept: xr.Dataset) -> dict[str, xr.DataArray]:
    """Whole trajectories, over dimensions of their own: trajectory and moment."""
    renamed = kept.rename({"path": "trajectory", "time": "moment"})
    return {f"trajectory_{name}": renamed[name] for name in ("q", "v", "u", "ote")}
