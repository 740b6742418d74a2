"""What a loop asks of its arm, seen before it runs: its limits, the start, gravity."""

import warnings
from typing import Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.loop.bounds import bounds_of, is_prismatic
from ftcfa.loop.closed_loop import ClosedLoop

TIMES = 2001
"""Largest number of times at which a reference is looked at."""
POSTURES = 51
"""Largest number of postures in which gravity is computed."""
TURN = 2 * np.pi
"""A revolute joint further than that from zero may be given in degrees [rad]."""
ROUNDING = 1e-9
"""Excess over a limit that is rounding, relative."""


def warn_of_doubts(loop: ClosedLoop, duration: float, frames: int = 1) -> None:
    """Warn of every doubt about a run (`doubts`); the user is some frames above the caller."""
    for doubt in doubts(loop, duration):
        warnings.warn(doubt, stacklevel=2 + frames)


def doubts(loop: ClosedLoop, duration: float) -> list[str]:
    """What an arm cannot do, or a reader would not mean, each in a sentence.

    A reference or a start outside the URDF's limits of position, a reference faster than its limits
    of velocity, a start further from the reference than the error at which a joint has lost track,
    and gravity on the reference above the effort limit. Each sentence names the worst joint, the
    time and the numbers.

    Args:
        loop: The loop; the robot of its controller and its own are taken as they are, not drawn.
        duration: Simulated time [s].
    """
    samples = round(duration / loop.period) + 1
    times = np.unique(np.linspace(0, samples - 1, min(samples, TIMES)).round()) * loop.period
    desired = loop.desired(times)
    bounds, start = bounds_of(loop.arm), np.asarray(loop.q0)[None]
    few = np.unique(np.linspace(0, len(times) - 1, min(len(times), POSTURES)).round()).astype(int)
    gravity = gravity_on(loop, desired.q[few])
    outside = "the reference", desired.q, bounds.lower, bounds.upper, times
    found = [
        _beyond(loop, *outside, "rad", desired.q),
        _beyond(loop, "the start q0", start, bounds.lower, bounds.upper, times[:1], "rad", start),
        _beyond(
            loop, "the velocity of the reference", desired.v, -bounds.velocity, bounds.velocity,
            times, "rad/s", desired.q,
        ),
        _far(loop, start[0], desired.q[0], bounds.error),
        _weak(loop, gravity, times[few]),
        loop.interface.note,
    ]  # fmt: skip
    return [doubt for doubt in found if doubt]


def gravity_on(loop: ClosedLoop, postures: Array) -> Array:
    """|h(q)| of the loop's arm in postures of shape (k, n), shape (k, n) [N m or N]."""
    rest = np.zeros(loop.arm.n)
    return np.array([np.abs(loop.arm.bias_force(q, rest)) for q in postures])


def unit_of(loop: ClosedLoop, joint: int, unit: str) -> str:
    """The unit of a joint: that of a revolute one, or m for its rad and N for its N m."""
    if loop.arm.joint_types[joint] != "prismatic":
        return unit
    return unit.replace("rad", "m").replace("N m", "N")


def _beyond(
    loop: ClosedLoop,
    subject: str,
    values: Array,
    lower: Any,
    upper: Any,
    times: Array,
    unit: str,
    positions: Array,
) -> str:
    """That values, shape (T, n), leave their limits; ``positions`` may be in degrees."""
    lower, upper = (np.broadcast_to(limit, values.shape[1:]) for limit in (lower, upper))
    excess = np.maximum(values - upper, lower - values)
    excess = np.where(excess > ROUNDING * np.abs(values), excess, 0.0)
    k, joint = np.unravel_index(np.argmax(excess), excess.shape)
    if not excess[k, joint] > 0.0:
        return ""
    other = np.flatnonzero(excess.max(axis=0) > 0.0)
    name, unit = loop.arm.joint_names[joint], unit_of(loop, int(joint), unit)
    where = f"{subject} is {values[k, joint]:.3g} {unit} at joint '{name}' at {times[k]:.3g} s"
    limits = f"its limits are {lower[joint]:.3g} and {upper[joint]:.3g} {unit}"
    names = [loop.arm.joint_names[i] for i in other if i != joint]
    also = f"; also beyond: {', '.join(names)}" if names else ""
    return f"{where}; {limits}{also}{_degrees(loop, int(joint), positions)}"


def _far(loop: ClosedLoop, start: Array, reference: Array, far: Array) -> str:
    """That the start is far from the reference."""
    error = np.abs(start - reference)
    joint = int(np.argmax(error / far))
    if not error[joint] > far[joint]:
        return ""
    unit, name = unit_of(loop, joint, "rad"), loop.arm.joint_names[joint]
    degrees = _degrees(loop, joint, np.stack([start, reference]))
    return (
        f"joint '{name}' starts at {start[joint]:.3g} {unit}, {error[joint]:.3g} {unit} from the "
        f"reference, {reference[joint]:.3g} {unit} at 0 s{degrees or '; start nearer with q0'}"
    )


def _weak(loop: ClosedLoop, gravity: Array, times: Array) -> str:
    """That gravity, shape (T, n), needs more than the effort limit."""
    limit = loop.arm.effort_limit
    k, joint = np.unravel_index(np.argmax(gravity / limit), gravity.shape)
    if not gravity[k, joint] > limit[joint]:
        return ""
    name, unit = loop.arm.joint_names[joint], unit_of(loop, int(joint), "N m")
    return (
        f"gravity needs {gravity[k, joint]:.3g} of {limit[joint]:.3g} {unit} at joint '{name}' on "
        f"the reference at {times[k]:.3g} s"
    )


def _degrees(loop: ClosedLoop, joint: int, positions: Array) -> str:
    """A question where positions of a joint, shape (T, n), look like degrees."""
    largest = np.max(np.abs(positions[:, joint]))
    if is_prismatic(loop.arm)[joint] or largest <= TURN:
        return ""
    turns, radians = largest / TURN, np.deg2rad(largest)
    return (
        f"; degrees? {largest:.3g} rad are {turns:.3g} turns, {largest:.3g} degrees are "
        f"{radians:.3g} rad"
    )
