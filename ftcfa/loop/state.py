"""The state of a closed loop, and what may watch it."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.control.protocol import Signals

DIVERGED = 1e4
"""A path whose |q| or |v| leaves this bound has diverged [rad, rad/s, m or m/s]."""


HALF = 0.5
"""Between the two values of `LoopState.restart`."""


class Motion(NamedTuple):
    """State that an integration step advances: that of the robot and that of the vibration."""

    q: Traceable
    """Position, shape (n,) [rad or m]."""
    v: Traceable
    """Velocity, shape (n,) [rad/s or m/s]."""
    vibration: Any = ()
    """State of the vibration."""
    hardware: Any = ()
    """State of the hardware that integration steps advance; empty without hardware."""


class Observer(Protocol):
    """Computes results of a path as it runs, such as its largest error: its state at the end."""

    def init(self, n: int) -> Any:
        """State before the first sample, for n joints: arrays in tuples."""
        ...

    def step(self, state: Any, signals: Signals, period: float) -> Any:
        """New state after a sample, in plain NumPy without branches on values.

        ``signals`` are those of `ClosedLoop.step`, and ``period`` is the sampling period [s].
        """
        ...


class LoopState(NamedTuple):
    """State of the closed loop at a sample."""

    motion: Motion
    """State of the plant."""
    controller: Any
    """State of the controller."""
    restart: Traceable | float = 0.0
    """1 while the law waits for a good measurement to start anew, else 0; shape () or (1,)."""
    hardware: Any = ()
    """What the hardware remembers from sample to sample; empty without hardware."""
    observer: Any = ()
    """State of the observer."""

    @property
    def q(self) -> Traceable:
        """Position, shape (n,) [rad or m]."""
        return self.motion.q

    @property
    def v(self) -> Traceable:
        """Velocity, shape (n,) [rad/s or m/s]."""
        return self.motion.v


def bounded(state: LoopState) -> Traceable:
    """1.0 while |q| and |v| are finite and within DIVERGED, else 0.0."""
    largest = np.max(np.abs(np.concatenate([state.q, state.v])))
    return np.where(largest < DIVERGED, 1.0, 0.0)
