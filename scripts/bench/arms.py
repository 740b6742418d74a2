"""How fast is the compiled engine on arms of 2 to 48 joints, beside Pinocchio and MuJoCo?

The plant is a perturbed twin of the controller's nominal arm, as the paper's M = Mbar + dM; the
pendulum runs as in the paper's Section V. A step of the others does less:

- aba: one forward dynamics by `pinocchio.abaInParallel`, locked joints welded; no integrator,
  noise or controller;
- MuJoCo: one step of `mujoco.rollout` of the bare arm, without geometry, friction or controller;
- interpreted: the same loop by the interpreted engine, one path in one process.
"""

import tempfile
import time
from dataclasses import replace
from pathlib import Path

import contenders
import numpy as np
from chain import write_chain
from contenders import PATHS, compiled
from rich.console import Console
from tables import show, show_skipped, target
from timing import Effort, Record, measured, microseconds, ratios, seconds_of

from ftcfa import FTCF, BaseAcceleration, ClosedLoop, Sinusoid, Vibration, WhiteNoise, load_arm
from ftcfa.engine.compiler.program import compile_loop
from ftcfa.engine.compiler.target import host_target
from ftcfa.engine.compiler.trace import trace
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

PENDULUM = "double_pendulum"
CATALOGUE = ("ur5", "panda", "baxter")
CHAINS = (12, 24, 48)
"""Numbers of joints of arms that no catalogue has."""
FASTER = {
    ("panda", "aba"): 12,
    ("panda", "MuJoCo"): 6,
    ("panda", "interpreted"): 300,
    ("baxter", "aba"): 10,
    ("chain24", "aba"): 6,
}
"""How many times as long a rival shall take."""
COMPILED = {"panda": 1, "chain48": 10}
"""Seconds in which a loop shall be compiled."""


def measure(effort: Effort) -> Record:
    """The record of every arm, by name, and the targets."""
    with tempfile.TemporaryDirectory() as folder:
        robots = {PENDULUM: PENDULUM, **{name: name for name in CATALOGUE}}
        for n in CHAINS[: 1 if effort.quick else None]:
            file = Path(folder) / f"chain{n}.urdf"
            write_chain(n, file)
            robots[f"chain{n}"] = str(file)
        arms = {name: _measure_arm(robot, effort) for name, robot in robots.items()}
    return {"arms": arms, "targets": targets(arms)}


def bench_loop(robot: str, seed: int = 0) -> ClosedLoop:
    """The closed loop of an arm; another seed draws another plant."""
    rng = np.random.default_rng(seed)
    if robot == PENDULUM:
        loop = closed_loop(FINITE_TIME)
        return replace(loop, arm=loop.arm.perturbed(rng)) if seed else loop
    nominal = load_arm(robot)
    return ClosedLoop(
        arm=nominal.perturbed(rng),
        controller=FTCF(nominal),
        reference=Sinusoid(amplitude=0.3, offset=nominal.home),
        vibration=Vibration(BaseAcceleration(), WhiteNoise(0.01)),
    )


def compile_times(robot: str, times: int) -> Record:
    """Time to trace and to compile, the best of some fresh plants [s]; size of the code."""
    tracing, compiling = [], []
    for seed in range(1, times + 1):
        loop = bench_loop(robot, seed)
        start = time.perf_counter()
        traced = trace(loop, ("q", "v", "u"))
        tracing.append(time.perf_counter() - start)
        compiling.append(seconds_of(compile_loop, traced, host_target()))
    size = traced.first.n_instructions()
    return {"instructions": size, "trace_s": min(tracing), "compile_s": min(compiling)}


def _measure_arm(robot: str, effort: Effort) -> Record:
    """Record of one arm: shared and varied parameters, rivals, compile times."""
    times = compile_times(robot, 1 if effort.quick else 3)
    loop, counts, skipped = bench_loop(robot), effort.thread_counts, {}
    model = contenders.bare_model(loop.controller.nominal)
    measures = [compiled(loop, k) for k in counts]
    measures += [compiled(loop, counts[-1], values=contenders.varied(loop))]
    measures += [contenders.interpreted(loop), *(contenders.aba(model, k) for k in counts)]
    try:
        arm = contenders.mujoco_arm(model)
        measures += [contenders.mujoco_rollout(arm, k) for k in counts]
    except (ImportError, ValueError) as error:
        skipped["MuJoCo"] = str(error).splitlines()[0]
    rows = measured(measures, effort)
    return {
        "joints": loop.arm.n, **times, "rows": rows, "ratios": ratios(rows), "skipped": skipped,
    }  # fmt: skip


def print_tables(record: Record, console: Console) -> None:
    """Print the times, then their ratios, the size of the code and the cost of a call."""
    arms = record["arms"]
    counts = sorted({row["threads"] for row in arms[PENDULUM]["rows"]})
    timed = [(name, k) for name in ("ftcfa", "aba", "MuJoCo") for k in counts]
    timed[len(counts) : len(counts)] = [("ftcfa, varied", counts[-1])]
    timed.append(("interpreted", 1))
    show(
        console,
        f"Microseconds per path-step, {PATHS:,} paths; threads below the names",
        ["arm", *(f"{name.replace('ftcfa, ', '')}\n{k}" for name, k in timed)],
        ([name, *(microseconds(arm["rows"], *c) for c in timed)] for name, arm in arms.items()),
    )
    kinds = {"aba": "aba", "MuJoCo": "MuJoCo", "interpreted": "interp.", "ftcfa, varied": "varied"}
    facts = ("joints", "instructions", "trace_s", "compile_s")
    show(
        console,
        "Ratios to ftcfa, each at its best number of threads; the code, and the cost of a call",
        ["arm", *kinds.values(), "joints", "instructions", "trace s", "compile s", "call ms"],
        (
            [name, *map(arm["ratios"].get, kinds), *map(arm.get, facts), arm["rows"][0]["call_ms"]]
            for name, arm in arms.items()
        ),
    )
    for name, arm in arms.items():
        show_skipped(console, {f"{rival} of {name}": why for rival, why in arm["skipped"].items()})


def targets(arms: Record) -> list[Record]:
    """What the engine must reach on these arms."""
    shares = {name: arm["ratios"]["ftcfa, varied"] for name, arm in arms.items()}
    worst = max(shares, key=lambda name: shares[name])
    rows = [
        target(f"{arm}: {rival} / ftcfa", arms[arm]["ratios"].get(rival), ">=", bound)
        for (arm, rival), bound in FASTER.items()
        if arm in arms
    ]
    rows.append(target(f"varied / shared parameters ({worst})", shares[worst], "<=", 1.3))
    for name, bound in COMPILED.items():
        if name in arms:
            rows.append(target(f"{name}: compile, s", arms[name]["compile_s"], "<=", bound))
    return rows
