"""A traced loop as machine code: the time loop, the noise and the recording inside."""

import ctypes
import math
import threading
from collections import OrderedDict
from dataclasses import dataclass
from hashlib import sha256
from typing import Any
from weakref import WeakKeyDictionary

import casadi as ca
import llvmlite.binding as llvm

from ftcfa.engine.compiler.assembly import Assembly, Entries
from ftcfa.engine.compiler.normals import normals, on_demand
from ftcfa.engine.compiler.tape import lower
from ftcfa.engine.compiler.target import Target
from ftcfa.engine.compiler.trace import TracedLoop
from ftcfa.loop.state import HALF
from ftcfa.streams import INITIAL_STATE, PLANT_NOISE

CACHED_PROGRAMS = 64
OPTIMISATION = {"init": 0, "run": 2}
"""Levels of LLVM's code generator: ``init`` runs once a path, ``run`` at every tick."""

_C_LIBRARY = ctypes.CDLL(None)
_P, _I = ctypes.c_void_p, ctypes.c_int64
_INIT = ctypes.CFUNCTYPE(None, _P, _P, _P, _P, _I)
_RUN = ctypes.CFUNCTYPE(None, _P, _P, _P, _P, _I, _P, _I, _P, _I, _I, _I, _P, _I, _P)
_SIGNATURES = {
    "init": "ptr %state, ptr %parameters, ptr %desired, ptr %paths, i64 %seed",
    "run": "ptr %state, ptr %parameters, ptr %desired, ptr %paths, i64 %seed, ptr %rows, "
    "i64 %row_count, ptr %first_rows, i64 %tick0, i64 %ticks, i64 %every, ptr %record, "
    "i64 %stride, ptr %diverged_at",
}


@dataclass(frozen=True, eq=False)
class Program:
    """Compiled code for a block of as many paths as a vector has lanes.

    All arrays of doubles hold a path a lane. The code has no global state and runs without the
    interpreter's lock, so blocks run on any threads.

    Attributes:
        init: (state, parameters, first desired row, paths, seed): fills the state.
        run: (state, parameters, desired rows from tick on, paths, seed, rows of the process, their
            number, each path's first row, tick, ticks, record_every, record, stride,
            diverged_at): advances the state by some ticks. The signals of a kept tick go to
            record[lane * stride + row * signals + i]. Where a path diverges, the tick is written
            to diverged_at (NaN before), and its signals are NaN from then on.
        lanes: Number of paths in a block.
        states: Number of entries of a path's state.
        signals: Number of entries of a path's recorded row.
        engines: LLVM's engines, which own the code.
    """

    init: Any
    run: Any
    lanes: int
    states: int
    signals: int
    engines: tuple[llvm.ExecutionEngine, ...]


_programs: WeakKeyDictionary[TracedLoop, dict[Target, Program]] = WeakKeyDictionary()
_cache: OrderedDict[str, Program] = OrderedDict()
_lock = threading.Lock()


def compile_loop(traced: TracedLoop, target: Target) -> Program:
    """Machine code of a traced loop; each is compiled once a process."""
    known = _programs.setdefault(traced, {})
    if target not in known:
        known[target] = _compiled(traced, target)
    return known[target]


def _compiled(traced: TracedLoop, target: Target) -> Program:
    parts = {"init": _init(traced, target), "run": _run(traced, target)}
    texts = {name: _module(name, asm) for name, asm in parts.items()}
    key = sha256("".join([*texts.values(), repr(target)]).encode()).hexdigest()
    with _lock:
        if key not in _cache:
            engines = {
                name: machine_code(texts[name], asm.symbols, target, OPTIMISATION[name])
                for name, asm in parts.items()
            }
            _cache[key] = Program(
                init=_INIT(engines["init"].get_function_address("init")),
                run=_RUN(engines["run"].get_function_address("run")),
                lanes=target.lanes,
                states=traced.init.nnz_out(0),
                signals=traced.recorded,
                engines=tuple(engines.values()),
            )
            if len(_cache) > CACHED_PROGRAMS:
                _cache.popitem(last=False)
        _cache.move_to_end(key)
        return _cache[key]


def machine_code(
    text: str, symbols: set[str], target: Target, level: int = 2
) -> llvm.ExecutionEngine:
    """Machine code of a module's text; ``symbols`` are the functions of the C library in it."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for symbol in symbols:
        llvm.add_symbol(symbol, ctypes.cast(getattr(_C_LIBRARY, symbol), ctypes.c_void_p).value)
    machine = llvm.Target.from_default_triple().create_target_machine(
        target.cpu, target.features, opt=level, jit=True
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    return engine


def _module(name: str, asm: Assembly) -> str:
    """One function as a module's text."""
    head = f"define void @{name}({_SIGNATURES[name]}) {{"
    return "\n".join([*sorted(asm.declarations), head, *asm.lines, "}"])


def _init(traced: TracedLoop, target: Target) -> Assembly:
    """Code of the initial state."""
    asm = Assembly(target)
    desired = _desired(asm, "0", traced.init.nnz_in(0))
    noise = normals(asm, *_keys(asm), asm.word(0), INITIAL_STATE, traced.init.nnz_in(1))
    inputs = [desired, noise.__getitem__, asm.memory("%parameters")]
    (state,) = lower(asm, traced.init, inputs)
    asm.store_all(state, "%state")
    asm.do("ret void")
    return asm


def _run(traced: TracedLoop, target: Target) -> Assembly:
    """Code of the loop over ticks: control, first integration step, recording, further steps."""
    asm, first = Assembly(target), traced.first
    asm.label("entry")
    kept = asm.emit(f"alloca [{traced.recorded + 1} x {asm.vector}], align 64")
    torque = asm.emit(f"alloca [{traced.driven} x {asm.vector}], align 64")
    seed, paths = _keys(asm)
    asm.do("%end = add i64 %tick0, %ticks")
    asm.do("br label %head")

    asm.label("head")
    asm.do("%tick = phi i64 [ %tick0, %entry ], [ %next, %latch ]")
    asm.do("%more = icmp slt i64 %tick, %end")
    asm.do("br i1 %more, label %body, label %exit")

    asm.label("body")
    asm.way_out = ("%more", "exit")  # LLVM does not see that it is never taken
    row = asm.emit("sub i64 %tick, %tick0")
    desired = _desired(asm, row, first.nnz_in(1))
    step = asm.emit(f"mul i64 %tick, {traced.substeps}")
    noise = _noise(asm, first, seed, paths, step)
    _renew(asm, traced, desired)
    deviates = _deviates(asm, traced, seed, paths)
    inputs = [asm.memory("%state"), desired, *noise, deviates, asm.memory("%parameters")]
    after, signals, drive, (bounded,) = lower(asm, first, inputs)
    running = _not_diverged(asm, bounded)
    stores = (after, "%state", 0.0), (signals, kept, math.nan), (drive, torque, 0.0)
    for values, base, if_diverged in stores:
        for i, value in enumerate(values):
            asm.store(asm.select(running, value, asm.constant(if_diverged)), base, i)
    asm.do("%phase = urem i64 %tick, %every")
    asm.do("%keep_it = icmp eq i64 %phase, 0")
    asm.do("br i1 %keep_it, label %keep, label %further")
    asm.label("keep")
    _keep(asm, kept, traced.recorded)
    _further_steps(asm, traced, torque, step, seed, paths)

    asm.label("latch")
    asm.do("%next = add i64 %tick, 1")
    asm.do("br label %head")
    asm.label("exit")
    asm.do("ret void")
    return asm


def _keys(asm: Assembly) -> tuple[str, str]:
    """Vectors of words: the seed, and the numbers of the paths."""
    return asm.broadcast("i64", "%seed"), asm.emit(f"load {asm.words}, ptr %paths, align 8")


def _noise(
    asm: Assembly, function: ca.Function, seed: str, paths: str, step: str
) -> tuple[Entries, Entries]:
    """Deviates and row of one integration step: inputs 2 and 3 of a step's function."""
    now = asm.broadcast("i64", step)
    deviates = normals(asm, seed, paths, now, PLANT_NOISE, function.nnz_in(2))
    columns = function.nnz_in(3)
    row = ["poison"] * columns
    for lane in range(asm.lanes if columns else 0):
        first = asm.emit(f"load i64, ptr {asm.address('%first_rows', lane, 'i64')}, align 8")
        index = asm.emit(f"urem i64 {asm.emit(f'add i64 {first}, {step}')}, %row_count")
        base = asm.address("%rows", asm.emit(f"mul i64 {index}, {columns}"), "double")
        for i in range(columns):
            entry = asm.emit(f"load double, ptr {asm.address(base, i, 'double')}, align 8")
            row[i] = asm.emit(f"insertelement {asm.vector} {row[i]}, double {entry}, i64 {lane}")
    return deviates.__getitem__, row.__getitem__


def _deviates(asm: Assembly, traced: TracedLoop, seed: str, paths: str) -> Entries:
    """Deviates of a sample, those of its streams one after the other, each when it is needed."""
    if not sum(traced.streams.values()):
        return [].__getitem__
    now = asm.broadcast("i64", "%tick")
    entries: list[tuple[Entries, int]] = []
    for stream, count in traced.streams.items():
        draw = on_demand(asm, seed, paths, now, stream)
        entries += [(draw, i) for i in range(count)]

    def deviate(i: int) -> str:
        draw, place = entries[i]
        return draw(place)

    return deviate


def _desired(asm: Assembly, row: str, entries: int) -> Entries:
    """Entries of a row of the desired motion, which all paths share."""
    pointer = asm.address("%desired", asm.emit(f"mul i64 {row}, {entries}"), "double")

    def entry(i: int) -> str:
        scalar = asm.emit(f"load double, ptr {asm.address(pointer, i, 'double')}, align 8")
        return asm.broadcast("double", scalar)

    return entry


def _renew(asm: Assembly, traced: TracedLoop, desired: Entries) -> None:
    """Code that starts a law anew in the lanes where it waits for it; ends with `control`."""
    motion, memory = traced.motion, traced.renewed.nnz_out(0)
    waiting = asm.load("%state", motion + memory)
    due = asm.compare("ogt", waiting, asm.constant(HALF))
    asm.do(f"br i1 {asm.any(due)}, label %renew, label %control")
    asm.label("renew")
    inputs = [asm.memory("%state"), desired, asm.memory("%parameters")]
    (again,) = lower(asm, traced.renewed, inputs)
    for i, value in enumerate([*again, asm.constant(0.0)], start=motion):
        asm.store(asm.select(due, value, asm.load("%state", i)), "%state", i)
    asm.do("br label %control")
    asm.label("control")


def _not_diverged(asm: Assembly, bounded: str) -> str:
    """Write this tick for paths that diverge at it; mask of the paths that have not diverged."""
    tick = asm.broadcast("double", asm.emit("sitofp i64 %tick to double"))
    before = asm.load("%diverged_at", 0)
    unmarked = asm.compare("uno", before, before)
    sound = asm.compare("une", bounded, asm.constant(0.0))
    asm.store(asm.select(sound, before, asm.select(unmarked, tick, before)), "%diverged_at", 0)
    return asm.emit(f"and {asm.mask} {unmarked}, {sound}")


def _keep(asm: Assembly, kept: str, recorded: int) -> None:
    """Copy the kept signals into the record, a path at a time; ends with a jump to `further`."""
    row = asm.emit("udiv i64 %tick, %every")
    start = asm.emit(f"mul i64 {row}, {recorded}")
    asm.do("br label %copy")
    asm.label("copy")
    asm.do("%i = phi i64 [ 0, %keep ], [ %i_next, %copy_one ]")
    asm.do(f"%i_more = icmp slt i64 %i, {recorded}")
    asm.do("br i1 %i_more, label %copy_one, label %further")
    asm.label("copy_one")
    value = asm.load(kept, "%i")
    index = asm.emit(f"add i64 {start}, %i")
    for lane in range(asm.lanes):
        place = asm.emit(f"add i64 {index}, {asm.emit(f'mul i64 %stride, {lane}')}")
        scalar = asm.emit(f"extractelement {asm.vector} {value}, i64 {lane}")
        asm.do(f"store double {scalar}, ptr {asm.address('%record', place, 'double')}, align 8")
    asm.do("%i_next = add i64 %i, 1")
    asm.do("br label %copy")


def _further_steps(
    asm: Assembly, traced: TracedLoop, torque: str, step: str, seed: str, paths: str
) -> None:
    """Code of a tick's integration steps after the first, torque held; begins with `further`."""
    asm.label("further")
    if traced.further is None:
        asm.do("br label %latch")
        return
    asm.do("br label %substep_head")
    asm.label("substep_head")
    asm.do("%k = phi i64 [ 1, %further ], [ %k_next, %substep_end ]")
    asm.do(f"%k_more = icmp slt i64 %k, {traced.substeps}")
    asm.do("br i1 %k_more, label %substep, label %latch")
    asm.label("substep")
    noise = _noise(asm, traced.further, seed, paths, asm.emit(f"add i64 {step}, %k"))
    inputs = [asm.memory("%state"), asm.memory(torque), *noise, asm.memory("%parameters")]
    (after,) = lower(asm, traced.further, inputs)
    asm.store_all(after, "%state")
    asm.do("br label %substep_end")
    asm.label("substep_end")
    asm.do("%k_next = add i64 %k, 1")
    asm.do("br label %substep_head")
