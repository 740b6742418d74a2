"""All laws by name, for comparisons: what each is given, and the one rule of its defaults.

Every law gets the same nominal arm and uses what it knows of it (`FTCF` compensates the nominal
bias, as its rivals do by construction); the loop gives all the same period and torque limits.

The rule: at a position error of one and at a velocity error of one every law pulls like FTCF. For
the paper's gains that is a1 = c1 + 3/4 (1 + k1) = 9.75 and a2 = c2 + 3/4 k2 + 5/4 = 26.5 a second;
-a1 and -a2 are the poles of every linear law's nominal error. The backstepping laws share the
`Gains`; the others take a1 and a2 (`Gains.position_rate`, `Gains.velocity_rate`). What has no
counterpart in FTCF is set apart from these rates by tens: the linear filter at 10 a2, Slotine and
Li's adaptation at a1/10 and its leakage at a1/100.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ftcfa.control.command_filtered import CommandFilteredBackstepping
from ftcfa.control.computed_torque import ComputedTorque
from ftcfa.control.finite_time_backstepping import FiniteTimeBackstepping
from ftcfa.control.ftcf import FTCF, Gains
from ftcfa.control.pd_gravity import PDGravity
from ftcfa.control.protocol import Controller
from ftcfa.control.slotine_li import SlotineLi
from ftcfa.control.stochastic_backstepping import StochasticBackstepping
from ftcfa.control.super_twisting import SuperTwisting
from ftcfa.errors import UnknownNameError
from ftcfa.model.dynamics import Dynamics

REGULARISED = 0.01
"""Width of the regularised finite-time backstepping [rad or m]."""

CONTROLLERS: Mapping[str, Callable[[Dynamics], Controller]] = {
    "ftcf": lambda arm: FTCF(arm, compensation="bias"),
    "ftcf-asymptotic": lambda arm: FTCF(arm, Gains(kappa=1.0), compensation="bias"),
    "command-filtered": CommandFilteredBackstepping,
    "stochastic-backstepping": StochasticBackstepping,
    "finite-time-backstepping": FiniteTimeBackstepping,
    "finite-time-backstepping-regularised": lambda arm: FiniteTimeBackstepping(
        arm, width=REGULARISED
    ),
    "computed-torque": ComputedTorque,
    "pd-gravity": PDGravity,
    "slotine-li": SlotineLi,
    "super-twisting": SuperTwisting,
}
"""What makes each law from the nominal arm."""

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "without error compensation": {"error_compensation": False},
    "without the anti-saturation state": {"anti_saturation": False},
    "without the network": {"adaptation": False},
    "with the linear filter": {"filter": "linear"},
    "kappa = 1": {"gains": {"kappa": 1.0}},
}
"""What changes in FTCF, by the name of the ablation."""


def ablated(law: FTCF, ablation: str) -> FTCF:
    """FTCF with one ingredient left out or replaced.

    Raises:
        UnknownNameError: If there is no ablation of that name.
    """
    if ablation not in ABLATIONS:
        raise UnknownNameError("ablation", ablation, tuple(ABLATIONS))
    changes = dict(ABLATIONS[ablation])
    if "gains" in changes:
        changes["gains"] = replace(law.gains, **changes["gains"])
    return replace(law, **changes)
