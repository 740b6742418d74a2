"""Theorem 1 for a loop as plain data: its constants, and what a few paths did."""

from dataclasses import replace
from typing import Any

import numpy as np

from ftcfa.report.records import finite
from ftcfa.theory.gain_conditions import Condition
from ftcfa.theory.premises import TheoremPaths
from ftcfa.theory.theorem1 import Bounds

UNITS = {
    "Mmin": "kg m^2 or kg",
    "Mmax": "kg m^2 or kg",
    "pi1": "rad/s",
    "filter_reach": "rad/s^3",
    "ultimate_error": "rad",
    "error_without_blame": "rad",
    "error_at_best_weight": "rad",
    "reach": "rad",
    "first_entry": "s",
}
"""Units of the entries of `bounds_record`."""


def bounds_record(promised: Bounds, followed: TheoremPaths) -> dict[str, Any]:
    """All that ``ftcfa bounds`` shows, as plain data; None for what is infinite or not a number.

    Args:
        promised: Result of `ftcfa.bounds`.
        followed: Paths of the same loop.
    """
    weight, error = promised.best_weight()
    return {
        "verdict": promised.verdict,
        "applies": promised.applies,
        "informative": promised.informative,
        "supplied": {name: getattr(promised, name) for name in ("theta", "eps", "pi1", "sigma")},
        "joints": promised.n,
        "kappa": promised.kappa,
        "p": promised.p,
        "weight": promised.weight,
        "Mmin": promised.Mmin,
        "Mmax": promised.Mmax,
        "conditions": [_condition(each) for each in promised.conditions],
        "filter_reach": promised.filter_bound,
        "Delta": promised.Delta,
        "Delta_terms": dict(promised.Delta_terms),
        "Gamma": promised.Gamma,
        "Gamma_terms": dict(promised.Gamma_terms),
        "blame": promised.largest_term,
        "V0": promised.V0,
        "Vinf": finite(promised.Vinf),
        "ultimate_error": finite(promised.ultimate_error),
        "error_without_blame": finite(promised.error_without_largest_term),
        "best_weight": weight,
        "error_at_best_weight": finite(error),
        "reach": promised.joint_range,
        "first_entry": finite(promised.first_entry),
        "measured": _measured(followed),
        "units": UNITS,
    }


def _condition(condition: Condition) -> dict[str, Any]:
    """Record of a condition on the gains."""
    return {
        "name": condition.name,
        "value": condition.value,
        "relation": condition.relation,
        "required": condition.required,
        "holds": condition.holds,
        "needed": condition.needed,
        "replaces": condition.replaces,
    }


def _measured(followed: TheoremPaths) -> dict[str, Any]:
    """The same quantities measured on the paths; None if a path diverged."""
    values, needed = followed.values, followed.needed_Gamma.student()
    entry = followed.entry
    eps = followed.bounds.eps + max(0.0, float(np.max(followed.missing_eps)))
    pi1 = float(np.max(followed.filter_error))
    supplied = replace(followed.bounds, eps=eps, pi1=pi1)
    return {
        "paths": len(followed.z1),
        "duration": float(followed.time[-1]),
        "rms_error": finite(np.sqrt(np.mean(followed.late_error**2))),
        "largest_error": finite(np.max(followed.late_error)),
        "Gamma": finite(np.max(needed.value)),
        "Gamma_high": finite(np.max(needed.high)),
        "first_entry": finite(np.mean(entry)),
        "entered": float(np.mean(np.isfinite(entry))),
        "pi1": finite(pi1),
        "eps": finite(eps),
        "theta": finite(np.max(values.needed_theta)),
        "premises_hold": float(np.mean(followed.premises_hold)) if np.any(entry > 0) else None,
        "error_if_supplied": finite(supplied.ultimate_error),
    }
