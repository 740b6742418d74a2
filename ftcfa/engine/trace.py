"""Trace a closed loop: its own Python functions, run once on symbols, become straight-line code."""

import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired
from ftcfa.engine.flatten import leaves, like, size
from ftcfa.engine.parameters import parameter, preparation, replace_parts, with_parameter
from ftcfa.errors import TracingError
from ftcfa.loop.closed_loop import ClosedLoop, LoopState, alive
from ftcfa.model.arm import Arm
from ftcfa.model.traced import symbols, traced


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """One sample of a closed loop as straight-line code on flat vectors.

    Attributes:
        init: (desired, parameters) -> state.
        first: (state, desired, normals, parameters) -> (state, signals, torque, alive): the
            controller and the first integration step.
        further: (state, torque, normals, parameters) -> state: one more integration step, or None.
        signals: Name and shape of the recorded signals.
        channels: Standard normal deviates an integration step.
        substeps: Integration steps a sample.
        preparations: For each varied parameter, what turns its values, shape (paths, ...), into
            inputs of the code, shape (paths, entries).
    """

    init: ca.Function
    first: ca.Function
    further: ca.Function | None
    signals: tuple[tuple[str, tuple[int, ...]], ...]
    channels: int
    substeps: int
    preparations: tuple[tuple[str, Callable[[Array], Array]], ...] = ()

    @property
    def recorded(self) -> int:
        """Entries of the recorded signals."""
        return int(self.first.nnz_out(1))

    @property
    def joints(self) -> int:
        """Entries of the torque."""
        return int(self.first.nnz_out(2))


def trace(loop: ClosedLoop, names: Sequence[str], varied: Sequence[str] = ()) -> TracedLoop:
    """Trace a loop.

    Args:
        loop: The closed loop.
        names: Signals to give out.
        varied: Parameters that are inputs of the code; all others are constants of it.

    Raises:
        TracingError: If a law cannot be traced; it names the line and the reason.
    """
    known = _traced.setdefault(loop, {})
    key = (tuple(names), tuple(varied))
    if key not in known:
        known[key] = _trace_anew(loop, names, varied)
    return known[key]


_traced: WeakKeyDictionary[ClosedLoop, dict[Any, TracedLoop]] = WeakKeyDictionary()


def _trace_anew(loop: ClosedLoop, names: Sequence[str], varied: Sequence[str]) -> TracedLoop:
    desired = Desired(*(row[0] for row in loop.reference.at(np.zeros(1))))
    template = loop.init(desired)
    shapes = loop.signal_shapes()
    try:
        twin = replace_parts(loop, _twin)
        inputs, preparations = [], []
        for i, name in enumerate(varied):
            value = parameter(loop, name)
            prepare = preparation(twin, name)
            prepared = prepare(value[None])[0]
            symbol = symbols(f"p{i}", max(1, size(prepared)))
            twin = with_parameter(twin, name, symbol.reshape(np.shape(prepared)))
            inputs.append(symbol)
            preparations.append((name, prepare))
        code = _trace(twin, template, {name: shapes[name] for name in names}, inputs)
        return replace(code, preparations=tuple(preparations))
    except TracingError:
        raise
    except Exception as error:
        raise _not_traceable(error) from error


def _trace(
    loop: ClosedLoop, template: LoopState, shapes: dict[str, tuple[int, ...]], inputs: list[Array]
) -> TracedLoop:
    n = loop.arm.n
    state = like(template, iter([_symbol_like(leaf) for leaf in leaves(template)]))
    desired = Desired(*(symbols(name, n) for name in Desired._fields))
    normals = symbols("normals", loop.channels)
    parameters = _flat(inputs)

    signals, controller = loop.control(state, desired)
    q, v = loop.advance(state.q, state.v, signals["u"], normals)
    after = LoopState(q, v, controller)
    kept = [signals[name] for name in shapes]
    first = _function(
        "first",
        [_flat(leaves(state)), _flat(desired), _flat([normals]), parameters],
        [_flat(leaves(after)), _flat(kept), _flat([signals["u"]]), _flat([alive(state)])],
    )
    further = None
    if loop.substeps > 1:
        u = symbols("u", n)
        q, v = loop.advance(state.q, state.v, u, normals)
        further = _function(
            "further",
            [_flat([state.q, state.v]), _flat([u]), _flat([normals]), parameters],
            [_flat([q, v])],
        )
    init = _function("init", [_flat(desired), parameters], [_flat(leaves(loop.init(desired)))])
    return TracedLoop(init, first, further, tuple(shapes.items()), loop.channels, loop.substeps)


def _twin(part: Any) -> Any:
    return traced(part) if isinstance(part, Arm) else part


def _symbol_like(leaf: Array) -> Array:
    shape = np.shape(leaf)
    return symbols("x", *(shape or (1,))).reshape(shape)


def _flat(arrays: Sequence[Array]) -> ca.SX:
    """All entries of some arrays, row by row, as one column."""
    columns = [
        ca.vec(ca.densify(a.reshape((size(a),)).to_casadi()))
        if isinstance(a, ca.ArrayInterface)
        else ca.SX(ca.DM(np.ravel(np.asarray(a, dtype=float))))
        for a in arrays
    ]
    return ca.vertcat(*columns) if columns else ca.SX(0, 1)


def _function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    return ca.Function(name, inputs, outputs, {"cse": True})


def _not_traceable(error: Exception) -> TracingError:
    """The user's line at which tracing failed: the last one outside CasADi and NumPy."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if "casadi" not in f.filename and "numpy" not in f.filename]
    where = own[-1] if own else frames[-1]
    reason = (str(error) or "no reason given").splitlines()[0]
    return TracingError(
        f"{where.filename}, line {where.lineno}: {where.line}",
        f"cannot be traced ({type(error).__name__}: {reason})",
        "NumPy expressions without branches on values",
        "use np.where instead of if, and NumPy instead of math",
    )
