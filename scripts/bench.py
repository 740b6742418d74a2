"""How fast is the compiled engine, and how fast are others on the same machine?

    python scripts/bench.py [--quick] [--threads N] [--json FILE]

The unit is microseconds per path-step: one sample of one path of the whole closed loop (plant,
noise, controller, filter, adaptation), 1 ms long, one integration step. The plant is a perturbed
twin of the controller's nominal arm, as the paper's M = Mbar + dM; the pendulum runs as in the
paper's Section V. What the others do in a step:

- aba: one forward dynamics by `pinocchio.abaInParallel`, locked joints welded; no integrator,
  noise or controller;
- MuJoCo: one step of `mujoco.rollout` of the bare arm, without geometry, friction or controller;
- interpreted: the same loop by the interpreted engine, one path in one process;
- JAX, diffrax: the pendulum's loop by hand; see `bench_jax.py`.

Contenders take turns and the shortest time of each counts, so that what else the machine does hits
all alike. Times are those of the run alone: from a call of `simulate_paths` that of a call for a
single sample is taken off (finding the code, the Dataset) and shown by itself; JAX is compiled and
warm. A package that is not installed is left out with a line that says so.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would spin beside the contenders

import argparse
import json
import math
import platform
import statistics
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from rich.console import Console

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Sinusoid,
    Vibration,
    WhiteNoise,
    load_arm,
    simulate,
    simulate_paths,
)
from ftcfa.arrays import Array
from ftcfa.engine.compiler.program import compile_loop
from ftcfa.engine.compiler.trace import trace
from ftcfa.engine.compiler.vector_math import host_target
from ftcfa.report.terminal import plain_table, print_fitted
from ftcfa.study.reproduction import FINITE_TIME, closed_loop

PATHS = 1024
PENDULUM = "double_pendulum"
ARMS = (PENDULUM, "ur5", "panda", "baxter", "chain12", "chain24")
PATH_COUNTS = (1, 8, 64, 1024, 10_000, 100_000)
JAX_TICKS = 100
"""Ticks of one call of a compiled JAX function."""
AGREEMENT = 1e-6
"""Largest difference of JAX's trajectory from ours over 2 s without noise [rad]."""
PACKAGES = ("ftcfa", "pin", "casadi", "llvmlite", "numpy", "mujoco", "jax", "jaxlib", "diffrax")

Record = dict[str, Any]


@dataclass
class Contender:
    """What is measured: ``run(ticks)`` advances some paths by some ticks.

    Attributes:
        name: What it is.
        threads: Threads that it may use.
        run: The measured call.
        paths: How many paths it advances.
        has_fixed: Whether the time of ``run(1)`` is taken off.
        ticks: Ticks of a measurement.
        times: Of each turn [s].
        fixed: Of ``run(1)``, each turn [s].
    """

    name: str
    threads: int
    run: Callable[[int], object]
    paths: int = PATHS
    has_fixed: bool = False
    ticks: int = 1
    times: list[float] = field(default_factory=list)
    fixed: list[float] = field(default_factory=list)

    def calibrate(self, seconds: float) -> None:
        """Warm up, and find how many ticks take so long, or long beside what is taken off."""
        self.run(1)
        floor = self._shorter(1) if self.has_fixed else 0.0
        seconds = max(seconds, 10 * floor)
        while (taken := self._shorter(self.ticks) - floor) < seconds / 2:
            self.ticks *= 2
        self.ticks = math.ceil(self.ticks * seconds / taken)

    def _shorter(self, ticks: int) -> float:
        return min(seconds_of(self.run, ticks) for _ in range(2))

    def turn(self) -> None:
        """Measure once."""
        self.times.append(seconds_of(self.run, self.ticks))
        if self.has_fixed:
            self.fixed.append(seconds_of(self.run, 1))

    @property
    def microseconds(self) -> float:
        """Per path-step."""
        seconds, ticks = min(self.times), self.ticks
        if self.has_fixed:
            seconds, ticks = seconds - min(self.fixed), ticks - 1
        return 1e6 * seconds / (ticks * self.paths)

    def row(self) -> Record:
        """As plain data."""
        row = {"threads": self.threads, "paths": self.paths, "ticks": self.ticks}
        call = {"call_ms": 1e3 * min(self.fixed)} if self.has_fixed else {}
        spread = {"median_over_best": statistics.median(self.times) / min(self.times)}
        return {"contender": self.name, **row, "us": self.microseconds, **call, **spread}


def seconds_of(run: Callable[..., object], *arguments: object) -> float:
    """How long a call takes."""
    start = time.perf_counter()
    run(*arguments)
    return time.perf_counter() - start


def measured(contenders: list[Contender], turns: int, seconds: float) -> list[Record]:
    """All contenders in turn, again and again."""
    for contender in contenders:
        contender.calibrate(seconds)
    for _ in range(turns):
        for contender in contenders:
            contender.turn()
    return [contender.row() for contender in contenders]


# --- the loops ---------------------------------------------------------------------------------


def bench_loop(name: str, folder: Path, seed: int = 0) -> ClosedLoop:
    """The closed loop of an arm; another seed draws another plant."""
    rng = np.random.default_rng(seed)
    if name == PENDULUM:
        loop = closed_loop(FINITE_TIME)
        return replace(loop, arm=loop.arm.perturbed(rng)) if seed else loop
    nominal = load_arm(folder / f"{name}.urdf" if name.startswith("chain") else name)
    return ClosedLoop(
        arm=nominal.perturbed(rng),
        controller=FTCF(nominal),
        reference=Sinusoid(amplitude=0.3, offset=nominal.home),
        vibration=Vibration(BaseAcceleration(), WhiteNoise(0.01)),
    )


def write_chain(n: int, folder: Path) -> None:
    """A URDF of n revolute joints in a row: any axes and placements, physical inertias."""
    rng = np.random.default_rng(n)
    parts = ['<robot name="chain"><link name="link0"/>']
    for i in range(1, n + 1):
        mass = 4.0 * 0.85**i
        spread = mass * rng.uniform(0.002, 0.01, 3)  # second moments of mass about the centre
        xx, yy, zz = spread.sum() - spread
        axis, xyz, rpy, centre, turn = (_row(rng.uniform(-s, s, 3)) for s in (1, 0.15, 1, 0.15, 1))
        parts.append(
            f'<joint name="joint{i}" type="revolute">'
            f'<parent link="link{i - 1}"/><child link="link{i}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" velocity="10" effort="{200 * 0.9**i + 5}"/></joint>'
            f'<link name="link{i}"><inertial><origin xyz="{centre}" rpy="{turn}"/>'
            f'<mass value="{mass}"/>'
            f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/>'
            "</inertial></link>"
        )
    (folder / f"chain{n}.urdf").write_text("".join([*parts, "</robot>"]))


def _row(numbers: Iterable[float]) -> str:
    return " ".join(f"{x:.6f}" for x in numbers)


def varied(loop: ClosedLoop) -> dict[str, Array]:
    """Another robot and other gains for every path."""
    rng = np.random.default_rng(1)
    nominal, gains = loop.controller.nominal, loop.controller.gains
    robots = np.array([nominal.perturbed(rng).inertias for _ in range(64)])
    drawn = {
        f"controller.gains.{name}": value * rng.uniform(0.9, 1.1, PATHS)
        for name, value in vars(gains).items()
    }
    return {"arm.inertias": robots[np.arange(PATHS) % len(robots)], **drawn}


def compile_times(name: str, folder: Path, times: int) -> Record:
    """Seconds to trace and to compile, the best of some fresh plants; size of the code."""
    tracing, compiling = [], []
    for seed in range(1, times + 1):
        loop = bench_loop(name, folder, seed)
        start = time.perf_counter()
        traced = trace(loop, ("q", "v", "u"))
        tracing.append(time.perf_counter() - start)
        compiling.append(seconds_of(compile_loop, traced, host_target()))
    size = traced.first.n_instructions()
    return {"instructions": size, "trace_s": min(tracing), "compile_s": min(compiling)}


# --- the contenders ----------------------------------------------------------------------------


def ours(loop: ClosedLoop, threads: int, paths: int = PATHS, vary: bool = False) -> Contender:
    """The compiled engine; it records the first sample."""
    values = varied(loop) if vary else None

    def run(ticks: int) -> None:
        duration = (ticks - 1) * loop.period
        simulate_paths(loop, paths, duration, vary=values, record_every=ticks, threads=threads)

    return Contender("ftcfa, varied" if vary else "ftcfa", threads, run, paths, has_fixed=True)


def interpreted(loop: ClosedLoop) -> Contender:
    """The interpreted engine; it records the first sample."""

    def run(ticks: int) -> None:
        duration = (ticks - 1) * loop.period
        simulate(loop, duration, record_every=ticks, engine="interpreted")

    return Contender("interpreted", 1, run, paths=1, has_fixed=True)


def bare_model(loop: ClosedLoop, name: str) -> pin.Model:
    """The plant with its locked joints welded.

    The pendulum's mimic joint suits neither `aba` nor MuJoCo: its twin in relative angles stands
    in for it.
    """
    arm: Any = load_arm(f"{PENDULUM}_relative") if name == PENDULUM else loop.arm
    still = [i + 1 for i, moves in enumerate(arm.G.any(axis=1)) if not moves]
    return pin.buildReducedModel(arm.model, still, arm.g0)


def aba(model: pin.Model, threads: int) -> Contender:
    """Pinocchio's forward dynamics; a tick is one batch."""
    pool, rng = pin.ModelPool(model, threads), np.random.default_rng(0)
    q, v, tau = (np.asfortranarray(rng.uniform(-1, 1, (model.nv, PATHS))) for _ in range(3))
    acceleration = np.zeros_like(q)

    def run(ticks: int) -> None:
        for _ in range(ticks):
            pin.abaInParallel(threads, pool, q, v, tau, acceleration)

    return Contender("aba", threads, run)


def mujoco_arm(model: pin.Model) -> Any:
    """The same arm for MuJoCo, its mass matrix compared."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.gravity = 1e-3, model.gravity.linear
    bodies, joints = [spec.worldbody], model.createData().joints
    for i in range(1, model.njoints):
        inertia, placement = model.inertias[i], model.jointPlacements[i]
        I = inertia.inertia  # noqa: E741
        body = bodies[model.parents[i]].add_body(
            pos=placement.translation,
            quat=pin.Quaternion(placement.rotation).coeffs()[[3, 0, 1, 2]],
            mass=inertia.mass,
            ipos=inertia.lever,
            fullinertia=[I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]],
            explicitinertial=True,
        )
        slide, turn = np.split(joints[i].S.ravel(), 2)
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slide.any() else mujoco.mjtJoint.mjJNT_HINGE
        body.add_joint(type=kind, axis=slide + turn)
        bodies.append(body)
    compiled = spec.compile()
    state, M = mujoco.MjData(compiled), np.zeros((model.nv, model.nv))
    state.qpos[:] = np.linspace(-1.0, 1.0, model.nv)
    mujoco.mj_forward(compiled, state)
    mujoco.mj_fullM(compiled, state, M)
    truth = pin.crba(model, model.createData(), state.qpos, pin.Convention.WORLD)
    if not np.allclose(M, truth, rtol=1e-6, atol=1e-9):
        raise RuntimeError("MuJoCo's mass matrix differs from Pinocchio's")
    return compiled


def mujoco_rollout(arm: Any, threads: int) -> Contender:
    """MuJoCo's own loop over steps and threads, which records every state."""
    import mujoco
    from mujoco.rollout import Rollout

    pool, data = Rollout(nthread=threads), [mujoco.MjData(arm) for _ in range(threads)]
    size = mujoco.mj_stateSize(arm, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros((PATHS, size))
    start[:, 1 : 1 + arm.nq] = np.random.default_rng(0).uniform(-0.3, 0.3, (PATHS, arm.nq))

    def run(ticks: int) -> None:
        pool.rollout(arm, data, start, nstep=ticks)

    return Contender("MuJoCo", threads, run)


def jax_rivals(threads: int, quick: bool) -> list[Contender]:
    """The pendulum in JAX and diffrax, on one device as by default, and split over several."""
    os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={threads}"
    os.environ["JAX_PLATFORMS"] = "cpu"
    import bench_jax

    rivals = [
        ("JAX, vmap and scan", bench_jax.scan_loop, {}),
        ("diffrax, unsafe Brownian path", bench_jax.diffrax_loop, {}),
    ]
    if threads > 1:
        rivals += [(f"{name}, split", make, {"devices": threads}) for name, make, _ in rivals]
    if not quick:
        rivals += [("diffrax, virtual Brownian tree", bench_jax.diffrax_loop, {"tree": True})]
    return [_jax_contender(name, threads, make, options) for name, make, options in rivals]


def _jax_contender(
    name: str, threads: int, make: Callable[..., Any], options: dict[str, Any]
) -> Contender:
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
    """Largest difference of JAX's trajectory from ours over 2 s without noise [rad]."""
    import bench_jax

    calls = 20
    ticks = calls * JAX_TICKS
    quiet = replace(closed_loop(FINITE_TIME), vibration=None)
    own = simulate(quiet, ticks * quiet.period)["q"].values
    carry, advance = bench_jax.scan_loop(1, JAX_TICKS, noise=0.0)
    error = 0.0
    for call in range(1, calls + 1):
        carry = advance(carry)
        error = max(error, np.abs(np.asarray(carry.y.q)[0] - own[call * JAX_TICKS]).max())
    if not error < AGREEMENT:
        raise RuntimeError(f"the pendulum in JAX differs by {error:g} rad")
    return float(error)


# --- the measurements --------------------------------------------------------------------------


def bench_arm(name: str, folder: Path, threads: list[int], turns: int, seconds: float) -> Record:
    """One arm: the engine with shared and with varied parameters, its rivals, compile times."""
    compiled = compile_times(name, folder, 1 + 2 * (turns > 3))
    loop = bench_loop(name, folder)
    model, skipped = bare_model(loop, name), {}
    contenders = [ours(loop, k) for k in threads]
    contenders += [ours(loop, threads[-1], vary=True), interpreted(loop)]
    contenders += [aba(model, k) for k in threads]
    try:
        arm = mujoco_arm(model)
        contenders += [mujoco_rollout(arm, k) for k in threads]
    except (ImportError, ValueError) as error:
        skipped["MuJoCo"] = str(error).splitlines()[0]
    rows = measured(contenders, turns, seconds)
    return {"joints": loop.arm.n, **compiled, "rows": rows, "skipped": skipped}


def bench_pendulum(threads: list[int], turns: int, seconds: float, quick: bool) -> Record:
    """The pendulum beside JAX and diffrax."""
    try:
        rivals, error, skipped = jax_rivals(threads[-1], quick), jax_error(), {}
    except ImportError as missing:
        rivals, error, skipped = [], None, {"JAX and diffrax": str(missing)}
    loop = closed_loop(FINITE_TIME)
    rows = measured([*(ours(loop, k) for k in threads), *rivals], turns, seconds)
    return {"rows": rows, "skipped": skipped, "jax_error_rad": error}


def bench_paths(threads: int, turns: int, seconds: float, quick: bool) -> list[Record]:
    """The pendulum with few and with many paths."""
    loop = closed_loop(FINITE_TIME)
    counts = PATH_COUNTS[: -1 if quick else None]
    return measured([ours(loop, threads, paths) for paths in counts], min(turns, 4), seconds)


def machine(threads: int) -> Record:
    """What all of this ran on."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = None
    target = host_target()
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "cpu": _cpu_name(),
        "cores": len(os.sched_getaffinity(0)),
        "threads": threads,
        "lanes": target.lanes,
        "exp": target.vector_function("exp", 1)[0],
        "load_before": os.getloadavg()[0],
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": versions,
    }


def _cpu_name() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


# --- the answers -------------------------------------------------------------------------------


def microseconds(rows: list[Record], contender: str, threads: int | None = None) -> float:
    """Of a contender, at its best number of threads or at a given one; NaN if not measured."""
    fitting = (r for r in rows if r["contender"] == contender and threads in (None, r["threads"]))
    return min((row["us"] for row in fitting), default=math.nan)


def ratios(record: Record) -> Record:
    """Others' time per path-step over ours, each at its best number of threads."""
    result: Record = {}
    for name, arm in (*record["arms"].items(), ("paper's pendulum", record["pendulum"])):
        own = microseconds(arm["rows"], "ftcfa")
        others = dict.fromkeys(row["contender"] for row in arm["rows"])
        result[name] = {c: microseconds(arm["rows"], c) / own for c in others if c != "ftcfa"}
    return result


def targets(record: Record) -> list[Record]:
    """What the engine is meant to reach, and whether it does; None where it was not measured."""
    arms, panda = record["arms"], record["ratios"]["panda"]
    rows = [
        _target(f"panda: {name} / ftcfa", panda.get(name), at_least=bound)
        for name, bound in (("aba", 4), ("MuJoCo", 6), ("interpreted", 300))
    ]
    for name, value in record["ratios"]["paper's pendulum"].items():
        bound = 10 if name.startswith("JAX") else 20
        rows.append(_target(f"pendulum: {name} / ftcfa", value, at_least=bound))
    shares = {name: record["ratios"][name]["ftcfa, varied"] for name in arms}
    worst = max(shares, key=lambda name: shares[name])
    rows.append(_target(f"varied / shared parameters ({worst})", shares[worst], at_most=1.3))
    for name, bound in (("panda", 1), ("chain24", 10)):
        seconds = arms[name]["trace_s"] + arms[name]["compile_s"] if name in arms else None
        rows.append(_target(f"{name}: trace and compile, s", seconds, at_most=bound))
    return rows


def _target(
    question: str, value: float | None, at_least: float = -math.inf, at_most: float = math.inf
) -> Record:
    bound = f"<= {at_most:g}" if math.isfinite(at_most) else f">= {at_least:g}"
    met = None if value is None else at_least <= value <= at_most
    return {"target": question, "value": value, "bound": bound, "met": met}


# --- the tables --------------------------------------------------------------------------------


def number(value: float | None) -> str:
    """A number for a table, to three digits or more."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.3g}" if value < 100 else f"{value:,.0f}"


def show(console: Console, title: str, heads: list[str], rows: Iterable[Iterable[object]]) -> None:
    """Print a table of words, counts and measured numbers, its first column to the left."""
    table = plain_table()
    for i, head in enumerate(heads):
        table.add_column(head, justify="right" if i else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(x if isinstance(x, str) else number(x) for x in row))
    console.print(f"\n{title}", highlight=False)
    print_fitted(table, console)


def print_record(record: Record, console: Console) -> None:
    """All tables."""
    host, arms, pendulum = record["machine"], record["arms"], record["pendulum"]
    versions = ", ".join(f"{name} {v}" for name, v in host["versions"].items() if v)
    console.print(
        f"{host['date']}  {host['cpu']}, {host['cores']} cores, {host['lanes']} lanes, "
        f"{host['exp']}, load {host['load_before']:.1f} before\n{versions}",
        highlight=False,
        soft_wrap=True,
    )
    counts = sorted({1, host["threads"]})
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
    show(
        console,
        "Ratios to ftcfa, each at its best number of threads; the code, and what a call costs",
        ["arm", *kinds.values(), "joints", "instructions", "trace s", "compile s", "call ms"],
        (
            [
                name,
                *(record["ratios"][name].get(kind) for kind in kinds),
                *(arm[key] for key in ("joints", "instructions", "trace_s", "compile_s")),
                arm["rows"][0]["call_ms"],
            ]
            for name, arm in arms.items()
        ),
    )
    own = microseconds(pendulum["rows"], "ftcfa")
    show(
        console,
        f"The paper's pendulum, {PATHS:,} paths",
        ["contender", "threads", "us per path-step", "ratio"],
        ([r["contender"], r["threads"], r["us"], r["us"] / own] for r in pendulum["rows"]),
    )
    show(
        console,
        f"The paper's pendulum at {host['threads']} threads",
        ["paths", "us per path-step", "million path-steps/s", "call ms"],
        ([f"{r['paths']:,}", r["us"], 1 / r["us"], r["call_ms"]] for r in record["paths"]),
    )
    answers = {True: "met", False: "NOT MET", None: "not measured"}
    show(
        console,
        "Targets",
        ["", "measured", "wanted", ""],
        ([r["target"], r["value"], r["bound"], answers[r["met"]]] for r in record["targets"]),
    )
    for name, part in (*arms.items(), ("the pendulum", pendulum)):
        for skipped, reason in part["skipped"].items():
            console.print(f"skipped: {skipped} of {name}: {reason}", highlight=False, markup=False)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description="Benchmark of the compiled engine.")
    parser.add_argument("--quick", action="store_true", help="coarse, in under a minute")
    parser.add_argument("--threads", type=int, help="beside one; all cores by default")
    parser.add_argument(
        "--json", metavar="FILE", help="write all numbers there; - for standard output alone"
    )
    options = parser.parse_args()
    threads = options.threads or len(os.sched_getaffinity(0))
    if threads < 1:
        parser.error("--threads: at least 1")
    counts = sorted({1, threads})
    turns, seconds = (3, 0.08) if options.quick else (12, 0.15)
    console = Console(stderr=options.json == "-", width=110)
    record: Record = {"machine": machine(threads), "turns": turns, "seconds_a_turn": seconds}
    with tempfile.TemporaryDirectory() as name, console.status("") as status:
        for n in (12, 24):
            write_chain(n, Path(name))
        record["arms"] = {}
        for arm in ARMS[: -1 if options.quick else None]:
            status.update(arm)
            record["arms"][arm] = bench_arm(arm, Path(name), counts, turns, seconds)
        status.update("JAX and diffrax")
        record["pendulum"] = bench_pendulum(counts, turns, seconds, options.quick)
        status.update("paths")
        record["paths"] = bench_paths(threads, turns, seconds, options.quick)
    record["ratios"] = ratios(record)
    record["targets"] = targets(record)
    print_record(record, console)
    if options.json == "-":
        print(json.dumps(record, indent=2))
    elif options.json:
        Path(options.json).write_text(json.dumps(record, indent=2) + "\n")


if __name__ == "__main__":
    main()
