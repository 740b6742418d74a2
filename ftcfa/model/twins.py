"""The twin of an arm for symbols, compared with Pinocchio when it is built."""

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np

from ftcfa.arrays import Array, Traceable
from ftcfa.errors import TracingError
from ftcfa.model.arm import Arm
from ftcfa.model.long_arm import LongArm
from ftcfa.model.traced import TracedArm

LONG = 14
"""Number of joints in a row from which the code of a loop is shorter without a mass matrix."""
AGREEMENT = 1e-9
"""Largest difference from Pinocchio that is accepted, relative to the largest entry."""
NEGLIGIBLE = 1e-6
"""Quantities whose largest entry is below this are compared absolutely [SI units]."""
CHECKED_STATES = 8
"""Number of random states at which the expressions are compared."""

_twins: WeakKeyDictionary[Arm, TracedArm] = WeakKeyDictionary()


def traced(arm: Arm) -> TracedArm:
    """The twin of an Arm, checked against Pinocchio at random states.

    Raises:
        TracingError: If any quantity differs by more than AGREEMENT.
    """
    try:  # the earlier twin, unless the Pinocchio model has changed since
        _check(arm, _twins[arm])
    except (KeyError, TracingError):
        _twins[arm] = unchecked(arm)
        _check(arm, _twins[arm])
    return _twins[arm]


def unchecked(arm: Arm) -> TracedArm:
    """The twin of an Arm, not compared with it."""
    moving = arm.G[arm.G.any(axis=1)]
    own_joints = len(moving) == arm.n and np.array_equal(moving.T @ moving, np.eye(arm.n))
    return (LongArm if own_joints and _joints_in_a_row(arm) >= LONG else TracedArm).of(arm)


def _joints_in_a_row(arm: Arm) -> int:
    """Largest number of moving joints between the base and a link."""
    counts = {-1: 0}
    for i, parent in enumerate(arm.tree().parents):
        counts[i] = counts[parent] + int(arm.G[i].any())
    return max(counts.values())


def _check(arm: Arm, twin: TracedArm) -> None:
    """Raise TracingError unless a twin agrees with Pinocchio in the quantities of every loop.

    Quantities that few laws use (Coriolis matrix, base rotation) are built when a law needs them;
    the comparison of the traced loop with the interpreted one then covers them.
    """
    rng = np.random.default_rng(0)
    for _ in range(CHECKED_STATES):
        q, v = rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n)
        for name, truth, value in _quantities(arm, twin, q, v):
            difference = np.max(np.abs(np.asarray(value, dtype=float) - truth))
            error = difference / max(np.max(np.abs(truth)), NEGLIGIBLE)
            if not error <= AGREEMENT:
                subject, expected = f"{arm.name}: traced {name}", f"agreement to {AGREEMENT:g}"
                got = f"differs from Pinocchio's by {error:.1e} relative"
                remedy = 'run it with engine="interpreted" and report this robot'
                raise TracingError(subject, got, expected, remedy)


def _quantities(
    arm: Arm, twin: TracedArm, q: Array, v: Array
) -> Iterator[tuple[str, Array, Traceable]]:
    """Name, Pinocchio's value and the twin's of each quantity at a state."""
    M = arm.mass_matrix(q)
    if isinstance(twin, LongArm):  # its loops form no mass matrix
        yield "inertial force", M @ v, twin.inertial_force(q, v)
        response = np.asarray(twin.impulse_response(q, v, v, 1.0), dtype=float)
        yield "impulse response", v, (M + arm.damping_matrix(v)) @ response
    else:
        yield "mass matrix", M, twin.mass_matrix(q)
    yield "bias force", arm.bias_force(q, v), twin.bias_force(q, v)
    yield "potential force", arm.potential_force(q), twin.potential_force(q)
    yield "base coupling", arm.base_coupling(q), twin.base_coupling(q)
