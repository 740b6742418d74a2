"""Variants of a loop to compare it with: other laws, its law without a part, harder conditions."""

import math
from collections.abc import Iterable
from dataclasses import replace

from ftcfa.control.ftcf import FTCF
from ftcfa.control.laws import ABLATIONS, CONTROLLERS, ablated
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.uncertainty import Uncertainty

AS_GIVEN = "as given"
"""Name of the loop itself."""
PERIODS = (2, 4)
"""Factors of longer sampling periods; the integration step stays."""
LEVELS = (2, 4)
"""Factors of the amplitude of stronger vibrations."""
INERTIA_ERROR = Uncertainty(mass=0.2, centre=0.01, shape=0.1)
"""Additional uncertainty of the inertias."""
OF_URDF = ("SlotineLi",)
"""Laws that need the regressor of an Arm."""
PAYLOAD = 0.1
"""Payload at the tip, as a share of the moving mass."""


def rivals(loop: ClosedLoop, names: str | Iterable[str] | None = None) -> dict[str, ClosedLoop]:
    """The loop as given, then the loop under other laws with the same nominal arm.

    The others have the defaults that the rule of `ftcfa.control.laws` gives them.

    Args:
        loop: The loop; all laws get the nominal arm of its law.
        names: Names in `ftcfa.control.laws.CONTROLLERS`, such as ``"PDGravity"``; by default all
            that the arm allows.

    Raises:
        UnknownNameError: If a name is not that of a law; the error lists the known names.
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
    """The loop as given, then the loop without one part of its law at a time.

    Raises:
        ParameterError: If its law is not the paper's.
    """
    law = loop.controller
    if not isinstance(law, FTCF):
        got = f"a loop under {type(law).__name__}"
        raise ParameterError("ablations", got, "a loop under FTCF")
    without = {name: replace(loop, controller=ablated(law, name)) for name in ABLATIONS}
    return {AS_GIVEN: loop, **without}


def conditions(loop: ClosedLoop) -> dict[str, ClosedLoop]:
    """The loop as given, then the loop under one harder condition at a time.

    The conditions are longer sampling periods; stronger vibration; robots whose masses have an
    additional spread of 20 % (centres 1 cm, shapes 10 %); and a payload at the tip, a tenth of the
    moving mass, that the law does not know.
    """
    harder = {
        f"period x {k}": replace(loop, period=k * loop.period, substeps=k * loop.substeps)
        for k in PERIODS
    }
    if loop.vibration is not None:
        for k in LEVELS:
            stronger = replace(loop.vibration, level=k * loop.vibration.level)
            harder[f"vibration x {k}"] = replace(loop, vibration=stronger)
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
