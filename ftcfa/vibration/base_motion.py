"""A base that moves and turns: its linear and angular acceleration load the joints."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ftcfa.arrays import Array
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.vibration.excitation import Process
from ftcfa.vibration.noise_input import AXES, ability, check_axes, columns

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
"""Quaternion of a base that stands as it was mounted."""
TINY = 1e-150
"""Added to a rotation's angle, so that sin(a)/a is 1 at zero [rad]."""


@dataclass(frozen=True, eq=False)
class BaseMotion:
    """The base moves and turns; xi is its linear and angular acceleration.

        M q'' + C v + h(q; R^T g - a) + M_qb[angular] omega' + c(q; omega, v) = u

    with a = v_b' + omega x v_b [m/s^2], what an accelerometer at the base's origin shows less
    gravity; omega' [rad/s^2]; R the base's orientation, R' = R [omega]x, level at the start; and c
    the centrifugal and Coriolis force of `Arm.base_rotation_force`. The axes turn with the base;
    level, they are the world's.

    omega is the stationary integral of omega', which is why its spectrum has to vanish at 0 Hz:
    under white noise it would be a random walk, and the base would spin ever faster.

    Attributes:
        linear: Axes of the linear acceleration, in the order of the channels.
        angular: Axes of the angular acceleration, channels after the linear ones.
    """

    linear: Sequence[str] = "xyz"
    angular: Sequence[str] = "xyz"

    def __post_init__(self) -> None:
        check_axes("BaseMotion linear and angular", self.linear, self.angular)

    def matrix(self, arm: Dynamics, q: Array) -> Array:
        """Lambda(q) = -M_qb(q) of the level base at rest, shape (n, m)."""
        return -arm.base_coupling(q)[:, columns(self.linear, self.angular)]

    def check(self, process: Process) -> None:
        """Raise ParameterError unless every angular acceleration has a stationary integral."""
        first = len(self.linear)
        for channel, axis in enumerate(self.angular, first):
            if channel not in process.integrable:
                raise ParameterError(
                    f"BaseMotion: angular acceleration about {axis}",
                    "white, or of a density that does not vanish at 0 Hz: the base's angular "
                    "velocity would be a random walk",
                    "a band-limited excitation",
                    "take ShapedNoise.from_psd, RandomPhase, a record, or shake linearly only",
                )

    def init(self) -> Array:
        """The base's orientation at the start, a unit quaternion, shape (4,)."""
        return LEVEL

    def impulse(
        self,
        arm: Dynamics,
        q: Array,
        v: Array,
        orientation: Array,
        integral: Array,
        rate: Array,
        step: float,
    ) -> tuple[Array, Array]:
        """Joint impulse over one step, and the base's orientation at its end.

            -M_qb Y + h (M_qb[linear] (R^T g - g) - c(q; omega, v))

        Args:
            arm: The true robot.
            q: Position at the start of the step, shape (n,) [rad or m].
            v: Velocity there, shape (n,) [rad/s or m/s].
            orientation: Quaternion of the base there, shape (4,).
            integral: Y, integral of xi over the step, shape (m,) [m/s, rad/s].
            rate: Integral of xi up to the start of the step, shape (m,); its angular part is
                omega.
            step: h [s].
        """
        first = len(self.linear)
        chosen = np.eye(3)[:, [AXES.index(axis) for axis in self.angular]]  # (3, angular)
        omega = chosen @ rate[first:]
        turned = omega + chosen @ integral[first:] / 2.0  # at the middle of the step
        gravity = ability(arm, "gravity", "BaseMotion")
        tilt = arm.base_coupling(q)[:, :3] @ (_into_base(orientation, gravity) - gravity)
        force = ability(arm, "base_rotation_force", "BaseMotion")(q, v, omega)
        impulse = self.matrix(arm, q) @ integral + step * (tilt - force)
        return impulse, _turn(orientation, step * turned)


def _cross(a: Array, b: Array) -> Array:
    """Cross product a x b, shape (3,)."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _into_base(orientation: Array, x: Array) -> Array:
    """R^T x for the rotation R of a unit quaternion (w, u)."""
    w, u = orientation[0], orientation[1:]
    c = _cross(u, x)
    return x - 2.0 * w * c + 2.0 * _cross(u, c)


def _turn(orientation: Array, angle: Array) -> Array:
    """The orientation after a rotation vector in its own axes, shape (3,) [rad]."""
    half = np.sqrt(angle @ angle) / 2.0 + TINY
    w, u = orientation[0], orientation[1:]
    c, s = np.cos(half), np.sin(half) / half * angle / 2.0
    vector = w * s + c * u + _cross(u, s)
    return np.concatenate([np.reshape(w * c - u @ s, (1,)), vector])
