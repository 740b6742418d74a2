"""Where a search starts: the gains that `ftcfa.suggest_gains` suggests, for whatever law."""

from dataclasses import replace
from typing import Any

from ftcfa.control.gains import Gains
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.suggested_gains import AMPLITUDE, gains_of_rate, suggest_rate
from ftcfa.model.arm import Arm
from ftcfa.parts import fields_of

RATES = ("position_rate", "velocity_rate")
"""Fields of a law that are rates a1 and a2."""


def suggested(loop: ClosedLoop) -> ClosedLoop:
    """The loop with suggested gains: `Gains`, or rates by the names of RATES.

    A law without either, or whose nominal robot is no `Arm`, stays as it is.
    """
    nominal = getattr(loop.controller, "nominal", None)
    if not isinstance(nominal, Arm):
        return loop
    rate = suggest_rate(nominal, loop.period, loop.hardware, loop.vibration)
    return replace(loop, controller=_with_rate(loop.controller, rate))


def _with_rate(law: Any, rate: float) -> Any:
    """A law, or the law inside of one, with the rate a1 = a2 [1/s]."""
    given = fields_of(law)
    changes: dict[str, Any] = {name: rate for name in RATES if name in given}
    if isinstance(given.get("gains"), Gains):
        changes["gains"] = gains_of_rate(rate, AMPLITUDE, given["gains"])
    if hasattr(given.get("law"), "step"):
        changes["law"] = _with_rate(given["law"], rate)
    return replace(law, **changes) if changes else law
