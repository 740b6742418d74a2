"""Which entries of a state a traced loop takes for constant."""

import numpy as np
import pytest

from ftcfa import FTCF, ClosedLoop, Constant, PDGravity, load_arm
from ftcfa.engine.compiler.trace import trace

ARM = load_arm("double_pendulum")


def constants(law, **changes):
    loop = ClosedLoop(ARM, law, Constant([0.1, 0.2]), **changes)
    return int(np.sum(trace(loop, ["u"]).constant))


@pytest.mark.parametrize(
    ("law", "entries"),
    [
        (FTCF(ARM), 2),  # s2
        (FTCF(ARM, error_compensation=False), 4),  # and s1
        (FTCF(ARM, anti_saturation="none", adaptation=False), 5),  # s2, rho, theta
        (PDGravity(ARM), 0),
    ],
)
def test_what_stays_zero_is_found(law, entries):
    assert constants(law) == entries


class Counting(PDGravity):
    """A state that starts as a constant and grows, one that stays, and one that follows it."""

    def init(self, measured, desired):
        return np.zeros(1), np.full(1, 3.0), np.full(1, 3.0)

    def step(self, state, measured, desired, period):
        signals, _ = super().step((), measured, desired, period)
        count, three, follower = state
        return signals, (count + 1.0, three, 2.0 * follower - three)


def test_a_state_that_moves_is_not_taken_for_constant():
    assert constants(Counting(ARM)) == 2
