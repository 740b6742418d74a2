"""The one protocol of all controllers.

Laws are pure and branch-free: no hidden state, no `if` on values (`np.where` instead). One
definition then runs on floats, and can be traced, compiled and exported.
"""

from typing import Any, NamedTuple, Protocol, TypeAlias

from ftcfa.arrays import Array

Signals: TypeAlias = dict[str, Array]
"""What a law computed in one step, by name; ``u`` is the commanded torque."""


class Desired(NamedTuple):
    """The desired motion at one instant."""

    q: Array
    """Desired position q_d, shape (n,) [rad or m]."""
    v: Array
    """Its first derivative, shape (n,) [rad/s or m/s]."""
    a: Array
    """Its second derivative, shape (n,) [rad/s^2 or m/s^2]."""


class Memoryless(NamedTuple):
    """The state of a law without one."""


class MemorylessLaw:
    """What laws without a memory share."""

    def init(self, q: Array, v: Array, desired: Desired) -> Memoryless:  # noqa: ARG002
        """Nothing to remember."""
        return Memoryless()


class Controller(Protocol):
    """A sampled control law. It sees the nominal arm, the measurement and the desired motion."""

    def init(self, q: Array, v: Array, desired: Desired) -> Any:
        """The state before the first step: a NamedTuple of arrays."""
        ...

    def step(
        self, state: Any, q: Array, v: Array, desired: Desired, period: float
    ) -> tuple[Signals, Any]:
        """One sample: the signals, ``u`` of shape (n,) [N m or N] among them, and the new state.

        Args:
            state: What `init` or the last step returned.
            q: Measured position, shape (n,) [rad or m].
            v: Measured velocity, shape (n,) [rad/s or m/s].
            desired: Desired motion at this sample.
            period: Time to the next sample [s].
        """
        ...
