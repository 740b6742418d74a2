"""How accurate are the elementary functions in the generated code?

    python scripts/kernel_accuracy.py [--numbers N] [--out FOLDER]

Each is compared with mpmath at numbers of all sizes, denormal ones too, and at hard ones: next to
the multiples of pi/2, and where logarithms vanish. The script takes a minute, prints the largest
error in units in the last place (ulp) and writes kernel-accuracy.json.
"""

import argparse
import ctypes
import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import mpmath as mp
import numpy as np
from rich.console import Console

from ftcfa.arrays import Array
from ftcfa.engine.compiler.assembly import Assembly
from ftcfa.engine.compiler.kernels.power import constant_power
from ftcfa.engine.compiler.kernels.table import FUNCTIONS, KERNELS
from ftcfa.engine.compiler.kernels.trigonometric import RANGE
from ftcfa.engine.compiler.program import machine_code
from ftcfa.engine.compiler.target import Target, host_target
from ftcfa.files import make_folder, write_whole
from ftcfa.report.terminal import print_line, print_table

NUMBERS = 20_000
"""Arguments of each kind, for each function."""
SMALLEST = 2.0**-1074
DIGITS = 50
"""Digits of the truth."""
POWERS = (0.6, 1 / 3, 0.5, -0.4, 0.9, 1.6, 3.7, 7.0, -2.0)
"""Constant exponents of y^a."""
ALL = (1e-320, 1e308)
"""Denormal numbers to the largest."""
Columns = Sequence[Array]


class Draw:
    """Arguments of functions, of both signs where it says so."""

    def __init__(self, count: int, seed: int = 0) -> None:
        self.count, self.rng = count, np.random.default_rng(seed)

    def sized(self, low: float, high: float) -> Array:
        """Positive numbers of all sizes."""
        return np.exp(self.rng.uniform(np.log(low), np.log(high), self.count))

    def signed(self, low: float, high: float) -> Array:
        """Numbers of all sizes and both signs."""
        return self.sized(low, high) * self.rng.choice([-1, 1], self.count)

    def even(self, low: float, high: float) -> Array:
        """Numbers evenly between two bounds."""
        return self.rng.uniform(low, high, self.count)

    def angles(self) -> Columns:
        """Angles, also next to the multiples of pi/2, where the sine or the cosine vanishes."""
        small = np.arange(1, self.count) * (np.pi / 2)
        large = np.floor(self.rng.uniform(1, RANGE / 2, self.count)) * (np.pi / 2)
        return [np.concatenate([self.signed(1e-300, RANGE), self.even(-10, 10), small, large])]

    def one(self, sized: Array, low: float, high: float) -> Columns:
        """Some numbers, and others evenly between two bounds."""
        return [np.concatenate([sized, self.even(low, high)])]

    def pair(self) -> Columns:
        """Two numbers of all sizes whose squares are normal."""
        return [self.signed(1e-150, 1e150), self.signed(1e-150, 1e150)]

    def powers(self) -> Columns:
        """Bases and exponents of normal powers."""
        y = np.concatenate([self.sized(1e-300, 1e300), self.even(0.5, 2)])
        return [y, self.rng.uniform(-1, 1, len(y)) * 700 / np.abs(np.log(y))]

    def bases(self, a: float) -> Columns:
        """Bases of normal powers with a given exponent."""
        y = np.concatenate([self.sized(*ALL), self.even(0.5, 2)])
        y = y[np.abs(a * np.log(y)) < 700]
        return [y, np.full_like(y, a)]


ARGUMENTS: Mapping[str, Callable[[Draw], Columns]] = {
    "exp": lambda draw: draw.one(draw.even(-745, 709.7), -2, 2),
    "expm1": lambda draw: draw.one(draw.signed(1e-320, 700), -2, 2),
    "sinh": lambda draw: draw.one(draw.signed(1e-320, 710), -2, 2),
    "cosh": lambda draw: draw.one(draw.signed(1e-320, 710), -2, 2),
    "tanh": lambda draw: draw.one(draw.signed(1e-320, 30), -2, 2),
    "log": lambda draw: draw.one(draw.sized(*ALL), 0.5, 2),
    "log1p": lambda draw: draw.one(draw.sized(*ALL), -0.999, 2),
    "asinh": lambda draw: draw.one(draw.signed(*ALL), -3, 3),
    "acosh": lambda draw: [1.0 + draw.sized(1e-15, 1e308)],
    "atanh": lambda draw: draw.one(draw.signed(1e-320, 1), -1, 1),
    "sin": Draw.angles,
    "cos": Draw.angles,
    "tan": Draw.angles,
    "asin": lambda draw: draw.one(draw.signed(1e-320, 1), -1, 1),
    "acos": lambda draw: draw.one(draw.signed(1e-320, 1), -1, 1),
    "atan": lambda draw: draw.one(draw.signed(*ALL), -3, 3),
    "atan2": Draw.pair,
    "erf": lambda draw: draw.one(draw.signed(1e-320, 6), -7, 7),
    "hypot": Draw.pair,
    "pow": Draw.powers,
}
"""Function to its arguments."""


def kernel(function: Callable[..., str], arity: int, target: Target) -> Callable[..., Array]:
    """A kernel as a function on arrays."""
    asm = Assembly(target)
    asm.store(function(asm, *(asm.load("%x", i) for i in range(arity))), "%y", 0)
    head = "\n".join([*sorted(asm.declarations), "define void @f(ptr %x, ptr %y) {"])
    body = "\n".join([*asm.lines, "  ret void", "}"])
    engine = machine_code(f"{head}\n{body}", asm.symbols, target)
    call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(
        engine.get_function_address("f")
    )

    def evaluate(*columns: Array) -> Array:
        missing = -len(columns[0]) % target.lanes
        x = np.pad(np.stack(columns), ((0, 0), (0, missing)), mode="edge")
        blocks = np.ascontiguousarray(x.reshape(arity, -1, target.lanes).transpose(1, 0, 2))
        y = np.empty((len(blocks), target.lanes))
        for block, result in zip(blocks, y, strict=True):
            call(block.ctypes.data, result.ctypes.data)
        return y.reshape(-1)[: len(columns[0])]

    evaluate.engine = engine  # type: ignore[attr-defined]  # owns the code
    return evaluate


def truth(name: str, columns: Columns) -> list[mp.mpf]:
    """The function's values to DIGITS digits."""
    exact = mp.power if name == "pow" else getattr(mp, name)
    with mp.workdps(DIGITS):
        return [exact(*map(mp.mpf, row)) for row in np.transpose(columns).tolist()]


def error(got: Array, exact: list[mp.mpf]) -> float:
    """Largest error in units in the last place of the exact value [ulp]."""
    worst = 0.0
    for value, true in zip(got.tolist(), exact, strict=True):
        rounded = float(true)
        if rounded == value:
            continue
        _, exponent = np.frexp(abs(rounded))
        unit = max(2.0 ** (int(exponent) - 53), SMALLEST) if exponent > -1021 else SMALLEST
        worst = max(worst, abs(float((mp.mpf(value) - true) / mp.mpf(unit))))
    return worst


def errors(count: int) -> dict[str, float]:
    """Largest error of every function, and of y^a for some constant a [ulp]."""
    found = {}
    for name, arguments in ARGUMENTS.items():
        columns = arguments(Draw(count))
        got = kernel(FUNCTIONS[name], len(columns), host_target())(*columns)
        found[name] = error(got, truth(name, columns))
    for a in POWERS:
        columns = Draw(count).bases(a)
        got = kernel(partial(constant_power, a=a), 1, host_target())(columns[0])
        found[f"y^{a:.3g}"] = error(got, truth("pow", columns))
    return found


def main() -> None:
    """Print the table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--numbers", type=int, default=NUMBERS, help="arguments of each kind")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the record")
    options = parser.parse_args()
    make_folder(options.out)
    found = errors(options.numbers)
    console = Console(highlight=False)
    title = f"Largest error [ulp], kernels {KERNELS}, {options.numbers:,} numbers of each kind"
    print_line(title, console, "bold")
    print_table(["function", "ulp"], [[n, f"{e:.2f}"] for n, e in found.items()], console, "lr")
    record = {"kernels": KERNELS, "numbers": options.numbers, "ulp": found}
    write_whole(options.out / "kernel-accuracy.json", json.dumps(record, indent=1).encode())


if __name__ == "__main__":
    main()
