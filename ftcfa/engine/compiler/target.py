"""Vectors of the machine that the code is generated for."""

from dataclasses import dataclass
from functools import cache

import llvmlite.binding as llvm

from ftcfa.errors import ParameterError

LANES = (1, 2, 4, 8, 16)
USUAL_LANES = 8
"""One AVX-512 register, two of AVX2, four of SSE2 or ARM: measured to be the fastest on all."""


@dataclass(frozen=True)
class Target:
    """Vectors and processor that the compiled engine generates code for.

    Attributes:
        lanes: Number of paths in one vector; it changes no bit of a path.
        cpu: Name of the processor, as LLVM knows it.
        features: Its instruction sets, such as ``"+avx2,+fma"``; they change no bit either.
    """

    lanes: int
    cpu: str
    features: str

    def __post_init__(self) -> None:
        if self.lanes not in LANES:
            raise ParameterError("lanes", repr(self.lanes), f"one of {LANES}")


@cache
def host_target(lanes: int = USUAL_LANES) -> Target:
    """The target of this machine."""
    features = llvm.get_host_cpu_features().flatten()
    return Target(lanes, llvm.get_host_cpu_name(), features)
