"""Why paths fail, in a sentence."""

import numpy as np
import xarray as xr

from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.feasibility import gravity_on, unit_of
from ftcfa.study.outcomes import KEPT, OUTCOMES

FAILING = 0.01
"""Share of paths that are not kept, above which there is a diagnosis."""
OFTEN = 0.5
"""Share of saturated samples above which saturation counts as the reason."""


def diagnosis(loop: ClosedLoop, dataset: xr.Dataset) -> str:
    """The joint that fails most often, what is saturated there, and what to try.

    Args:
        loop: The loop.
        dataset: The paths' outcomes, as `ftcfa.study.summary.summarise` gives them.

    Returns:
        A sentence or two; empty if at most 1 % of the paths fail.
    """
    outcome = dataset["outcome"].values
    failed = outcome != KEPT
    if np.mean(failed) <= FAILING:
        return ""
    kinds, counts = np.unique(outcome[failed], return_counts=True)
    kind = int(kinds[np.argmax(counts)])
    these = outcome == kind
    time = float(np.median(dataset["outcome_time"].values[these]))
    share = f"{100 * np.mean(failed):.3g} % of the paths fail; most {_past(kind)}"
    joints = dataset["outcome_joint"].values[these]
    joints = joints[joints >= 0]
    if not len(joints):
        hint = _anti_saturation(loop) or "try a shorter period, smaller gains or less vibration"
        return f"{share}, from {time:.3g} s on in the median: {hint}"
    joint = int(np.bincount(joints).argmax())
    name = loop.arm.joint_names[joint]
    shares = dataset["saturated_before"].values[these]
    before = float(np.median(shares[np.isfinite(shares)])) if np.isfinite(shares).any() else 0.0
    where = f"{share}, first at joint '{name}', from {time:.3g} s on in the median"
    saturated = f"a torque was beyond its limit in {100 * before:.0f} % of the time before"
    if time > 0.0:
        where = f"{where}; {saturated}"
    return f"{where}: {_advice(loop, dataset, joint, before)}"


def _past(kind: int) -> str:
    return {"lost track": "lose track", "broke a limit": "break a limit"}.get(
        OUTCOMES[kind], "diverge"
    )


def _advice(loop: ClosedLoop, dataset: xr.Dataset, joint: int, saturated: float) -> str:
    """What to try."""
    gravity = float(gravity_on(loop, dataset["q_d"].values)[:, joint].max())
    limit = float(loop.arm.effort_limit[joint])
    if gravity > limit:
        unit, name = unit_of(loop, joint, "N m"), loop.arm.joint_names[joint]
        return (
            f"gravity on the reference needs {gravity:.3g} of {limit:.3g} {unit} at joint "
            f"'{name}'; give it more torque or another reference"
        )
    limited = float(np.nanmedian(dataset["rate_limited"].values[:, joint]))
    if limited > OFTEN:
        return (
            f"the driver limits the rate of the torque there in {100 * limited:.0f} % of the "
            "samples; try smaller gains or a feed-forward of less bandwidth"
        )
    if saturated > OFTEN:
        more = "try a start nearer to the reference, a smaller c1 or more torque"
        hint = _anti_saturation(loop)
        return f"{hint}, or {more}" if hint else more
    return "try a reference further inside the limits, a slower one, or less vibration"


def _anti_saturation(loop: ClosedLoop) -> str:
    """The advice for the law as printed."""
    if getattr(loop.controller, "anti_saturation", "") != "paper":
        return ""
    return '(11) as printed winds up while a torque is saturated: take anti_saturation = "bounded"'
