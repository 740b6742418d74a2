"""Whether two machines compute the same bits: a hash of the beginning of a loop's first paths."""

from hashlib import sha256

import numpy as np

from ftcfa.engine.run import run_paths
from ftcfa.loop.closed_loop import ClosedLoop

PATHS, SAMPLES = 8, 32


def probe(loop: ClosedLoop, seed: int) -> str:
    """The hash of the first SAMPLES samples of the first PATHS paths, 16 hexadecimal digits.

    The kernels, robots, filters and records give the same bits everywhere, fits and Fourier series
    because they are rounded to a grid. What may differ are parts of a user's own, and a fit or a
    record one of whose numbers lies next to the border between two points of the grid.

    Args:
        loop: The loop, as `ftcfa.study.plan.Plan.observed` gives it, whose code is compiled anyway.
        seed: Seed of the paths.
    """
    paths = np.arange(PATHS, dtype=np.uint64)
    run = run_paths(loop, SAMPLES, 1, seed, paths, ["q", "u"], {}, 1)
    numbers = (run.paths.signals["q"], run.paths.signals["u"])
    return sha256(b"".join(np.ascontiguousarray(x).tobytes() for x in numbers)).hexdigest()[:16]
