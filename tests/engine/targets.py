"""Targets that this machine can run: numbers of lanes, fewer instruction sets, other processors."""

from dataclasses import replace

from ftcfa.engine.compiler.target import LANES, USUAL_LANES, Target, host_target

WITHOUT = {
    "no AVX-512": ("avx512", "avx10", "evex512"),
    "no fused multiply-add": ("avx512", "avx10", "evex512", "fma"),
    "SSE2": ("avx", "fma", "xop", "f16c", "vaes", "vpclmulqdq", "sse4", "ssse3", "sse3", "gfni"),
}
"""Instruction sets that a target leaves out, by their first letters."""
PROCESSORS = {"x86-64": "+sse2", "haswell": "+avx2", "skylake-avx512": "+avx512vl"}
"""Names of processors, and an instruction set that shows whether this machine can run their code;
none of them on a machine of another kind."""
ELSEWHERE = {
    "NumPy without AVX": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V3,X86_V4,AVX512_ICL,AVX512_SPR,AVX2,AVX512F"
    },
    "another OpenBLAS kernel": {"OPENBLAS_CORETYPE": "Sandybridge"},
}
"""Environments in which NumPy and OpenBLAS take other instructions; an unknown name is ignored."""

_features = host_target().features.split(",")


def _without(letters):
    kept = (f"-{f[1:]}" if f[1:].startswith(letters) else f for f in _features)
    return replace(host_target(), features=",".join(kept))


TARGETS = {
    **{f"{lanes} lanes": host_target(lanes) for lanes in LANES},
    **{name: _without(letters) for name, letters in WITHOUT.items()},
    **{cpu: Target(USUAL_LANES, cpu, "") for cpu, has in PROCESSORS.items() if has in _features},
}
