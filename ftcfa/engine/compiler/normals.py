"""Normal deviates in the generated code: those of `ftcfa.streams`, by the kernels."""

from ftcfa.engine.compiler.assembly import Assembly, Entries
from ftcfa.engine.compiler.kernels.logarithm import log_of_positive
from ftcfa.engine.compiler.kernels.trigonometric import cos, sin
from ftcfa.streams import MANTISSA_SHIFT, ONE, PARITY, ROTATIONS, ROUNDS

TWO_PI = 6.283185307179586


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
    draw = on_demand(asm, seed, paths, step, stream)
    return [draw(i) for i in range(count)]


def on_demand(asm: Assembly, seed: str, paths: str, step: str, stream: int) -> Entries:
    """Function from a number to that normal deviate of a step; each pair is computed when needed.

    The arguments are those of `normals`. All deviates are to be taken in one block.
    """
    pairs: dict[int, tuple[str, str]] = {}

    def deviate(i: int) -> str:
        pair, which = divmod(i, 2)
        if pair not in pairs:
            pairs[pair] = _pair(asm, seed, paths, step, (stream << 32) + pair)
        return pairs[pair][which]

    return deviate


def _pair(asm: Assembly, seed: str, paths: str, step: str, word: int) -> tuple[str, str]:
    """Two deviates by Box and Muller."""
    a, b = _threefry(asm, step, asm.word(word), seed, paths)
    u = asm.sub(asm.constant(2.0), _in_one_two(asm, a))
    w = asm.sub(_in_one_two(asm, b), asm.constant(1.0))
    angle = asm.mul(asm.constant(TWO_PI), w)
    log = log_of_positive(asm, u)
    radius = asm.intrinsic("sqrt", asm.mul(asm.constant(-2.0), log))
    return asm.mul(radius, cos(asm, angle)), asm.mul(radius, sin(asm, angle))


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
    return asm.number(bits)
