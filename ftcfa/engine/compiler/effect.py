"""Which inputs of traced code have an effect on the motion."""

from collections.abc import Callable, Iterable

import casadi as ca
import numpy as np

from ftcfa.arrays import Array
from ftcfa.engine.compiler.flatten import size
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.parameters import parameter


def idle_parameters(
    loop: ClosedLoop,
    functions: Iterable[ca.Function],
    preparations: Iterable[tuple[str, Callable[[Array], Array]]],
) -> tuple[str, ...]:
    """Names of the varied parameters on which no output of some functions depends.

    Args:
        loop: The loop.
        functions: Functions whose last input are the parameters.
        preparations: Names of the parameters, and how each becomes entries of that input.
    """
    used = np.zeros(1, dtype=bool)
    for function in functions:
        last = function.n_in() - 1
        for output in range(function.n_out()):
            sparsity = np.asarray(function.jac_sparsity(output, last).T, dtype=bool)
            used = used | sparsity.any(axis=1)
    start, idle = 0, []
    for name, prepare in preparations:
        end = start + max(1, size(prepare(parameter(loop, name)[None])))
        if not used[start:end].any():
            idle.append(name)
        start = end
    return tuple(idle)
