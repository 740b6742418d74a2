"""Translation of CasADi's tape to vector assembly, each operation as NumPy defines it."""

from collections.abc import Callable, Sequence

import casadi as ca

from ftcfa.engine.compiler.assembly import Assembly, Entries
from ftcfa.engine.compiler.kernels.power import constant_power
from ftcfa.engine.compiler.kernels.table import FUNCTIONS
from ftcfa.errors import TracingError


def lower(asm: Assembly, function: ca.Function, inputs: Sequence[Entries]) -> list[list[str]]:
    """Append a CasADi function's tape.

    A product that is used once, in a sum or a difference, is fused with it. LLVM fuses nothing, so
    that the same tape gives the same bits on every machine.

    Args:
        asm: Code to append to.
        function: A function of symbols; all its outputs are dense columns.
        inputs: Entries of each of its inputs.

    Returns:
        Values of its outputs, entry by entry.
    """
    outputs = [[""] * function.nnz_out(i) for i in range(function.n_out())]
    registers: dict[int, _Value] = {}
    fusible = _fusible(function)
    for k in range(function.n_instructions()):
        asm.break_block()
        operation = function.instruction_id(k)
        sources, targets = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            outputs[targets[0]][targets[1]] = registers[sources[0]].number
            continue
        if operation == ca.OP_INPUT:
            result = _Value(asm, inputs[sources[0]](sources[1]))
        elif operation == ca.OP_CONST:
            value = function.instruction_constant(k)
            result = _Value(asm, asm.constant(value), constant=value)
        else:
            result = _computed(asm, operation, [registers[r] for r in sources], k in fusible)
        registers[targets[0]] = result
    return outputs


class _Value:
    """The value of a register: a number, a mask, or what is not computed before it is used.

    That is a product, which a sum may fuse; and a number where a condition holds, zero elsewhere,
    of which a sum makes one choice between two.
    """

    def __init__(
        self,
        asm: Assembly,
        number: str = "",
        mask: str = "",
        factors: tuple[str, str] | None = None,
        constant: float | None = None,
        nonnegative: bool = False,
        chosen: "tuple[_Value, _Value] | None" = None,
        opposite: "_Value | None" = None,
    ) -> None:
        self.asm, self._number, self._mask = asm, number, mask
        self.factors, self.constant, self.nonnegative = factors, constant, nonnegative
        self.chosen, self.opposite = chosen, opposite

    @property
    def number(self) -> str:
        """The value as doubles."""
        if not self._number:
            if self.factors:
                self._number = self.asm.mul(*self.factors)
            elif self.chosen:
                condition, value = self.chosen
                zero = self.asm.constant(0.0)
                self._number = self.asm.select(condition.mask, value.number, zero)
            else:
                one, zero = self.asm.constant(1.0), self.asm.constant(0.0)
                self._number = self.asm.select(self._mask, one, zero)
        return self._number

    @property
    def mask(self) -> str:
        """The value as a mask: the lanes in which it is not zero."""
        if not self._mask:
            self._mask = self.asm.compare("une", self.number, self.asm.constant(0.0))
        return self._mask


def _fusible(function: ca.Function) -> set[int]:
    """Numbers of the instructions that make a product which one sum or difference alone uses."""
    made: dict[int, int] = {}
    uses: dict[int, list[int]] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        if operation != ca.OP_INPUT:
            for register in function.instruction_input(k):
                uses.setdefault(made[register], []).append(operation)
        if operation != ca.OP_OUTPUT:
            made[function.instruction_output(k)[0]] = k
    return {
        k
        for k, operations in uses.items()
        if function.instruction_id(k) in _PRODUCTS
        and len(operations) == 1
        and operations[0] in (ca.OP_ADD, ca.OP_SUB)
    }


def _computed(asm: Assembly, operation: int, sources: list[_Value], fused: bool) -> _Value:
    """The value of an operation on registers."""
    if operation == ca.OP_NOT:
        return _Value(asm, mask=asm.invert(sources[0].mask), opposite=sources[0])
    if operation in _LOGIC:
        return _Value(asm, mask=_LOGIC[operation](asm, *(x.mask for x in sources)))
    if operation in _COMPARISONS:
        return _Value(asm, mask=_COMPARISONS[operation](asm, *(x.number for x in sources)))
    if operation == ca.OP_IF_ELSE_ZERO:
        return _Value(asm, chosen=(sources[0], sources[1]))
    if operation in _PRODUCTS:
        factors = _PRODUCTS[operation](asm, *(x.number for x in sources))
        return _Value(asm, factors=factors) if fused else _Value(asm, asm.mul(*factors))
    if operation in (ca.OP_ADD, ca.OP_SUB):
        return _Value(asm, _sum(asm, *sources, subtract=operation == ca.OP_SUB))
    if operation in (ca.OP_FMAX, ca.OP_FMIN):
        return _Value(asm, _extreme(asm, *sources, larger=operation == ca.OP_FMAX))
    if operation in (ca.OP_POW, ca.OP_CONSTPOW) and sources[1].constant is not None:
        return _power(asm, *sources)
    value = _numeric(operation)(asm, *(x.number for x in sources))
    return _Value(asm, value, nonnegative=operation in _NONNEGATIVE)


def _power(asm: Assembly, x: _Value, a: _Value) -> _Value:
    """A power with a constant exponent."""
    assert a.constant is not None
    return _Value(asm, constant_power(asm, x.number, a.constant, x.nonnegative))


def _sum(asm: Assembly, x: _Value, y: _Value, *, subtract: bool) -> str:
    """The sum x + y or difference x - y, fused with a product; of two products with the first."""
    if x.chosen and y.chosen and not subtract and y.chosen[0].opposite is x.chosen[0]:
        return asm.select(x.chosen[0].mask, x.chosen[1].number, y.chosen[1].number)
    if x.factors:
        return asm.fma(*x.factors, asm.negative(y.number) if subtract else y.number)
    if y.factors:
        a, b = y.factors
        return asm.fma(asm.negative(a) if subtract else a, b, x.number)
    return asm.sub(x.number, y.number) if subtract else asm.add(x.number, y.number)


def _extreme(asm: Assembly, x: _Value, y: _Value, *, larger: bool) -> str:
    """NumPy's maximum or minimum: NaN if either is NaN."""
    if x.constant is not None:
        x, y = y, x
    beyond = "olt" if larger else "ogt"
    value = asm.select(asm.compare(beyond, x.number, y.number), y.number, x.number)
    if y.constant is not None:
        return value  # x where x is NaN
    return asm.select(asm.compare("uno", y.number, y.number), y.number, value)


def _sign(asm: Assembly, x: str) -> str:
    """NumPy's sign: that of zero is zero, that of NaN is NaN."""
    one = asm.intrinsic("copysign", asm.constant(1.0), x)
    return asm.select(asm.compare("one", x, asm.constant(0.0)), one, x)


Numeric = Callable[..., str]

_LOGIC: dict[int, Numeric] = {
    ca.OP_AND: lambda asm, x, y: asm.both(x, y),
    ca.OP_OR: lambda asm, x, y: asm.either(x, y),
}
_COMPARISONS: dict[int, Numeric] = {
    ca.OP_LT: lambda asm, x, y: asm.compare("olt", x, y),
    ca.OP_LE: lambda asm, x, y: asm.compare("ole", x, y),
    ca.OP_EQ: lambda asm, x, y: asm.compare("oeq", x, y),
    ca.OP_NE: lambda asm, x, y: asm.compare("une", x, y),
}
_ARITHMETIC: dict[int, Numeric] = {
    ca.OP_TWICE: lambda asm, x: asm.add(x, x),
    ca.OP_INV: lambda asm, x: asm.reciprocal(x),
    ca.OP_NEG: lambda asm, x: asm.negative(x),
    ca.OP_ASSIGN: lambda asm, x: x,  # noqa: ARG005
    ca.OP_SIGN: _sign,
}
_PRODUCTS: dict[int, Callable[..., tuple[str, str]]] = {
    ca.OP_MUL: lambda asm, x, y: (x, y),  # noqa: ARG005
    ca.OP_DIV: lambda asm, x, y: (x, asm.reciprocal(y)),
    ca.OP_SQ: lambda asm, x: (x, x),  # noqa: ARG005
}
"""The factors of a product, or of a quotient."""


def _functions(names: str) -> dict[int, str]:
    """Names of functions by CasADi's operation, such as "sin" by OP_SIN."""
    return {getattr(ca, f"OP_{name.upper()}"): name for name in names.split()}


_INTRINSICS = _functions("sqrt fabs floor ceil copysign")
_KERNELS = _functions(" ".join(FUNCTIONS))
_EXACT = _functions("fmod remainder")
_NONNEGATIVE = _functions("fabs sqrt exp cosh").keys()


def _numeric(operation: int) -> Numeric:
    """Function that appends an operation on numbers; TracingError if there is none."""
    if operation in _ARITHMETIC:
        return _ARITHMETIC[operation]
    if operation in _INTRINSICS:
        return lambda asm, *x: asm.intrinsic(_INTRINSICS[operation], *x)
    if operation in _KERNELS:
        return FUNCTIONS[_KERNELS[operation]]
    if operation in _EXACT:
        return lambda asm, *x: asm.exact(_EXACT[operation], *x)
    names = [name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == operation]
    subject = f"operation {names[0].removeprefix('OP_').lower()}"
    expected = "arithmetic, comparisons and elementary functions"
    raise TracingError(subject, "cannot be compiled", expected, 'use engine="interpreted"')
