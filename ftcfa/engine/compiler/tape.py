"""Translation of CasADi's tape to vector assembly, each operation as NumPy defines it."""

from collections.abc import Callable, Sequence

import casadi as ca

from ftcfa.engine.compiler.assembly import Assembly, Entries
from ftcfa.errors import TracingError


def lower(asm: Assembly, function: ca.Function, inputs: Sequence[Entries]) -> list[list[str]]:
    """Append a CasADi function's tape.

    Args:
        asm: Code to append to.
        function: A function of symbols; all its outputs are dense columns.
        inputs: Entries of each of its inputs.

    Returns:
        Values of its outputs, entry by entry.
    """
    work: dict[int, str] = {}
    masks: dict[int, str] = {}
    outputs = [[""] * function.nnz_out(i) for i in range(function.n_out())]

    def number(register: int) -> str:
        if register not in work:
            ones, zeros = asm.constant(1.0), asm.constant(0.0)
            work[register] = asm.select(masks[register], ones, zeros)
        return work[register]

    def mask(register: int) -> str:
        if register not in masks:
            masks[register] = asm.compare("une", work[register], asm.constant(0.0))
        return masks[register]

    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        sources, targets = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[targets[0]][targets[1]] = number(sources[0])
            continue
        if operation == ca.OP_INPUT:
            result = inputs[sources[0]](sources[1])
        elif operation == ca.OP_CONST:
            result = asm.constant(function.instruction_constant(k))
        elif operation in _LOGIC:
            result = _LOGIC[operation](asm, *(mask(r) for r in sources))
        elif operation == ca.OP_IF_ELSE_ZERO:
            result = asm.select(mask(sources[0]), number(sources[1]), asm.constant(0.0))
        else:
            result = _numeric(operation)(asm, *(number(r) for r in sources))
        work.pop(targets[0], None)
        masks.pop(targets[0], None)
        (masks if operation in _LOGIC or operation in _COMPARISONS else work)[targets[0]] = result
    return outputs


def _maximum(asm: Assembly, x: str, y: str, predicate: str = "ogt") -> str:
    """NumPy's maximum (or minimum): NaN if either is NaN."""
    larger = asm.select(asm.compare(predicate, x, y), x, y)
    return asm.select(asm.compare("uno", x, x), x, larger)


def _sign(asm: Assembly, x: str) -> str:
    """NumPy's sign: that of zero is zero, that of NaN is NaN."""
    zero = asm.constant(0.0)
    negative = asm.select(asm.compare("olt", x, zero), asm.constant(-1.0), x)
    return asm.select(asm.compare("ogt", x, zero), asm.constant(1.0), negative)


Numeric = Callable[..., str]

_LOGIC: dict[int, Numeric] = {
    ca.OP_NOT: lambda asm, x: asm.emit(f"xor {asm.mask} {x}, {asm.splat('i1', 'true')}"),
    ca.OP_AND: lambda asm, x, y: asm.emit(f"and {asm.mask} {x}, {y}"),
    ca.OP_OR: lambda asm, x, y: asm.emit(f"or {asm.mask} {x}, {y}"),
}
_COMPARISONS: dict[int, Numeric] = {
    ca.OP_LT: lambda asm, x, y: asm.compare("olt", x, y),
    ca.OP_LE: lambda asm, x, y: asm.compare("ole", x, y),
    ca.OP_EQ: lambda asm, x, y: asm.compare("oeq", x, y),
    ca.OP_NE: lambda asm, x, y: asm.compare("une", x, y),
}
_ARITHMETIC: dict[int, Numeric] = {
    ca.OP_ADD: lambda asm, x, y: asm.arithmetic("fadd", x, y),
    ca.OP_SUB: lambda asm, x, y: asm.arithmetic("fsub", x, y),
    ca.OP_MUL: lambda asm, x, y: asm.arithmetic("fmul", x, y),
    ca.OP_DIV: lambda asm, x, y: asm.arithmetic("fmul", x, asm.reciprocal(y)),
    ca.OP_SQ: lambda asm, x: asm.arithmetic("fmul", x, x),
    ca.OP_TWICE: lambda asm, x: asm.arithmetic("fadd", x, x),
    ca.OP_INV: lambda asm, x: asm.reciprocal(x),
    ca.OP_NEG: lambda asm, x: asm.emit(f"fneg {asm.vector} {x}"),
    ca.OP_ASSIGN: lambda asm, x: x,  # noqa: ARG005
    ca.OP_SIGN: _sign,
    ca.OP_FMAX: _maximum,
    ca.OP_FMIN: lambda asm, x, y: _maximum(asm, x, y, "olt"),
}


def _functions(names: str) -> dict[int, str]:
    """Names of functions by CasADi's operation, such as "sin" by OP_SIN."""
    return {getattr(ca, f"OP_{name.upper()}"): name for name in names.split()}


_INTRINSICS = _functions("sqrt fabs floor ceil copysign")
_ELEMENTARY = {
    **_functions("sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log expm1 log1p"),
    **_functions("erf pow atan2 hypot fmod remainder"),
    ca.OP_CONSTPOW: "pow",
}


def _numeric(operation: int) -> Numeric:
    """Function that appends an operation on numbers; TracingError if there is none."""
    if operation in _ARITHMETIC:
        return _ARITHMETIC[operation]
    if operation in _COMPARISONS:
        return _COMPARISONS[operation]
    if operation in _INTRINSICS:
        return lambda asm, *x: asm.intrinsic(_INTRINSICS[operation], *x)
    if operation in _ELEMENTARY:
        return lambda asm, *x: asm.elementary(_ELEMENTARY[operation], *x)
    names = [name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == operation]
    subject = f"operation {names[0].removeprefix('OP_').lower()}"
    expected = "arithmetic, comparisons and elementary functions"
    raise TracingError(subject, "cannot be compiled", expected, 'use engine="interpreted"')
