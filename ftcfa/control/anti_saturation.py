"""The gap between a torque and its limit, which drives the anti-saturation state rho of FTCF.

    rho' = -rho + Mbar(q)^-1 gap(u)          (11)

The paper prints gap(u) = eta(u) - u. The commanded acceleration holds -rho, (8), so that
rho' = Mbar^-1 eta(u) + c2 sig(v2) + ... has no leakage while a torque is saturated: rho winds up,
and the command follows it. The paper's own pendulum then runs away from q(0) = (1, 1), and one
wrong velocity sample can drive rho to infinity. Theorem 1 is about the printed gap.
"""

import warnings
from collections.abc import Callable, Mapping
from typing import Literal, TypeAlias

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import known_name

AntiSaturation: TypeAlias = Literal["bounded", "paper", "none"]
"""Name of a gap; with ``"none"`` rho stays zero."""
MARGIN = 1.05
"""Multiple m of the limits up to which a torque beyond them drives rho."""


def smooth_saturation(u: Traceable, limit: Traceable) -> Traceable:
    """The smooth saturation eta(u) = u* tanh(u/u*) with the limits u*, shape (n,) [N m or N]."""
    return limit * np.tanh(u / limit)


def printed_gap(u: Traceable, limit: Traceable) -> Traceable:
    """The paper's gap eta(u) - u, shape (n,) [N m or N]: it grows with u without bound."""
    return smooth_saturation(u, limit) - u


def bounded_gap(u: Traceable, limit: Traceable) -> Traceable:
    """A gap that is zero below the limits u* and bounded above them, shape (n,) [N m or N].

        gap(u) = clip(u, -u*, u*) - clip(u, -m u*, m u*),   m = MARGIN

    So |gap_i| <= (m - 1) u*_i, and |rho| <= (m - 1) |u*| over the smallest eigenvalue of Mbar,
    whatever is measured. ``scripts/basin.py`` compares it with no rho at all and with the printed
    gap on every arm of the catalogue.
    """
    return np.clip(u, -limit, limit) - np.clip(u, -MARGIN * limit, MARGIN * limit)


GAPS: Mapping[str, Callable[[Traceable, Traceable], Traceable] | None] = {
    "bounded": bounded_gap,
    "paper": printed_gap,
    "none": None,
}
"""Name to the gap (u, u*) that drives rho, or None."""


def anti_saturation(choice: AntiSaturation | bool) -> AntiSaturation:
    """The name of a gap; True and False are read as what they meant before there were names.

    Raises:
        UnknownNameError: If it is neither.
    """
    if not isinstance(choice, bool):
        known_name("FTCF anti_saturation", choice, GAPS, field="anti_saturation")
        return choice
    word: AntiSaturation = "paper" if choice else "none"
    warnings.warn(
        f'anti_saturation = {str(choice).lower()} is read as "{word}"; write "bounded" (the '
        'default), "paper" or "none"',
        stacklevel=4,
    )
    return word
