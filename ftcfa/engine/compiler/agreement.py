"""Comparison of traced code with the loop that it was traced from, on some samples.

Tracing does not see a state that a law hides or a test of a value's type, and code that was traced
before does not follow a law that was changed since. Each of these changes the numbers.
"""

from collections.abc import Callable, Iterable, Iterator
from numbers import Number
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.control.protocol import Desired
from ftcfa.engine.compiler.flatten import flat, leaves, like, split
from ftcfa.errors import TracingError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.state import LoopState

SAMPLES = 3
AGAIN_SAMPLES = 1
"""Samples on which code that was proved before is compared again."""
AGREEMENT = 1e-6
"""Largest difference that is accepted, relative to the largest entry: room for rounding."""
NEGLIGIBLE = 1e-6
"""Quantities whose largest entry is below this are compared absolutely [SI units]."""
DISTURBANCE = 1e-3
"""Standard deviation by which states are moved away from zero, where sign(x) is discontinuous."""
START, MEMORY, MOTION = "state from init", "state from step", "motion"
DRIVE = "torque of the driver"
AGAIN = "state from init at a later sample"
"""Names of the quantities that are compared beside the signals."""


class Sample(NamedTuple):
    """One sample of a loop: its inputs, and its results as flat arrays by name."""

    state: LoopState
    desired: Desired
    initial: Array
    normals: Array
    row: Array
    deviates: Array
    results: dict[str, Array]


def check_pure(loop: ClosedLoop) -> None:
    """Compute some samples twice by the loop's own Python.

    Raises:
        TracingError: If the results differ, since a law hides a state, or if its state is not made
            of numbers.
    """
    state = loop.init(loop.first_desired)
    for leaf in leaves(state[1:]):
        if not isinstance(leaf, np.ndarray | Number):
            subject, got = f"{_author(loop, START)}: {START}", f"holds a {type(leaf).__name__}"
            expected = "numbers and arrays, in tuples or NamedTuples"
            raise TracingError(subject, got, expected, "return such a state")
    fault = "the same inputs gave results that differ by"
    remedy = "return everything that the law remembers as its state; draw no random numbers"
    for once, again in zip(_samples(loop), _samples(loop), strict=True):
        for name, values in again.results.items():
            _compare(loop, name, values, once, 0.0, fault, remedy)


def check_agreement(
    loop: ClosedLoop,
    by_code: Callable[[Sample], Iterable[tuple[str, Array]]],
    constant: npt.NDArray[np.bool_],
    count: int = SAMPLES,
) -> None:
    """Compute some samples by the loop's own Python and by its traced code.

    Args:
        loop: The loop.
        by_code: What the code makes of a sample, by name.
        constant: Entries of the state that the code takes for constant, shape (states,).
        count: Number of samples.

    Raises:
        TracingError: If they differ.
    """
    fault = "traced, it differs from the loop's own by"
    remedy = "hide no state, and do not test the type of a value"
    for sample in _samples(loop, constant, count):
        for name, values in by_code(sample):
            _compare(loop, name, values, sample, AGREEMENT, fault, remedy)


def _samples(
    loop: ClosedLoop, constant: npt.NDArray[np.bool_] | None = None, count: int = SAMPLES
) -> Iterator[Sample]:
    """The first samples by the loop's own Python, each from a state disturbed where it varies."""
    rng = np.random.default_rng(0)
    motions = loop.reference.at(np.arange(count) * loop.period)
    process = loop.process
    initial = rng.standard_normal(process.initial_normals)
    state: Any = None
    for k in range(count):
        desired = Desired(*(row[k] for row in motions))
        results = {}
        if state is None:
            state = loop.init(desired, initial)
            results[START] = flat(state)
        moved = flat(state)
        away = DISTURBANCE * rng.standard_normal(len(moved))
        moved = moved + (away if constant is None else np.where(constant, 0.0, away))
        arrays = split(moved, [np.shape(x) for x in leaves(state)])
        state = like(state, iter(arrays))
        normals = rng.standard_normal(process.normals)
        row = process.rows[k % len(process.rows)]
        deviates = rng.standard_normal(sum(loop.streams.values()))
        with np.errstate(all="ignore"):
            signals, drive, after = loop.control(state, desired, deviates)
            motion = loop.advance(state.motion, drive, normals, row)
        results |= {name: flat(value) for name, value in signals.items()}
        results |= {DRIVE: flat(drive), MEMORY: flat(after[1:]), MOTION: flat(motion)}
        if k == count - 1:  # init clears what a law hides, which the samples are to bring out
            results[AGAIN] = flat(loop.renewed(state, desired))
        yield Sample(state, desired, initial, normals, row, deviates, results)
        state = after._replace(motion=motion)


def _compare(
    loop: ClosedLoop, name: str, got: Array, sample: Sample, limit: float, fault: str, remedy: str
) -> None:
    """Raise TracingError if values of one quantity differ from those of a sample."""
    error = _difference(got, sample.results[name])
    if error > limit:
        subject = f"{_author(loop, name)}: {name}"
        raise TracingError(subject, f"{fault} {error:.1e} relative", f"at most {limit:g}", remedy)


def _difference(got: Array, expected: Array) -> float:
    """Largest difference, relative to the largest entry; equal infinities and NaNs agree."""
    if got.shape != expected.shape:
        return np.inf
    differ = (got != expected) & ~(np.isnan(got) & np.isnan(expected))
    if not differ.any():
        return 0.0
    with np.errstate(invalid="ignore"):
        error = np.nan_to_num(np.abs(got - expected)[differ], nan=np.inf)
    largest = np.max(np.abs(expected[np.isfinite(expected)]), initial=NEGLIGIBLE)
    return float(np.max(error) / largest)


def _author(loop: ClosedLoop, name: str) -> str:
    """Author of a quantity for a message: file and line of the law, or the plant's type."""
    if name == MOTION:
        return f"{type(loop.arm).__name__} and its vibration"
    law = getattr(type(loop.controller), "init" if name in (START, AGAIN) else "step", None)
    code = getattr(law, "__code__", None)
    where = f"{code.co_filename}, line {code.co_firstlineno}: " if code else ""
    return f"{where}{type(loop.controller).__name__}"
