"""`ensemble`: statistics over any number of paths, in chunks, that survive an interruption."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import xarray as xr

from ftcfa.arrays import counting
from ftcfa.engine.run import path_numbers, samples_of
from ftcfa.engine.simulate import simulate_paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.describe import describe
from ftcfa.study.chunk import Plan, Tally, run_chunk
from ftcfa.study.cluster import run_on_cluster
from ftcfa.study.estimate import CONFIDENCE, probability
from ftcfa.study.store import Store
from ftcfa.study.summary import QUANTILES, summarise

Progress = Callable[[int, int], None]
"""Called with the paths done and the paths asked for."""


def ensemble(
    loop: ClosedLoop,
    paths: int,
    duration: float,
    *,
    seed: int = 0,
    record_every: int = 0,
    tolerance: float = 0.05,
    after: float | None = None,
    quantiles: Sequence[float] = QUANTILES,
    confidence: float = CONFIDENCE,
    trajectories: Iterable[int] = (),
    threads: int | None = None,
    chunk: int = 4096,
    client: Any = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Simulate many paths and say what they amount to, with confidence intervals.

    Path i of a seed is that of `simulate`, so any of them can be run again (`replay`). Ctrl-C
    ends the run early: the Dataset is then of the chunks that were done, as many paths as its
    dimension ``path`` says, and with a ``store`` the same call goes on from there.

    Args:
        loop: The closed loop.
        paths: How many; numbers 0, 1, ...
        duration: Simulated time [s].
        seed: Seed of the experiment.
        record_every: Statistics over time are kept at every so many samples; 0 takes about 200
            times.
        tolerance: Overall tracking error within which a path counts as settled [rad or m].
        after: Time from which errors count as late [s]; half of the duration by default.
        quantiles: Probabilities of the quantiles over time.
        confidence: Of every interval.
        trajectories: Numbers of paths that are kept whole.
        threads: Threads; all that this process may use by default.
        chunk: Paths a chunk. Results are the same to rounding for any; bit for bit for one.
        client: A `dask.distributed.Client`: chunks go to its cluster, instead of threads here.
            The loop travels as its description.
        store: A folder for the chunks, so that an interrupted run goes on where it was.
        progress: Called with the paths done and the paths asked for.

    Returns:
        A Dataset; see `ftcfa.study.summary.summarise`.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If an argument is out of range, or the store
            is of another experiment.
        FtcfaError: If the store cannot be written.
    """
    counting("paths", paths)
    samples_of(loop, duration)
    probability("confidence", confidence)
    for p in quantiles:
        probability("quantile", p)
    whole = path_numbers(trajectories)
    plan = Plan(float(duration), seed, record_every, tolerance, chunk, after)
    told = {"loop": describe(loop), "plan": describe(plan)}
    place = None if store is None else Store(store, told)
    tally = Tally(len(plan.times(loop)), loop.arm.n)
    try:
        for number, part in _chunks(loop, plan, paths, threads, client, place):
            tally.add(number, part)
            if progress is not None:
                progress(tally.paths, paths)
    except KeyboardInterrupt:
        if not len(tally):
            raise
    dataset = summarise(loop, plan, tally, quantiles, confidence)
    if len(whole):
        kept = simulate_paths(loop, whole.tolist(), duration, seed=seed, threads=threads)
        dataset = dataset.assign(_trajectories(kept))
    if place is not None:
        place.write_result(dataset)
    return dataset


def _chunks(
    loop: ClosedLoop, plan: Plan, paths: int, threads: int | None, client: Any, store: Store | None
) -> Iterator[tuple[int, xr.Dataset]]:
    """All chunks: those in the store, then the others as they are done, which it then gets."""
    missing = []
    there = set() if store is None else set(store)
    for number in plan.chunks(paths):
        wanted = plan.paths_of(number, paths)
        part = store.read(number) if store is not None and number in there else None
        if part is not None and part.sizes["path"] == len(wanted):
            yield number, part
        else:
            missing.append(number)
    if client is not None:
        computed = run_on_cluster(client, loop, plan, missing, paths)
    else:
        watched = plan.watched(loop)
        computed = (
            (number, run_chunk(watched, plan, plan.paths_of(number, paths), threads))
            for number in missing
        )
    for number, part in computed:
        if store is not None:
            store.write(number, part)
        yield number, part


def _trajectories(kept: xr.Dataset) -> dict[str, xr.DataArray]:
    """Whole paths, with dimensions of their own: trajectory and moment."""
    renamed = kept.rename({"path": "trajectory", "time": "moment"})
    return {f"trajectory_{name}": renamed[name] for name in ("q", "v", "u", "ote")}
