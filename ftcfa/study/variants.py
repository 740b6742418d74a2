"""What to compare a loop with: its rivals, itself less an ingredient, harder conditions."""

from collections.abc import Iterable
from dataclasses import replace
from typing import cast

from ftcfa.control.ftcf import FTCF
from ftcfa.control.rivals import ABLATIONS, CONTROLLERS, ablated
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
PAYLOAD = 0.1
"""Of the moving mass, at the tip."""


def rivals(loop: ClosedLoop, names: Iterable[str] | None = None) -> dict[str, ClosedLoop]:
    """The loop under other laws, each with its defaults on the same nominal arm.

    Args:
        loop: The loop; its law's nominal arm is that of all.
        names: Of `ftcfa.control.rivals.CONTROLLERS`; all of them by default.

    Raises:
        UnknownNameError: If there is no law of a name; it lists those there are.
    """
    nominal = getattr(loop.controller, "nominal", loop.arm)
    chosen = list(CONTROLLERS) if names is None else list(names)
    for name in chosen:
        if name not in CONTROLLERS:
            raise UnknownNameError("controller", str(name), tuple(CONTROLLERS))
    return {name: replace(loop, controller=CONTROLLERS[name](nominal)) for name in chosen}


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

    Longer periods, stronger vibration, robots that are not quite the model, and a payload of a
    tenth of the moving mass at the tip, of which the law knows nothing.
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
        harder["inertias to 20 %"] = replace(loop, uncertainty=INERTIA_ERROR)
        harder["payload"] = replace(loop, uncertainty=Uncertainty(payload=(mass, mass)))
    return {AS_GIVEN: loop, **harder}
