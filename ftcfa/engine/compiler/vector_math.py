"""Vectors of this machine, and the libraries that compute sin, exp, pow and others on them.

glibc's libmvec has the elementary functions for whole vectors, with errors of at most 4 ulp. Where
it is missing, each lane calls libm.
"""

import ctypes
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import llvmlite.binding as llvm

from ftcfa.errors import ParameterError

LANES = (1, 2, 4, 8, 16)
_ISA = {8: "e", 4: "d", 2: "b"}  # libmvec's letter for vectors of so many doubles


@dataclass(frozen=True)
class Target:
    """Vectors that the compiled engine generates code for.

    Attributes:
        lanes: Number of paths in one vector.
        widest: Number of doubles in the widest vector that the machine has instructions for.
        libmvec: Whether to use libmvec for the functions that it has.
    """

    lanes: int
    widest: int
    libmvec: bool = True

    def __post_init__(self) -> None:
        if self.lanes not in LANES:
            raise ParameterError("lanes", repr(self.lanes), f"one of {LANES}")

    def vector_function(self, name: str, arguments: int) -> tuple[str, int]:
        """Symbol of an elementary function, and the number of doubles that it takes (1: libm)."""
        width = min(self.lanes, self.widest)
        if self.libmvec and width in _ISA:
            symbol = f"_ZGV{_ISA[width]}N{width}{'v' * arguments}_{name}"
            if _libmvec() is not None and hasattr(_libmvec(), symbol):
                return symbol, width
        return name, 1


def host_target(lanes: int | None = None, libmvec: bool = True) -> Target:
    """The target of this machine: 8 lanes with AVX-512, 4 with AVX2, else 2."""
    features: Mapping[str, bool] = llvm.get_host_cpu_features()
    widest = 8 if features.get("avx512f") else 4 if features.get("avx2") else 2
    return Target(widest if lanes is None else lanes, widest, libmvec)


@cache
def _libmvec() -> ctypes.CDLL | None:
    if platform.machine() not in ("x86_64", "AMD64"):
        return None  # other calling conventions
    try:
        return ctypes.CDLL("libmvec.so.1")
    except OSError:
        return None


@cache
def _libm() -> ctypes.CDLL:
    try:
        return ctypes.CDLL("libm.so.6")
    except OSError:
        return ctypes.CDLL(None)  # elsewhere it is part of the C library


def bind(symbol: str) -> None:
    """Give LLVM the address of an elementary function."""
    library = _libmvec() if symbol.startswith("_ZGV") else _libm()
    address = ctypes.cast(getattr(library, symbol), ctypes.c_void_p).value
    llvm.add_symbol(symbol, address)
