"""Targets that this machine can run: any number of lanes, and fewer instruction sets."""

from dataclasses import replace

from ftcfa.engine.compiler.target import LANES, host_target

WITHOUT = {
    "no AVX-512": ("avx512", "avx10", "evex512"),
    "no fused multiply-add": ("avx512", "avx10", "evex512", "fma"),
    "SSE2": ("avx", "fma", "xop", "f16c", "vaes", "vpclmulqdq", "sse4", "ssse3", "sse3", "gfni"),
}
"""Instruction sets that a target leaves out, by their first letters."""


def _without(features, letters):
    kept = features.split(",")
    return ",".join(f"-{f[1:]}" if f[1:].startswith(letters) else f for f in kept)


TARGETS = {
    **{f"{lanes} lanes": host_target(lanes) for lanes in LANES},
    **{
        name: replace(host_target(), features=_without(host_target().features, letters))
        for name, letters in WITHOUT.items()
    },
}
