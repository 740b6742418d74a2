"""LLVM assembly for straight-line code on vectors: one path a lane."""

import struct
from collections.abc import Callable, Sequence

from ftcfa.engine.compiler.vector_math import Target
from ftcfa.streams import MANTISSA_SHIFT, ONE, PARITY, ROTATIONS, ROUNDS

TWO_PI = 6.283185307179586
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
        self._count = 0
        self._reciprocals: dict[str, str] = {}

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
        """Begin a block; it need not be reached from the last one, so no reciprocal is known."""
        self.lines.append(f"{name}:")
        self._reciprocals.clear()

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
        """An arithmetic operation; LLVM may fuse a product with a sum."""
        return self.emit(f"{operation} contract {self.vector} {x}, {y}")

    def reciprocal(self, x: str) -> str:
        """1/x, computed once for each x: division is slow, and the same divisors recur.

        A quotient x (1/y) is within two ulp of x/y unless 1/y is not a normal number, which is
        where |y| is below 1e-308 or above 1e307.
        """
        if x not in self._reciprocals:
            self._reciprocals[x] = self.arithmetic("fdiv", self.constant(1.0), x)
        return self._reciprocals[x]

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

    def elementary(self, name: str, *arguments: str) -> str:
        """An elementary function, on whole vectors where the machine has it for them."""
        symbol, width = self.target.vector_function(name, len(arguments))
        self.symbols.add(symbol)
        if width == 1:
            return self._lane_by_lane(symbol, arguments)
        kind = f"<{width} x double>"
        signature = ", ".join([kind] * len(arguments))
        self.declarations.add(f"declare {kind} @{symbol}({signature}) {PURE}")
        parts = []
        for start in range(0, self.lanes, width):
            pieces = [self._piece(x, start, width) for x in arguments]
            values = ", ".join(f"{kind} {piece}" for piece in pieces)
            parts.append(self.emit(f"call {kind} @{symbol}({values})"))
        return self._joined(parts, width)

    def _lane_by_lane(self, symbol: str, arguments: Sequence[str]) -> str:
        signature = ", ".join(["double"] * len(arguments))
        self.declarations.add(f"declare double @{symbol}({signature}) {PURE}")
        result = "poison"
        for lane in range(self.lanes):
            piece = f"extractelement {self.vector} {{}}, i64 {lane}"
            values = ", ".join(f"double {self.emit(piece.format(x))}" for x in arguments)
            call = self.emit(f"call double @{symbol}({values})")
            result = self.emit(f"insertelement {self.vector} {result}, double {call}, i64 {lane}")
        return result

    def _piece(self, x: str, start: int, width: int) -> str:
        if width == self.lanes:
            return x
        lanes = ", ".join(f"i32 {lane}" for lane in range(start, start + width))
        order = f"<{width} x i32> <{lanes}>"
        return self.emit(f"shufflevector {self.vector} {x}, {self.vector} poison, {order}")

    def _joined(self, parts: list[str], width: int) -> str:
        while len(parts) > 1:
            lanes = ", ".join(f"i32 {lane}" for lane in range(2 * width))
            kind, order = f"<{width} x double>", f"<{2 * width} x i32> <{lanes}>"
            parts = [
                self.emit(f"shufflevector {kind} {a}, {kind} {b}, {order}")
                for a, b in zip(parts[::2], parts[1::2], strict=True)
            ]
            width *= 2
        return parts[0]


Entries = Callable[[int], str]
"""Function from the place of an entry in an input to its value; it may append a load."""


def normals(asm: Assembly, seed: str, paths: str, step: str, stream: int, count: int) -> list[str]:
    """Append the normal deviates of one step, those of `ftcfa.streams.standard_normals`.

    Args:
        asm: Code to append to.
        seed: Vector of words, the seed.
        paths: Vector of words, the number of each lane's path.
        step: Vector of words, the number of the step.
        stream: Number of the stream, such as `ftcfa.streams.PLANT_NOISE`.
        count: Number of deviates.
    """
    deviates: list[str] = []
    for pair in range((count + 1) // 2):
        a, b = _threefry(asm, step, asm.word((stream << 32) + pair), seed, paths)
        u = asm.arithmetic("fsub", asm.constant(2.0), _in_one_two(asm, a))
        w = asm.arithmetic("fsub", _in_one_two(asm, b), asm.constant(1.0))
        angle = asm.arithmetic("fmul", asm.constant(TWO_PI), w)
        log = asm.elementary("log", u)
        radius = asm.intrinsic("sqrt", asm.arithmetic("fmul", asm.constant(-2.0), log))
        for function in ("cos", "sin"):
            deviates.append(asm.arithmetic("fmul", radius, asm.elementary(function, angle)))
    return deviates[:count]


def _threefry(asm: Assembly, x: str, y: str, key0: str, key1: str) -> tuple[str, str]:
    def word(operation: str, a: str, b: str) -> str:
        return asm.emit(f"{operation} {asm.words} {a}, {b}")

    rotate = f"@llvm.fshl.v{asm.lanes}i64"
    asm.declarations.add(f"declare {asm.words} {rotate}({asm.words}, {asm.words}, {asm.words})")
    keys = (key0, key1, word("xor", word("xor", asm.word(PARITY), key0), key1))
    x, y = word("add", x, keys[0]), word("add", y, keys[1])
    for r in range(ROUNDS):
        x = word("add", x, y)
        bits = asm.word(ROTATIONS[r % 8])
        values = f"{asm.words} {y}, {asm.words} {y}, {asm.words} {bits}"
        y = word("xor", asm.emit(f"call {asm.words} {rotate}({values})"), x)
        if r % 4 == 3:
            injection = r // 4 + 1
            x = word("add", x, keys[injection % 3])
            y = word("add", y, word("add", keys[(injection + 1) % 3], asm.word(injection)))
    return x, y


def _in_one_two(asm: Assembly, word: str) -> str:
    mantissa = asm.emit(f"lshr {asm.words} {word}, {asm.word(MANTISSA_SHIFT)}")
    bits = asm.emit(f"or {asm.words} {mantissa}, {asm.word(ONE)}")
    return asm.emit(f"bitcast {asm.words} {bits} to {asm.vector}")
