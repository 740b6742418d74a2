"""LLVM assembly for straight-line code on vectors: one path a lane."""

import struct
from collections.abc import Callable, Sequence
from typing import Any

from ftcfa.engine.compiler.target import Target

LONGEST_BLOCK = 1000
"""Lines of a block. LLVM takes more than in proportion to a block's length: of 48 joints' 180,000
lines three times as long in one block as in blocks of 1,000; in shorter ones it takes longer again,
because values pass between them."""
PURE = "nounwind willreturn memory(none)"
"""Attributes that LLVM may assume of an elementary function."""


class Assembly:
    """The body of one function, line by line; values are numbered in their order."""

    def __init__(self, target: Target) -> None:
        self.target = target
        self.lanes = target.lanes
        self.lines: list[str] = []
        self.symbols: set[str] = set()
        self.declarations: set[str] = set()
        self.vector = f"<{self.lanes} x double>"
        self.words = f"<{self.lanes} x i64>"
        self.mask = f"<{self.lanes} x i1>"
        self.way_out: tuple[str, str] | None = None  # a condition that holds, the label if not
        self._count = 0
        self._block_start = 0
        self._known: dict[Any, Any] = {}
        self._opposites: dict[str, str] = {}

    def emit(self, expression: str) -> str:
        """Append an instruction and name its value."""
        self._count += 1
        name = f"%t{self._count}"
        self.lines.append(f"  {name} = {expression}")
        return name

    def do(self, instruction: str) -> None:
        """Append an instruction without a value."""
        self.lines.append(f"  {instruction}")

    def label(self, name: str) -> None:
        """Begin a block; it need not be reached from the last one, so nothing is known of it."""
        self._begin_block(name)
        self._known.clear()

    def break_block(self) -> None:
        """Begin another block if this one is long, and go on there; it needs a `way_out`."""
        if self.way_out and len(self.lines) - self._block_start > LONGEST_BLOCK:
            name = f"part{len(self.lines)}"
            condition, label = self.way_out
            self.do(f"br i1 {condition}, label %{name}, label %{label}")
            self._begin_block(name)

    def _begin_block(self, name: str) -> None:
        self.lines.append(f"{name}:")
        self._block_start = len(self.lines)

    def splat(self, scalar_type: str, literal: str) -> str:
        """A constant in every lane."""
        return "<" + ", ".join([f"{scalar_type} {literal}"] * self.lanes) + ">"

    def constant(self, value: float) -> str:
        """A double in every lane."""
        return self.splat("double", f"0x{struct.pack('>d', value).hex().upper()}")

    def word(self, value: int) -> str:
        """A 64-bit word in every lane."""
        return self.splat("i64", str(value))

    def broadcast(self, scalar_type: str, scalar: str) -> str:
        """A scalar value in every lane."""
        vector = f"<{self.lanes} x {scalar_type}>"
        one = self.emit(f"insertelement {vector} poison, {scalar_type} {scalar}, i64 0")
        zeros = f"<{self.lanes} x i32> zeroinitializer"
        return self.emit(f"shufflevector {vector} {one}, {vector} poison, {zeros}")

    def address(self, base: str, index: str | int, element: str = "") -> str:
        """Pointer to an element (a vector of doubles by default)."""
        return self.emit(f"getelementptr {element or self.vector}, ptr {base}, i64 {index}")

    def load(self, base: str, index: str | int) -> str:
        """A vector of doubles from memory."""
        return self.emit(f"load {self.vector}, ptr {self.address(base, index)}, align 8")

    def memory(self, base: str) -> "Entries":
        """Vectors of doubles from an address on, each loaded where it is needed."""
        return lambda i: self.load(base, i)

    def store(self, value: str, base: str, index: str | int) -> None:
        """A vector of doubles to memory."""
        self.do(f"store {self.vector} {value}, ptr {self.address(base, index)}, align 8")

    def store_all(self, values: Sequence[str], base: str) -> None:
        """Vectors of doubles to memory from an address on."""
        for i, value in enumerate(values):
            self.store(value, base, i)

    def arithmetic(self, operation: str, x: str, y: str) -> str:
        """An arithmetic operation, rounded once; nothing is fused that does not say so."""
        return self.emit(f"{operation} {self.vector} {x}, {y}")

    def add(self, x: str, y: str) -> str:
        """Sum x + y."""
        return self.arithmetic("fadd", x, y)

    def sub(self, x: str, y: str) -> str:
        """Difference x - y."""
        return self.arithmetic("fsub", x, y)

    def mul(self, x: str, y: str) -> str:
        """Product x y."""
        return self.arithmetic("fmul", x, y)

    def div(self, x: str, y: str) -> str:
        """Quotient x/y."""
        return self.arithmetic("fdiv", x, y)

    def negative(self, x: str) -> str:
        """The number of opposite sign."""
        value = self.emit(f"fneg {self.vector} {x}")
        self._opposites[value] = x
        return value

    def unsigned(self, x: str) -> str:
        """A number of the same size: what x was made of by `negative`, or x."""
        return self._opposites.get(x, x)

    def fma(self, x: str, y: str, z: str) -> str:
        """Product and sum x y + z, rounded once."""
        return self.intrinsic("fma", x, y, z)

    def integer(self, operation: str, x: str, y: str) -> str:
        """An operation on words."""
        return self.emit(f"{operation} {self.words} {x}, {y}")

    def bits(self, x: str) -> str:
        """The bits of doubles, as words."""
        return self.emit(f"bitcast {self.vector} {x} to {self.words}")

    def number(self, word: str) -> str:
        """The doubles of some bits."""
        return self.emit(f"bitcast {self.words} {word} to {self.vector}")

    def both(self, a: str, b: str) -> str:
        """Mask of the lanes in which two masks are set."""
        return self.emit(f"and {self.mask} {a}, {b}")

    def either(self, a: str, b: str) -> str:
        """Mask of the lanes in which one of two masks is set."""
        return self.emit(f"or {self.mask} {a}, {b}")

    def invert(self, mask: str) -> str:
        """Mask of the other lanes."""
        return self.emit(f"xor {self.mask} {mask}, {self.splat('i1', 'true')}")

    def once(self, key: Any, compute: Callable[[], Any]) -> Any:
        """What a function computes, computed once in a block for each key."""
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]

    def reciprocal(self, x: str) -> str:
        """1/x, computed once for each x: division is slow, and the same divisors recur.

        A quotient x (1/y) is within two ulp of x/y unless 1/y is not a normal number, which is
        where |y| is below 1e-308 or above 1e307.
        """
        return self.once(("reciprocal", x), lambda: self.div(self.constant(1.0), x))

    def compare(self, predicate: str, x: str, y: str) -> str:
        """Mask of the lanes in which a comparison holds."""
        return self.emit(f"fcmp {predicate} {self.vector} {x}, {y}")

    def select(self, mask: str, x: str, y: str) -> str:
        """Lanes of x where the mask is set, else of y."""
        return self.emit(f"select {self.mask} {mask}, {self.vector} {x}, {self.vector} {y}")

    def any(self, mask: str) -> str:
        """Whether a mask is set in any lane, as one bit."""
        symbol = f"@llvm.vector.reduce.or.v{self.lanes}i1"
        self.declarations.add(f"declare i1 {symbol}({self.mask})")
        return self.emit(f"call i1 {symbol}({self.mask} {mask})")

    def intrinsic(self, name: str, *arguments: str) -> str:
        """An LLVM intrinsic on vectors of doubles."""
        symbol = f"@llvm.{name}.v{self.lanes}f64"
        signature = ", ".join([self.vector] * len(arguments))
        self.declarations.add(f"declare {self.vector} {symbol}({signature})")
        values = ", ".join(f"{self.vector} {x}" for x in arguments)
        return self.emit(f"call {self.vector} {symbol}({values})")

    def exact(self, symbol: str, *arguments: str) -> str:
        """A function of the C library whose result is exact, and so the same everywhere."""
        self.symbols.add(symbol)
        signature = ", ".join(["double"] * len(arguments))
        self.declarations.add(f"declare double @{symbol}({signature}) {PURE}")
        result = "poison"
        for lane in range(self.lanes):
            piece = f"extractelement {self.vector} {{}}, i64 {lane}"
            values = ", ".join(f"double {self.emit(piece.format(x))}" for x in arguments)
            call = self.emit(f"call double @{symbol}({values})")
            result = self.emit(f"insertelement {self.vector} {result}, double {call}, i64 {lane}")
        return result


Entries = Callable[[int], str]
"""Function from the place of an entry in an input to its value; it may append a load."""
