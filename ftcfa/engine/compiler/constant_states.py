"""Entries of a state that stay what they are, such as the paper's s2, which is always zero."""

import casadi as ca
import numpy as np
import numpy.typing as npt


def constant_entries(
    state: ca.SX, start: ca.SX, after: ca.SX, renewal: ca.SX
) -> npt.NDArray[np.bool_]:
    """Which entries of a state stay the constants with which they start, shape (states,).

    The largest set of entries that a step, and a law that starts anew, leave as they are.
    """
    fixed = np.array([start[i].is_constant() for i in range(start.numel())], dtype=bool)
    while True:
        known = known_values(state, start, fixed)
        after_known, renewal_known = ca.substitute([after, renewal], *known)
        still = fixed & [
            all(_same(x[i], start[i]) for x in (after_known, renewal_known))
            for i in range(start.numel())
        ]
        if np.array_equal(still, fixed):
            return fixed
        fixed = still


def known_values(
    state: ca.SX, start: ca.SX, fixed: npt.NDArray[np.bool_]
) -> tuple[list[ca.SX], list[ca.SX]]:
    """Symbols of constant entries, and their values."""
    entries = np.flatnonzero(fixed).tolist()
    return [state[entries]], [start[entries]]


def _same(x: ca.SX, constant: ca.SX) -> bool:
    """Whether an expression is a constant number."""
    return bool(x.is_constant() and constant.is_constant() and float(x) == float(constant))
