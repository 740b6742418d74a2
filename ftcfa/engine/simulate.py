"""`simulate` and `simulate_paths`: one path of a closed loop or many, as a Dataset."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.checks import counting, known_name, natural
from ftcfa.engine.dataset import trajectories
from ftcfa.engine.run import Engine, check_memory, path_numbers, run_paths, samples_of
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.feasibility import warn_of_doubts

STANDARD = ("q", "v", "u")
"""Signals that are always recorded; all others are recorded on request."""
SCALE = "reference_scale"
"""The parameter that gives each path a desired motion of its own, which then is recorded."""
RESERVED = frozenset({"path", "time", "joint", "joint_type", "ote", "diverged_at"})
"""Names in the Dataset that no signal may have."""


def simulate(
    loop: ClosedLoop,
    duration: float,
    *,
    seed: int = 0,
    path: int = 0,
    signals: Iterable[str] = (),
    record_every: int = 1,
    engine: Engine = "compiled",
) -> xr.Dataset:
    """Simulate one path.

    Noise and robot of path i depend on (seed, i) alone, so any path of any ensemble can be run
    again by itself.

    Args:
        loop: The closed loop.
        duration: Simulated time [s]; samples lie at 0, period, ... up to and including it.
        seed: Seed of the experiment, 0 <= seed < 2^64.
        path: Number of the path, 0 <= path < 2^64.
        signals: Internal signals to record beside q, q_d, v and u, or ``"all"``.
        record_every: Number of samples from one that is kept to the next.
        engine: ``"compiled"``, or ``"interpreted"`` for the loop's own Python, step by step. A
            law that cannot be compiled runs interpreted, with a warning that says why.

    Returns:
        A Dataset with ``time`` [s]; ``q``, ``q_d``, ``v``, ``u`` over (time, joint); ``ote``, the
        overall tracking error |q - q_d|, over time; the requested signals; and ``diverged_at`` [s],
        the time at which the path diverged, from which on all but q_d is NaN, or NaN if it did not.

    Raises:
        ParameterError, UnknownNameError: If an argument is out of range or a name unknown.
    """
    dataset = _run(loop, [path], duration, seed, {}, signals, record_every, 1, engine)
    dataset = dataset.isel(path=0, drop=True)
    dataset.attrs["path"] = int(path)
    return dataset


def simulate_paths(
    loop: ClosedLoop,
    paths: int | Sequence[int],
    duration: float,
    *,
    seed: int = 0,
    vary: Mapping[str, npt.ArrayLike] | None = None,
    signals: Iterable[str] = (),
    record_every: int = 1,
    threads: int | None = None,
    engine: Engine = "compiled",
) -> xr.Dataset:
    """Simulate many paths at once.

    Args:
        loop: The closed loop.
        paths: Number of paths, which then have the numbers 0, 1, ..., or their numbers.
        duration: Simulated time [s].
        seed: Seed of the experiment, 0 <= seed < 2^64.
        vary: Parameters that differ from path to path, by dotted name, each of shape
            (paths, ...): initial states ``q0`` and ``v0``, ``arm.inertias``,
            ``arm.effort_limit``, ``vibration.level``, gains such as ``controller.gains.c1``, and
            any other number or array that a part of the loop declares in its ``varies``. The
            values are inputs of the compiled code, so a sweep compiles once.
        signals: Internal signals to record beside q, q_d, v and u, or ``"all"``.
        record_every: Number of samples from one that is kept to the next.
        threads: Number of threads; as many as this process may use by default.
        engine: ``"compiled"`` or ``"interpreted"``, as for `simulate`.

    Returns:
        A Dataset like that of `simulate` with a leading dimension ``path``. What varies is a
        coordinate; so are the robots that the loop's ``uncertainty`` draws.

    Raises:
        ParameterError, ShapeError, UnknownNameError: If an argument has the wrong range, shape or
            name.
    """
    return _run(loop, paths, duration, seed, vary or {}, signals, record_every, threads, engine)


def _run(
    loop: ClosedLoop,
    paths: int | Sequence[int],
    duration: float,
    seed: int,
    vary: Mapping[str, npt.ArrayLike],
    signals: Iterable[str],
    record_every: int,
    threads: int | None,
    engine: Engine,
) -> xr.Dataset:
    if not isinstance(loop, ClosedLoop):
        got = f"a {type(loop).__name__}"
        raise ParameterError("simulate", got, "a ClosedLoop(arm, controller, reference, vibration)")
    numbers = path_numbers(paths)
    samples = samples_of(loop, duration)
    seed = natural("seed", seed)
    counting("record_every", record_every)
    if threads is not None:
        counting("threads", threads)
    known_name("engine", engine, get_args(Engine))
    shapes = loop.signal_shapes()
    names = _signal_names(loop, vary, shapes, signals)
    entries = sum(int(np.prod(shapes[name])) for name in names)
    check_memory("record", 8 * entries * len(numbers) * -(-samples // record_every))
    warn_of_doubts(loop, duration, frames=2)
    run = run_paths(loop, samples, record_every, seed, numbers, names, vary, threads, engine)
    time = np.arange(0, samples, record_every) * loop.period
    dataset = trajectories(loop, time, run.paths, numbers, run.varied)
    dataset.attrs |= {
        "seed": seed,
        "duration": float(duration),
        "record_every": int(record_every),
        "engine": run.engine,
    }
    return dataset


def _signal_names(
    loop: ClosedLoop, vary: Any, shapes: Mapping[str, tuple[int, ...]], signals: Iterable[str]
) -> list[str]:
    known = list(shapes)
    for name in RESERVED.intersection(known):
        subject = f"signal '{name}' of {type(loop.controller).__name__}"
        raise ParameterError(subject, "a name that the Dataset has itself", "another name")
    if signals == "all":
        signals = known
    requested = [signals] if isinstance(signals, str) else list(signals)
    for name in requested:
        known_name("signal", name, known)
    own = ("q_d",) if SCALE in vary or SCALE in loop.spread else ()
    return [*STANDARD, *own, *(name for name in requested if name not in (*STANDARD, "q_d"))]
