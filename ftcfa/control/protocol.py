"""The one protocol of all controllers, and the base of the laws of this package.

Laws are pure and branch-free: no hidden state, no `if` on values (`np.where` instead). One
definition then runs on floats, and can be traced, compiled and exported.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Protocol, TypeAlias

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check, having
from ftcfa.model.dynamics import Dynamics
from ftcfa.parts import Part, fields_of

Signals: TypeAlias = dict[str, Traceable]
"""Values that a law computes in one step, by name; ``u`` is the commanded torque."""

A_LAW = "a control law with init and step, such as FTCF(arm)"
"""How errors name what a controller is."""


class Quantity(NamedTuple):
    """Unit and meaning of a signal, as the label of a result shows them."""

    unit: str
    """SI unit for revolute joints, such as ``rad/s``; for prismatic joints m replaces rad."""
    meaning: str
    """Noun phrase, such as ``tracking error (5)``."""


Quantities: TypeAlias = Mapping[str, Quantity]
"""Unit and meaning of signals by name."""
Compensation = Literal["none", "gravity", "bias"]
"""Known force that a law adds to its torque: see `Law.known_force`."""


class Desired(NamedTuple):
    """The desired motion at one instant."""

    q: Traceable
    """Desired position q_d, shape (n,) [rad or m]."""
    v: Traceable
    """Desired velocity q_d', shape (n,) [rad/s or m/s]."""
    a: Traceable
    """Desired acceleration q_d'', shape (n,) [rad/s^2 or m/s^2]."""


class BaseReading(NamedTuple):
    """What an accelerometer on the arm's base shows, in axes that turn with the base.

    When the base is level, its axes are those of the world.
    """

    specific_force: Traceable
    """R^T (a_b - g), shape (3,) [m/s^2]; -g for a level base at rest."""
    angular_velocity: Traceable | None = None
    """omega, shape (3,) [rad/s]; None without a gyroscope."""


class Measured(NamedTuple):
    """What the sensors show at one instant."""

    q: Traceable
    """Measured position, shape (n,) [rad or m]."""
    v: Traceable
    """Measured or estimated velocity, shape (n,) [rad/s or m/s]."""
    base: BaseReading | None = None
    """Reading of the accelerometer on the base; None where there is none."""


class Controller(Protocol):
    """A sampled control law. It sees the nominal arm, the measurement and the desired motion.

    A law may also have the class attribute ``quantities: ClassVar[Quantities]``, the unit and
    meaning of every signal except ``u``; a signal that it does not list has no unit in
    results. All laws of this package list theirs.
    """

    def init(self, measured: Measured, desired: Desired) -> Any:
        """The state before the first step: a NamedTuple of arrays."""
        ...

    def step(
        self, state: Any, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, Any]:
        """One sample: the signals, ``u`` of shape (n,) [N m or N] among them, and the new state.

        Args:
            state: The state that `init` or the last step returned.
            measured: Measured motion of the joints, and of the base where it is measured.
            desired: Desired motion at this sample.
            period: Time to the next sample [s].
        """
        ...


@dataclass(frozen=True, eq=False)
class Law(Part):
    """Base of the laws of this package.

    Attributes:
        nominal: The arm as the controller knows it.
    """

    nominal: Annotated[Dynamics, Check(having("mass_matrix", "an Arm, such as load_arm gives"))]

    def __post_init__(self) -> None:
        super().__post_init__()
        for part in (self, *fields_of(self).values()):
            if isinstance(part, Part):
                part.check_joints(self.nominal.n)

    def known_force(
        self, choice: Compensation, q: Traceable, v: Traceable, v_r: Traceable
    ) -> Traceable:
        """Nominal force that a law adds to its torque, shape (n,) [N m or N].

        Friction is taken at the velocity v_r. Taken at the measured velocity, the friction of a
        light joint would change its sign or its size within a period, and the loop would creep or
        diverge.

        Args:
            choice: ``"none"``, ``"gravity"`` h(q), or ``"bias"`` C v + h + f.
            q: Measured position, shape (n,) [rad or m].
            v: Measured velocity, shape (n,) [rad/s or m/s].
            v_r: Velocity to which the law drives v, shape (n,) [rad/s or m/s].
        """
        arm = self.nominal
        match choice:
            case "gravity":
                return arm.potential_force(q)
            case "bias":
                friction = arm.damping_matrix(v_r) @ v_r - arm.damping_matrix(v) @ v
                return arm.bias_force(q, v) + friction
            case _:
                return np.zeros_like(q)


class Memoryless(NamedTuple):
    """The state of a law that has none."""


class MemorylessLaw(Law, ABC):
    """Base of the laws that have no state: they need `signals` only."""

    @abstractmethod
    def signals(self, measured: Measured, desired: Desired) -> Signals:
        """The signals of one sample: see `Controller.step`."""

    def init(self, measured: Measured, desired: Desired) -> Memoryless:
        """The empty state."""
        return Memoryless()

    def step(
        self, state: Memoryless, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, Memoryless]:
        """One sample of the law: see `Controller.step`."""
        return self.signals(measured, desired), state


def quantities(law: Controller) -> Quantities:
    """Unit and meaning of the signals that a law lists; empty for a law that lists none."""
    return getattr(law, "quantities", {})
