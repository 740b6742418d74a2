"""A base that moves and turns: its linear and angular acceleration load the joints."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Array
from ftcfa.checks import Check, check_fields
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.vibration.excitation import Process
from ftcfa.vibration.inputs.noise_input import (
    AXES,
    NoiseInput,
    Shaking,
    ability,
    check_axes,
    check_some_axis,
    columns,
)

NOT_TURNED = np.array([1.0, 0.0, 0.0, 0.0])
"""Quaternion of no rotation."""
TINY = 1e-150
"""Added to a rotation's angle, so that sin(a)/a is 1 at zero [rad]."""


@dataclass(frozen=True, eq=False)
class BaseMotion(NoiseInput):
    """The base moves and turns; xi is its linear and angular acceleration.

        M q'' + C v + h(q; R^T g - a) + M_qb[angular] omega' + c(q; omega, v) = u

    with a = v_b' + omega x v_b [m/s^2], what an accelerometer at the base's origin shows less
    gravity; omega' [rad/s^2]; R the base's orientation, R' = R [omega]x; and c the centrifugal and
    Coriolis force of `Arm.base_rotation_force`. The axes turn with the base; level, they are the
    world's.

    omega is the stationary integral W of omega', and the base swings about level: it begins at
    exp(U), U the stationary integral of W. Both must exist, so the density of omega' has to vanish
    at 0 Hz like f^4; under white noise the base would spin ever faster, under less it would tip
    over. Turns about one axis stay exp(U). Those about several do not commute, and what remains of
    them, R = D exp(U), grows as they do on a real base whose gyroscopes show omega: to second
    order in the angle.

    Attributes:
        linear: Axes of the linear acceleration, in the order of the channels.
        angular: Axes of the angular acceleration, channels after the linear ones.
    """

    linear: Annotated[Sequence[str], Check(check_axes)] = "xyz"
    angular: Annotated[Sequence[str], Check(check_axes)] = "xyz"

    def __post_init__(self) -> None:
        check_fields(self)
        check_some_axis("BaseMotion linear and angular", self.linear, self.angular)

    def matrix(self, arm: Dynamics, q: Array) -> Array:
        """Lambda(q) = -M_qb(q) of the level base at rest, shape (n, m)."""
        return -arm.base_coupling(q)[:, columns(self.linear, self.angular)]

    def check(self, process: Process) -> None:
        """Raise ParameterError unless the base swings about level in every angular channel."""
        for channel, axis in enumerate(self.angular, len(self.linear)):
            obstacle = process.obstacle(channel)
            if obstacle:
                raise ParameterError(
                    f"BaseMotion: angular acceleration about {axis}",
                    obstacle,
                    "one whose density vanishes at 0 Hz like f^4, or the base tips over",
                    "take ShapedNoise.from_psd, RandomPhase, a record with its high_pass, or shake "
                    "linearly only",
                )

    def init(self) -> Any:
        """D at the start, a unit quaternion, shape (4,); nothing where no axis turns."""
        return NOT_TURNED if self.angular else ()

    def impulse(
        self, arm: Dynamics, q: Array, v: Array, state: Any, shaking: Shaking, step: float
    ) -> tuple[Array, Any]:
        """See `NoiseInput.impulse`; the state is D, a unit quaternion.

        With omega = W and R = D exp(U):

            impulse = -M_qb Y + h (M_qb[linear] (R^T g - g) - c(q; omega, v))
            D+      = D exp(U) exp(t) exp(-U - t),   t = h (W + Y/2)
        """
        if not self.angular:
            return super().impulse(arm, q, v, state, shaking, step)
        chosen = np.eye(3)[:, [AXES.index(axis) for axis in self.angular]]  # (3, angular)
        Y, omega, U = (chosen @ one[len(self.linear) :] for one in shaking)
        turned = _product(state, _rotation(U))
        gravity = ability(arm, "gravity", "BaseMotion")
        tilt = arm.base_coupling(q)[:, :3] @ (_into_base(turned, gravity) - gravity)
        force = ability(arm, "base_rotation_force", "BaseMotion")(q, v, omega)
        impulse = self.matrix(arm, q) @ shaking.integral + step * (tilt - force)
        t = step * (omega + Y / 2.0)
        return impulse, _product(_product(turned, _rotation(t)), _rotation(-U - t))


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


def _product(a: Array, b: Array) -> Array:
    """Quaternion of a rotation and then another one, in the axes that it turned, shape (4,)."""
    w = a[0] * b[0] - a[1:] @ b[1:]
    return np.concatenate([np.reshape(w, (1,)), a[0] * b[1:] + b[0] * a[1:] + _cross(a[1:], b[1:])])


def _rotation(angle: Array) -> Array:
    """Quaternion exp of a rotation vector, shape (3,) [rad] -> (4,)."""
    half = np.sqrt(angle @ angle) / 2.0 + TINY
    return np.concatenate([np.reshape(np.cos(half), (1,)), np.sin(half) / half * angle / 2.0])
