"""What to compare a loop with: its rivals, itself less an ingredient, harder conditions."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import cast

from ftcfa.control.ftcf import FTCF
from ftcfa.control.laws import ABLATIONS, CONTROLLERS, ablated
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.uncertainty import Uncertainty
from ftcfa.vibration.vibration import Vibration

AS_GIVEN = "as given"
PERIODS = (2, 4)
"""Longer sampling periods, as factors; the integration step stays."""
LEVELS = (2, 4)
"""Stronger vibration, as factors of its amplitude."""
INERTIA_ERROR = Uncertainty(mass=0.2, centre=0.01, shape=0.1)
OF_URDF = ("SlotineLi",)
"""Laws that need the regressor of an Arm."""
PAYLOAD = 0.1
"""Of the moving mass, at the tip."""


def rivals(loop: ClosedLoop, names: str | Iterable[str] | None = None) -> dict[str, ClosedLoop]:
    """The loop as given, then under other laws on the same nominal arm.

    The others have the defaults that the rule of `ftcfa.control.laws` gives them.

    Args:
        loop: The loop; its law's nominal arm is that of all.
        names: Names in `ftcfa.control.laws.CONTROLLERS`, such as ``"PDGravity"``; by default all
            that the arm allows.

    Raises:
        UnknownNameError: If there is no law of a name; it lists those there are.
    """
    nominal = getattr(loop.controller, "nominal", loop.arm)
    if names is None:
        names = [n for n in CONTROLLERS if n not in OF_URDF or isinstance(nominal, Arm)]
    chosen = [names] if isinstance(names, str) else list(names)
    for name in chosen:
        if name not in CONTROLLERS:
            raise UnknownNameError("controller", str(name), tuple(CONTROLLERS))
    others = {name: replace(loop, controller=CONTROLLERS[name](nominal)) for name in chosen}
    return {AS_GIVEN: loop, **others}


def ablations(loop: ClosedLoop) -> dict[str, ClosedLoop]:
    """The loop as given, then with one ingredient of its law less at a time.

    Raises:
        ParameterError: If its law is not the paper's.
    """
    law = loop.controller
    if not isinstance(law, FTCF):
        got = f"a loop under {type(law).__name__}"
        raise ParameterError("ablations", got, "a loop under FTCF")
    less = {name: replace(loop, controller=ablated(law, name)) for name in ABLATIONS}
    return {AS_GIVEN: loop, **less}


def conditions(loop: ClosedLoop) -> dict[str, ClosedLoop]:
    """The loop as given, then under one harder condition at a time.

    Longer periods, stronger vibration, robots whose masses are spread by 20 % more than they
    are (centres by 1 cm, shapes by 10 %), and a payload of a tenth of the moving mass at the tip,
    of which the law knows nothing.
    """
    harder = {
        f"period x {k}": replace(loop, period=k * loop.period, substeps=k * loop.substeps)
        for k in PERIODS
    }
    shaken = loop.vibration
    for k in LEVELS if shaken is not None else ():
        louder = replace(cast(Vibration, shaken), level=k * cast(Vibration, shaken).level)
        harder[f"vibration x {k}"] = replace(loop, vibration=louder)
    if isinstance(loop.arm, Arm):
        mass = PAYLOAD * loop.arm.moving_mass
        known = loop.uncertainty or Uncertainty()
        wider = replace(
            known,
            mass=math.hypot(known.mass, INERTIA_ERROR.mass),
            centre=math.hypot(known.centre, INERTIA_ERROR.centre),
            shape=math.hypot(known.shape, INERTIA_ERROR.shape),
        )  # variances add
        harder["inertias less known"] = replace(loop, uncertainty=wider)
        if known.payload is None:
            laden = replace(known, payload=(mass, mass))
            harder["payload"] = replace(loop, uncertainty=laden)
    return {AS_GIVEN: loop, **harder}
