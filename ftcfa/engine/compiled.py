"""The compiled engine: paths in blocks, and machine code that runs the blocks on threads."""

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from dataclasses import dataclass
from threading import Event

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.engine.compiler.flatten import flat, split
from ftcfa.engine.compiler.program import Program, compile_loop
from ftcfa.engine.compiler.target import Target, host_target
from ftcfa.engine.compiler.trace import TracedLoop, trace
from ftcfa.engine.paths import Paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.streams import first_rows

CACHE_LINE = 64
TICKS_PER_CALL = 2048
"""Integration steps between two checks of whether to stop: some 20 ms."""


def run_compiled(
    loop: ClosedLoop,
    samples: int,
    record_every: int,
    seed: int,
    paths: npt.NDArray[np.uint64],
    names: Sequence[str],
    varied: Mapping[str, Array],
    threads: int | None = None,
    target: Target | None = None,
) -> Paths:
    """Run many paths by compiled code.

    Args:
        loop: The closed loop.
        samples: Number of samples; the first is at time zero.
        record_every: Number of samples from one that is kept to the next.
        seed: Seed of the experiment.
        paths: Numbers of the paths.
        names: Signals to keep.
        varied: Parameters that differ from path to path, each of shape (paths, ...).
        threads: Number of threads; as many as this process may use by default.
        target: Vectors to compile for; those of this machine by default.
    """
    target = host_target() if target is None else target
    traced = trace(loop, names, tuple(varied))
    program = compile_loop(traced, target)
    process, starts = loop.process, np.zeros(len(paths), dtype=np.int64)
    if process.random_start:
        starts = first_rows(seed, paths, len(process.rows))
    motion = loop.reference.at(np.arange(samples) * loop.period)
    kept = -(-samples // record_every)
    blocks = -(-len(paths) // program.lanes)
    work = _Work(
        program=program,
        seed=np.uint64(seed).astype(np.int64).item(),
        samples=samples,
        ticks=max(1, TICKS_PER_CALL // loop.substeps),
        record_every=record_every,
        desired=np.ascontiguousarray(np.concatenate(motion, axis=1)),
        paths=_padded(paths, program.lanes),
        rows=np.ascontiguousarray(process.rows),
        first_rows=_padded(starts, program.lanes),
        parameters=_parameters(traced, varied, len(paths), program.lanes),
        record=np.empty((blocks * program.lanes, kept, program.signals)),
        diverged_at=np.full((blocks, program.lanes), np.nan),
        observed=np.empty((blocks, flat(traced.observer).size, program.lanes)),
    )
    _run_blocks(work, blocks, threads)
    record = work.record[: len(paths)]
    diverged_at = work.diverged_at.reshape(-1)[: len(paths)] * loop.period
    rows = work.observed.transpose(0, 2, 1)  # (blocks, lanes, entries)
    observed = rows.reshape(len(work.record), rows.shape[2])[: len(paths)]
    arrays = split(record, [shape for _, shape in traced.signals])
    signals = {name: array for (name, _), array in zip(traced.signals, arrays, strict=True)}
    return Paths.of(signals, diverged_at, observed, traced.observer)


@dataclass(frozen=True, eq=False)
class _Work:
    """The arrays that the blocks read and write; each block writes to its own rows."""

    program: Program
    seed: int
    samples: int
    ticks: int  # a call
    record_every: int
    desired: Array  # of every sample, the same for all paths (samples, 3 n)
    paths: np.ndarray  # (blocks, lanes)
    rows: Array  # (R, columns)
    first_rows: np.ndarray  # (blocks, lanes)
    parameters: Array  # (blocks, entries, lanes)
    record: Array  # (blocks lanes, kept, signals)
    diverged_at: Array  # (blocks, lanes), in ticks
    observed: Array  # (blocks, entries, lanes)

    def block(self, b: int, stop: Event) -> None:
        """Run one block to its end, or until `stop` is set."""
        program = self.program
        state = _aligned(np.zeros((program.states, program.lanes)))
        record = self.record[b * program.lanes :]
        own = (state, self.parameters[b], self.paths[b], self.first_rows[b], self.diverged_at[b])
        state_at, parameters, paths, first_rows, diverged_at = (x.ctypes.data for x in own)
        program.init(state_at, parameters, self.desired.ctypes.data, paths, self.seed)
        for tick in range(0, self.samples, self.ticks):
            if stop.is_set():
                return
            ticks = min(self.ticks, self.samples - tick)
            inputs = (parameters, self.desired[tick:].ctypes.data, paths, self.seed)
            rows = (self.rows.ctypes.data, len(self.rows), first_rows)
            kept = (self.record_every, record.ctypes.data, record[0].size)
            program.run(state_at, *inputs, *rows, tick, ticks, *kept, diverged_at)
        self.observed[b] = state[program.states - self.observed.shape[1] :]


def usable_cores() -> int:
    """Number of processors that this process may use; of all, where the system does not tell."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _run_blocks(work: _Work, blocks: int, threads: int | None) -> None:
    """Run all blocks on threads; an interrupt stops them within one call of their code."""
    threads = usable_cores() if threads is None else threads
    stop, queue = Event(), iter(range(blocks))

    def serve() -> None:
        for b in queue:  # which the threads share: each takes the next block when it is free
            if stop.is_set():
                return
            work.block(b, stop)

    if min(threads, blocks) <= 1:
        serve()
        return
    with ThreadPoolExecutor(max_workers=threads) as pool:
        try:
            pending = {pool.submit(serve) for _ in range(min(threads, blocks))}
            while pending:
                done, pending = wait(pending, timeout=0.2, return_when=FIRST_EXCEPTION)
                for future in done:
                    future.result()
        except BaseException:
            stop.set()
            raise


def _padded(rows: np.ndarray, lanes: int) -> np.ndarray:
    """Rows (paths, ...) as blocks (blocks, lanes, ...); the last row fills the last block."""
    missing = -len(rows) % lanes
    full = np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)])
    return full.reshape(len(full) // lanes, lanes, *rows.shape[1:])


def _parameters(traced: TracedLoop, varied: Mapping[str, Array], paths: int, lanes: int) -> Array:
    """Parameters as the traced code takes them, a path a lane, shape (blocks, entries, lanes)."""
    rows: list[Array] = [np.zeros((paths, 0))]
    for name, prepare in traced.preparations:
        values = prepare(varied[name])
        rows.append(values.reshape(paths, int(np.prod(values.shape[1:]))))
    blocks = _padded(np.concatenate(rows, axis=1), lanes)  # (blocks, lanes, entries)
    return _aligned(blocks.transpose(0, 2, 1))


def _aligned(values: Array) -> Array:
    """A contiguous copy that begins on a cache line; a vector across two lines costs double."""
    memory = np.empty(values.nbytes + CACHE_LINE, dtype=np.uint8)
    start = -memory.ctypes.data % CACHE_LINE
    copy = memory[start : start + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[...] = values
    return copy
