"""Tracing of a closed loop: its own Python, run once on symbols, becomes straight-line code."""

import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array, Traceable
from ftcfa.control.protocol import Desired
from ftcfa.engine.compiler import agreement
from ftcfa.engine.compiler.agreement import AGAIN, DRIVE, MEMORY, MOTION, START, Sample
from ftcfa.engine.compiler.constant_states import constant_entries, known_values
from ftcfa.engine.compiler.effect import idle_parameters
from ftcfa.engine.compiler.flatten import flat, leaves, like, size, split
from ftcfa.engine.interrupts import interrupts_wait
from ftcfa.errors import ParameterError, TracingError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.parameters import parameter, preparation, with_parameters
from ftcfa.loop.state import LoopState, bounded
from ftcfa.loop.twin import twin
from ftcfa.model.symbols import SymbolArray, column, symbols
from ftcfa.parts import fields_of

Arrays = Sequence[Traceable]


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """One sample of a closed loop as straight-line code on flat vectors.

    Attributes:
        init: (desired, normals, parameters) -> state.
        first: (state, desired, normals, row, deviates, parameters) -> (state, signals, drive,
            bounded): the controller and the first integration step.
        further: (motion, drive, normals, row, parameters) -> motion: one more integration step, or
            None.
        renewed: (state, desired, parameters) -> state of the controller, as `init` gives it; in
            the loop's state it stands after the motion and before `LoopState.restart`.
        streams: Random streams of a sample, and how many of the ``deviates`` each gives.
        motion: Number of entries of the motion, the first ones of the loop's state.
        signals: Name and shape of each recorded signal.
        observer: State of the observer, the last entries of the loop's; () if there is none.
        substeps: Integration steps a sample.
        constant: Whether each entry of the loop's state stays what `init` makes of it, such as the
            paper's s2: the code holds its value and does not read it, shape (states,).
        preparations: Name of each varied parameter, and the function that turns its values, shape
            (paths, ...), into inputs of the code, shape (paths, ...).
    """

    init: ca.Function
    first: ca.Function
    further: ca.Function | None
    renewed: ca.Function
    signals: tuple[tuple[str, tuple[int, ...]], ...]
    observer: Any
    substeps: int
    streams: Mapping[int, int]
    motion: int
    constant: npt.NDArray[np.bool_]
    preparations: tuple[tuple[str, Callable[[Array], Array]], ...] = ()

    @property
    def recorded(self) -> int:
        """Number of entries of the recorded signals."""
        return int(self.first.nnz_out(1))

    @property
    def driven(self) -> int:
        """Number of entries of what drives the motors."""
        return int(self.first.nnz_out(2))


def trace(loop: ClosedLoop, names: Sequence[str], varied: Sequence[str] = ()) -> TracedLoop:
    """Code of a loop, traced anew unless the code of an earlier call still agrees with it.

    Args:
        loop: The closed loop.
        names: Signals to record.
        varied: Parameters that are inputs of the code; all others are constants of it.

    Raises:
        TracingError: If a law cannot be traced, with the line and the reason; or if the code gives
            other numbers than the loop itself.
        ParameterError: If the motion does not depend on a varied parameter.
    """
    key = (tuple(names), tuple(varied))
    with _lock, interrupts_wait():
        known = _traced.setdefault(loop, {})
        code = known.pop(key, None)
        try:
            if code is None or not _agrees(loop, code):
                agreement.check_pure(loop)  # before symbols can get into a state that a law hides
                code = _trace_anew(loop, names, varied)
                _prove(loop, code)
        except TracingError:
            raise
        except Exception as error:
            raise _not_traceable(loop, error) from error
        for name in _idle(loop, code):
            got, expected = "no effect on the motion", "a number that the loop computes with"
            raise ParameterError(f"varied {name}", got, expected)
        known[key] = code
        return code


_traced: WeakKeyDictionary[ClosedLoop, dict[Any, TracedLoop]] = WeakKeyDictionary()
_lock = threading.RLock()


def _trace_anew(loop: ClosedLoop, names: Sequence[str], varied: Sequence[str]) -> TracedLoop:
    desired = loop.first_desired
    template = loop.init(desired)
    shapes = loop.signal_shapes()
    loop_twin: ClosedLoop = twin(loop)
    preparations = tuple((name, preparation(loop_twin, name)) for name in varied)
    inputs, values = [], {}
    for i, (name, prepare) in enumerate(preparations):
        prepared = prepare(parameter(loop, name)[None])[0]
        inputs.append(symbols(f"p{i}", max(1, size(prepared))))
        values[name] = inputs[-1].reshape(np.shape(prepared))
    loop_twin = with_parameters(loop_twin, values)
    _, drive, _ = loop.control(template, desired)
    code = _trace(loop_twin, template, drive, {name: shapes[name] for name in names}, inputs)
    return replace(code, preparations=preparations)


def without_effect(loop: ClosedLoop, varied: Sequence[str]) -> tuple[str, ...]:
    """Those of some parameters on which the motion does not depend.

    Raises:
        TracingError: If the loop cannot be traced.
    """
    with _lock, interrupts_wait():
        try:
            return _idle(loop, _trace_anew(loop, (), varied))
        except TracingError:
            raise
        except Exception as error:
            raise _not_traceable(loop, error) from error


def _idle(loop: ClosedLoop, code: TracedLoop) -> tuple[str, ...]:
    """Names of the varied parameters of code on which the motion does not depend."""
    return idle_parameters(loop, (code.init, code.first), code.preparations)


def _agrees(loop: ClosedLoop, code: TracedLoop) -> bool:
    """Whether code that was traced before still agrees with a loop, whose laws may have changed."""
    try:
        _prove(loop, code, agreement.AGAIN_SAMPLES)
    except Exception:  # other numbers, or states of another size
        return False
    return True


def _prove(loop: ClosedLoop, code: TracedLoop, count: int = agreement.SAMPLES) -> None:
    """Raise TracingError if code differs from the loop at slightly changed parameters."""
    rng = np.random.default_rng(0)
    values = {
        name: parameter(loop, name) * (1.0 + agreement.DISTURBANCE * rng.standard_normal())
        for name, _ in code.preparations  # a factor: a body stays a body
    }
    columns = [prepare(values[name][None]).ravel() for name, prepare in code.preparations]
    parameters = np.concatenate([np.zeros(0), *columns])
    loop = with_parameters(loop, values)

    def by_code(sample: Sample) -> Iterator[tuple[str, Array]]:
        desired, motion = flat(sample.desired), flat(sample.state.motion)
        if START in sample.results:
            yield START, _numbers(code.init(desired, sample.initial, parameters))
        noise = (sample.normals, sample.row)
        first = code.first(flat(sample.state), desired, *noise, sample.deviates, parameters)
        after, signals, drive, _ = map(_numbers, first)
        arrays = split(signals, [shape for _, shape in code.signals])
        yield from (
            (name, array.ravel()) for (name, _), array in zip(code.signals, arrays, strict=True)
        )
        yield DRIVE, drive
        if AGAIN in sample.results:
            yield AGAIN, _numbers(code.renewed(flat(sample.state), desired, parameters))
        yield MEMORY, after[len(motion) :]
        yield MOTION, after[: len(motion)]
        if code.further is not None:
            yield MOTION, _numbers(code.further(motion, drive, *noise, parameters))

    agreement.check_agreement(loop, by_code, code.constant, count)


def _numbers(column: ca.DM) -> Array:
    return np.asarray(column).ravel()


def _trace(
    loop: ClosedLoop,
    template: LoopState,
    held: Any,
    shapes: dict[str, tuple[int, ...]],
    inputs: list[Traceable],
) -> TracedLoop:
    """Code of a loop's twin that holds symbols, for a state and a drive like the given ones."""
    n = loop.arm.n
    state = like(template, iter([_symbol_like(leaf) for leaf in leaves(template)]))
    desired = Desired(*(symbols(name, n) for name in Desired._fields))
    normals = symbols("normals", loop.process.normals)
    row = symbols("row", loop.process.rows.shape[1])
    noise = [normals], [row]
    deviates = symbols("deviates", sum(loop.streams.values()))
    signals, drive, after = loop.control(state, desired, deviates)
    motion = loop.advance(state.motion, drive, normals, row)
    after = after._replace(motion=motion)
    _check_sizes(loop, template, after)
    recorded = [signals[name] for name in shapes]
    results = leaves(after), recorded, leaves(drive), [bounded(state)]
    further = None
    if loop.substeps > 1:
        held = like(held, iter([_symbol_like(leaf) for leaf in leaves(held)]))
        motion = loop.advance(state.motion, held, normals, row)
        arguments = [leaves(state.motion), leaves(held), *noise, inputs]
        further = _function("further", arguments, [leaves(motion)])
    initial = symbols("initial", loop.process.initial_normals)
    start = leaves(loop.init(desired, initial))
    init = _function("init", [desired, [initial], inputs], [start])
    again = leaves(loop.renewed(state, desired))
    renewed = _function("renewed", [leaves(state), desired, inputs], [again])
    renewal = _flat([*leaves(state.motion), *again, *leaves(state[2:])])
    constant = constant_entries(_flat(leaves(state)), _flat(start), _flat(results[0]), renewal)
    columns = [_flat(arrays) for arrays in results]
    columns = ca.substitute(columns, *known_values(_flat(leaves(state)), _flat(start), constant))
    first = _function("first", [leaves(state), desired, *noise, [deviates], inputs], columns)
    return TracedLoop(
        init=init,
        first=first,
        further=further,
        renewed=renewed,
        signals=tuple(shapes.items()),
        observer=template.observer,
        substeps=loop.substeps,
        streams=loop.streams,
        motion=sum(size(leaf) for leaf in leaves(template.motion)),
        constant=constant,
    )


def _symbol_like(leaf: Array) -> Traceable:
    shape = np.shape(leaf)
    return symbols("x", *(shape or (1,))).reshape(shape)


def _function(name: str, inputs: Iterable[Arrays], outputs: Iterable[Any]) -> ca.Function:
    """Function of columns, each of which holds all entries of some arrays or is one already."""
    columns = [x if isinstance(x, ca.SX) else _flat(x) for x in outputs]
    return ca.Function(name, list(map(_flat, inputs)), columns, {"cse": True})


def _flat(arrays: Arrays) -> ca.SX:
    """All entries of some arrays as one column, each array row by row."""
    columns = [ca.densify(column(a.reshape((size(a),)))) for a in map(_array, arrays)]
    return ca.vertcat(*columns) if columns else ca.SX(0, 1)


def _array(a: Any) -> Any:
    """What a law returned as an array of symbols or of floats."""
    return a if isinstance(a, SymbolArray) else np.asarray(a, dtype=float)


def _check_sizes(loop: ClosedLoop, before: LoopState, after: LoopState) -> None:
    states = [(state.motion, state.controller, state.observer) for state in (before, after)]
    sizes = [sum(size(leaf) for leaf in leaves(state)) for state in states]
    if sizes[0] != sizes[1]:
        got = f"{sizes[0]} numbers from init, {sizes[1]} from step (q and v among them)"
        subject, remedy = type(loop.controller).__name__, "let init return a state of full size"
        raise TracingError(f"state of {subject}", got, "as many", remedy)


def _not_traceable(loop: ClosedLoop, error: Exception) -> TracingError:
    """The error that names the line at which tracing failed: the user's last one, else ours."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if not f.filename.startswith(_LIBRARIES)]
    users = [f for f in ours if not f.filename.startswith(_PACKAGE)]
    where = (users or ours or frames)[-1]
    reason = (str(error) or "no reason given").splitlines()[0]
    remedy = "use np.where for if, np.stack for np.array, np.logical_and for &, and NumPy for math"
    for part in (loop.controller, loop.vibration and loop.vibration.input):
        if part is not None and not fields_of(part):
            remedy += f"; if {type(part).__name__} holds an Arm, make it a frozen dataclass"
            remedy += " with the Arm in a field"
    subject = f"{where.filename}, line {where.lineno}: {where.line}"
    got = f"cannot be traced ({type(error).__name__}: {reason})"
    return TracingError(subject, got, "NumPy expressions without branches on values", remedy)


_PACKAGE = str(Path(__file__).parents[2])
_LIBRARIES = tuple(str(Path(str(library.__file__)).parent) for library in (ca, np, threading))
