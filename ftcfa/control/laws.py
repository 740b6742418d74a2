"""All laws by name, and the one rule that sets their defaults.

A new law is one file beside this one and one line in `LAWS`: files then read it by its class name
(``type = "PDGravity"``), and `ftcfa.rivals`, ``ftcfa compare --controller`` and the conformance
tests know it by the same name.

In a comparison every law gets the same nominal arm and compensates the same known forces: `FTCF`,
which can leave them out, is given ``compensation="bias"``, as its rivals have by construction.
Period and torque limits are those of the loop.

The rule: at a position error of 1 rad and at a velocity error of 1 rad/s every law commands the
same correction as FTCF. With the paper's gains its rates there are
a1 = c1 + 3/4 (1 + k1) = 9.75 1/s and a2 = c2 + 3/4 k2 + 5/4 = 26.5 1/s (`Gains.position_rate`,
`Gains.velocity_rate`); -a1 and -a2 are the poles of the nominal error under every linear law. The
backstepping laws share the `Gains`; the others take a1 and a2. What has no counterpart in FTCF is
a power of ten apart from these rates: the second-order filter works at 10 a2, Slotine and Li's
adaptation at a1/10, and its leakage at a1/100.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pkgutil import resolve_name
from typing import Any

from ftcfa.control.finite_time_backstepping import FiniteTimeBackstepping
from ftcfa.control.ftcf import FTCF
from ftcfa.control.gains import Gains
from ftcfa.control.protocol import Controller
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.model.dynamics import Dynamics

LAWS: tuple[type[Any], ...] = tuple(
    map(resolve_name, (
        "ftcfa.control.ftcf:FTCF",
        "ftcfa.control.command_filtered:CommandFilteredBackstepping",
        "ftcfa.control.stochastic_backstepping:StochasticBackstepping",
        "ftcfa.control.finite_time_backstepping:FiniteTimeBackstepping",
        "ftcfa.control.computed_torque:ComputedTorque",
        "ftcfa.control.pd_gravity:PDGravity",
        "ftcfa.control.position_feedback:PositionFeedback",
        "ftcfa.control.slotine_li:SlotineLi",
        "ftcfa.control.super_twisting:SuperTwisting",
    ))
)  # fmt: skip
"""The class of every law, by ``module:class``; ``law(nominal)`` makes a law with its defaults."""
REGULARISED = 0.01
"""Width of the regularised finite-time backstepping [rad or m]."""
PRESETS: Mapping[str, Callable[[Dynamics], Controller]] = {
    "FTCF": lambda arm: FTCF(arm, compensation="bias"),
    "FTCF-printed": lambda arm: printed(FTCF(arm, compensation="bias")),
    "FTCF-asymptotic": lambda arm: FTCF(arm, Gains(kappa=1.0), compensation="bias"),
    "FiniteTimeBackstepping-regularised": lambda arm: FiniteTimeBackstepping(
        arm, width=REGULARISED
    ),
}
"""Laws that a comparison makes with other parameters than the defaults."""
CONTROLLERS: Mapping[str, Callable[[Dynamics], Controller]] = {
    **{law.__name__: law for law in LAWS},
    **PRESETS,
}
"""Name in comparisons to a function that makes the law from the nominal arm."""

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "without error compensation": {"error_compensation": False},
    "without the anti-saturation state": {"anti_saturation": "none"},
    "without the network": {"adaptation": False},
    "with the second-order filter": {"filter": "second-order"},
    "kappa = 1": {"gains": {"kappa": 1.0}},
}
"""Name of an ablation to the fields of `FTCF` that it replaces."""


PRINTED = 'as printed: anti_saturation = "paper", theta without a bound'
"""How outputs name the law that `printed` gives."""


def printed(law: FTCF) -> FTCF:
    """The law with (9) and (11) as the paper prints them: neither theta nor rho is bounded.

    Raises:
        ParameterError: If it is not the paper's law.
    """
    if not isinstance(law, FTCF):
        raise ParameterError("printed", f"a {type(law).__name__}", "an FTCF(arm)")
    network = replace(law.network, largest_theta=math.inf)
    return replace(law, anti_saturation="paper", network=network)


def ablated(law: FTCF, ablation: str) -> FTCF:
    """The law with one ingredient left out or replaced.

    Raises:
        UnknownNameError: If there is no ablation of that name.
    """
    if ablation not in ABLATIONS:
        raise UnknownNameError("ablation", ablation, tuple(ABLATIONS))
    changes = dict(ABLATIONS[ablation])
    if "gains" in changes:
        changes["gains"] = replace(law.gains, **changes["gains"])
    return replace(law, **changes)
