"""How fast is the paper's pendulum, and how fast is it by hand in JAX and in diffrax?

JAX is compiled and warm. Its trajectory is compared with ours first.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from contenders import PATHS, compiled
from rich.console import Console
from tables import show, show_skipped, target
from timing import Contender, Effort, Record, measured, microseconds, ratios

from ftcfa import simulate
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

JAX_TICKS = 100
"""Number of ticks of one call of a compiled JAX function."""
AGREEMENT = 1e-6
"""Largest difference of JAX's trajectory from ours over 2 s without noise [rad]."""


def measure(effort: Effort) -> Record:
    """The record of the pendulum beside its rivals."""
    try:
        rivals, error, skipped = jax_rivals(effort), jax_error(), {}
    except ImportError as missing:
        rivals, error, skipped = [], None, {"JAX and diffrax": str(missing)}
    loop = closed_loop(FINITE_TIME)
    rows = measured([*(compiled(loop, k) for k in effort.thread_counts), *rivals], effort)
    return {"rows": rows, "skipped": skipped, "jax_error_rad": error, "targets": targets(rows)}


def jax_rivals(effort: Effort) -> list[Contender]:
    """The pendulum in JAX and diffrax, on one device as by default, and split over several."""
    threads = effort.threads
    os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={threads}"
    os.environ["JAX_PLATFORMS"] = "cpu"
    from pendulum_in_jax import diffrax_loop, scan_loop

    rivals: list[tuple[str, Callable[..., Any], dict[str, Any]]] = [
        ("JAX, vmap and scan", scan_loop, {}),
        ("diffrax, unsafe Brownian path", diffrax_loop, {}),
    ]
    if threads > 1:
        rivals += [(f"{name}, split", make, {"devices": threads}) for name, make, _ in rivals]
    if not effort.quick:
        rivals += [("diffrax, virtual Brownian tree", diffrax_loop, {"tree": True})]
    return [_jax_contender(name, threads, make, options) for name, make, options in rivals]


def _jax_contender(
    name: str, threads: int, make: Callable[..., Any], options: dict[str, Any]
) -> Contender:
    """A loop in JAX as a contender; one of its ticks is a call of JAX_TICKS ticks."""
    paths = PATHS - PATHS % threads
    carry, advance = make(paths, JAX_TICKS, **options)

    def run(calls: int) -> None:
        nonlocal carry
        for _ in range(calls):
            carry = advance(carry)
        carry.y.q.block_until_ready()

    run(2)  # the second call compiles anew: its arrays come from the first
    return Contender(name, threads, run, paths * JAX_TICKS)


def jax_error() -> float:
    """Largest difference of JAX's trajectory from ours over 2 s without noise [rad].

    Raises:
        RuntimeError: If it is not below AGREEMENT.
    """
    from pendulum_in_jax import scan_loop

    calls = 20
    ticks = calls * JAX_TICKS
    quiet = replace(closed_loop(FINITE_TIME), vibration=None)
    own = simulate(quiet, ticks * quiet.period)["q"].values
    carry, advance = scan_loop(1, JAX_TICKS, noise=0.0)
    error = 0.0
    for call in range(1, calls + 1):
        carry = advance(carry)
        error = max(error, np.abs(np.asarray(carry.y.q)[0] - own[call * JAX_TICKS]).max())
    if not error < AGREEMENT:
        raise RuntimeError(f"the pendulum in JAX differs by {error:g} rad")
    return float(error)


def print_tables(pendulum: Record, console: Console) -> None:
    """Print the times and their ratios."""
    own = microseconds(pendulum["rows"], "ftcfa")
    show(
        console,
        f"The paper's pendulum, {PATHS:,} paths",
        ["contender", "threads", "us per path-step", "ratio"],
        ([r["contender"], r["threads"], r["us"], r["us"] / own] for r in pendulum["rows"]),
    )
    show_skipped(console, pendulum["skipped"])


def targets(rows: list[Record]) -> list[Record]:
    """What the engine must reach beside JAX and diffrax."""
    return [
        target(f"pendulum: {name} / ftcfa", ratio, ">=", 12) for name, ratio in ratios(rows).items()
    ]
