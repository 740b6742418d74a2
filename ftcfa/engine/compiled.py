"""The compiled engine: blocks of paths on threads, each block through its program."""

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from dataclasses import dataclass
from threading import Event

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.control.protocol import Signals
from ftcfa.engine.compiler.flatten import flat
from ftcfa.engine.compiler.program import Program, compile_loop
from ftcfa.engine.compiler.trace import TracedLoop, trace
from ftcfa.engine.compiler.vector_math import Target, host_target
from ftcfa.engine.paths import Paths
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.streams import first_rows

CACHE_LINE = 64
TICKS_PER_CALL = 2048
"""Ticks of one integration step each between two looks at whether to stop: some 20 ms."""


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
    """Run many paths.

    Args:
        loop: The closed loop.
        samples: Number of samples; the first is at time zero.
        record_every: Keep every so many samples.
        seed: Seed of the experiment.
        paths: Numbers of the paths.
        names: Signals to keep.
        varied: Parameters that differ from path to path, each of shape (paths, ...).
        threads: Threads; as many as this process may use by default.
        target: Vectors to compile for; the machine's own by default.

    """
    target = host_target() if target is None else target
    traced = trace(loop, names, tuple(varied))
    program = compile_loop(traced, target)
    process, starts = loop.process, np.zeros(len(paths), dtype=np.int64)
    if process.random_start:
        starts = first_rows(seed, paths, len(process.rows))
    kept = -(-samples // record_every)
    blocks = -(-len(paths) // program.lanes)
    work = _Work(
        program=program,
        seed=np.uint64(seed).astype(np.int64).item(),
        samples=samples,
        ticks=max(1, TICKS_PER_CALL // loop.substeps),
        record_every=record_every,
        desired=_desired_rows(loop, samples),
        paths=_padded(paths, program.lanes),
        rows=np.ascontiguousarray(process.rows),
        first_rows=_padded(starts, program.lanes),
        parameters=_parameters(traced, varied, len(paths), program.lanes),
        record=np.empty((blocks * program.lanes, kept, program.signals)),
        death=np.full((blocks, program.lanes), np.nan),
        observed=np.empty((blocks, flat(traced.observer).size, program.lanes)),
    )
    _run_blocks(work, blocks, threads)
    record = work.record[: len(paths)]
    died = work.death.reshape(-1)[: len(paths)] * loop.period
    rows = work.observed.transpose(0, 2, 1)  # (blocks, lanes, entries)
    observed = rows.reshape(len(work.record), rows.shape[2])[: len(paths)]
    return Paths.of(_split(record, traced), died, observed, traced.observer)


@dataclass(frozen=True, eq=False)
class _Work:
    """All that the blocks read and write; each block owns its rows."""

    program: Program
    seed: int
    samples: int
    ticks: int  # a call
    record_every: int
    desired: Array  # (samples, 3 n)
    paths: np.ndarray  # (blocks, lanes)
    rows: Array  # (R, columns)
    first_rows: np.ndarray  # (blocks, lanes)
    parameters: Array  # (blocks, entries, lanes)
    record: Array  # (blocks lanes, kept, signals)
    death: Array  # (blocks, lanes)
    observed: Array  # (blocks, entries, lanes)

    def block(self, b: int, stop: Event) -> None:
        """Run one block to its end, or until asked to stop."""
        program = self.program
        state = _aligned(np.zeros((program.states, program.lanes)))
        parameters, paths, death = self.parameters[b], self.paths[b], self.death[b]
        record = self.record[b * program.lanes :]
        first_rows = self.first_rows[b]
        program.init(
            state.ctypes.data,
            parameters.ctypes.data,
            self.desired.ctypes.data,
            paths.ctypes.data,
            self.seed,
        )
        for tick in range(0, self.samples, self.ticks):
            if stop.is_set():
                return
            program.run(
                state.ctypes.data,
                parameters.ctypes.data,
                self.desired[tick:].ctypes.data,
                paths.ctypes.data,
                self.seed,
                self.rows.ctypes.data,
                len(self.rows),
                first_rows.ctypes.data,
                tick,
                min(self.ticks, self.samples - tick),
                self.record_every,
                record.ctypes.data,
                record[0].size,
                death.ctypes.data,
            )
        self.observed[b] = state[program.states - self.observed.shape[1] :]


def _run_blocks(work: _Work, blocks: int, threads: int | None) -> None:
    """All blocks, on threads; an interrupt stops them within a call."""
    threads = len(os.sched_getaffinity(0)) if threads is None else threads
    stop, queue = Event(), iter(range(blocks))

    def serve() -> None:
        for b in queue:  # threads share it: each takes the next block when it is free
            if stop.is_set():
                return
            work.block(b, stop)

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


def _desired_rows(loop: ClosedLoop, samples: int) -> Array:
    """The desired motion at every sample, which all paths share, shape (samples, 3 n)."""
    rows = loop.reference.at(np.arange(samples) * loop.period)
    return np.ascontiguousarray(np.concatenate(rows, axis=1))


def _padded(rows: np.ndarray, lanes: int) -> np.ndarray:
    """Rows (paths, ...) in blocks (blocks, lanes, ...), the last row repeated to fill."""
    missing = -len(rows) % lanes
    full = np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)])
    return full.reshape(len(full) // lanes, lanes, *rows.shape[1:])


def _parameters(traced: TracedLoop, varied: Mapping[str, Array], paths: int, lanes: int) -> Array:
    """Parameters in the order of the traced code, a path a lane: (blocks, entries, lanes)."""
    rows: list[Array] = [np.zeros((paths, 0))]
    for name, prepare in traced.preparations:
        values = prepare(varied[name])
        rows.append(values.reshape(paths, int(np.prod(values.shape[1:]))))
    blocks = _padded(np.concatenate(rows, axis=1), lanes)  # (blocks, lanes, entries)
    return _aligned(blocks.transpose(0, 2, 1))


def _aligned(values: Array) -> Array:
    """A copy in rows that begins on a cache line: vectors that cross lines cost double."""
    memory = np.empty(values.nbytes + CACHE_LINE, dtype=np.uint8)
    start = -memory.ctypes.data % CACHE_LINE
    copy = memory[start : start + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[...] = values
    return copy


def _split(record: Array, traced: TracedLoop) -> Signals:
    """The recorded row cut into its signals: views, not copies."""
    signals, start = {}, 0
    for name, shape in traced.signals:
        entries = int(np.prod(shape))
        signals[name] = record[:, :, start : start + entries].reshape(*record.shape[:2], *shape)
        start += entries
    return signals
