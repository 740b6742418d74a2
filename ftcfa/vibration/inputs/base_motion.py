"""A base that moves and turns: its linear and angular acceleration load the joints."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ftcfa.arrays import Traceable
from ftcfa.checks import Check
from ftcfa.errors import ParameterError
from ftcfa.model.dynamics import Dynamics
from ftcfa.vibration.excitation import Process
from ftcfa.vibration.inputs.noise_input import (
    NoiseInput,
    StepIntegrals,
    arm_attribute,
    check_axes,
    check_some_axis,
    columns,
    placed,
    specific_force,
)

NOT_TURNED = np.array([1.0, 0.0, 0.0, 0.0])
"""Quaternion of no rotation."""
TINY = 1e-150
"""Added to the angle of a rotation, so that sin(a)/a is 1 at zero [rad]."""


@dataclass(frozen=True, eq=False)
class BaseMotion(NoiseInput):
    """Base that moves and turns; xi is its linear and angular acceleration.

        M q'' + C v + h(q; R^T g - a) + M_qb[angular] omega' + c(q; omega, v) = u

    with a = v_b' + omega x v_b [m/s^2], which is what an accelerometer at the base's origin shows
    less gravity; omega' [rad/s^2]; R the orientation of the base, R' = R [omega]x; and c the
    centrifugal and Coriolis force of `Arm.base_rotation_force`. The axes turn with the base; when
    it is level, they are the axes of the world.

    omega is the stationary integral W of omega', and the base turns back and forth about level: it
    begins at exp(U), U the stationary integral of W. Both integrals must exist, so the density of
    omega' has to vanish at 0 Hz like f^4. White noise would turn the base ever faster; a density
    that vanishes more slowly would turn it ever farther. Turns about one axis stay exp(U). Turns
    about several axes do not commute: the rest D in R = D exp(U) grows to second order in the
    angle, as on a real base whose gyroscopes show omega.

    Attributes:
        linear: Axes of the linear acceleration, in the order of the channels.
        angular: Axes of the angular acceleration, channels after the linear ones.
    """

    linear: Annotated[str | Sequence[str], Check(check_axes)] = "xyz"
    angular: Annotated[str | Sequence[str], Check(check_axes)] = "xyz"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_some_axis("BaseMotion linear and angular", self.linear, self.angular)

    @property
    def axes_of_motion(self) -> tuple[Sequence[str], Sequence[str]]:
        """Axes of linear and of angular acceleration, in the order of the channels."""
        return self.linear, self.angular

    def matrix(self, arm: Dynamics, q: Traceable) -> Traceable:
        """Lambda(q) = -M_qb(q) of the level base at rest, shape (n, m)."""
        return -arm.base_coupling(q)[:, columns(self.linear, self.angular)]

    def check(self, process: Process) -> None:
        """Raise ParameterError unless the base stays about level in every angular channel."""
        for channel, axis in enumerate(self.angular, len(self.linear)):
            reason = process.why_no_integrals(channel)
            if reason:
                raise ParameterError(
                    f"BaseMotion: angular acceleration about {axis}",
                    reason,
                    "one whose density vanishes at 0 Hz like f^4 and keeps the base about level",
                    "take ShapedNoise.from_psd, RandomPhase, a record with its high_pass, or shake "
                    "linearly only",
                )

    def init(self) -> Any:
        """D at the start, a unit quaternion, shape (4,); empty if no axis turns."""
        return NOT_TURNED if self.angular else ()

    def impulse(
        self,
        arm: Dynamics,
        q: Traceable,
        v: Traceable,
        state: Any,
        integrals: StepIntegrals,
        step: float,
    ) -> tuple[Traceable, Any]:
        """See `NoiseInput.impulse`; the state is D, a unit quaternion.

        With omega = W and R = D exp(U):

            impulse = -M_qb Y + h (M_qb[linear] (R^T g - g) - c(q; omega, v))
            D+      = D exp(U) exp(t) exp(-U - t),   t = h (W + Y/2)
        """
        if not self.angular:
            return super().impulse(arm, q, v, state, integrals, step)
        Y, omega, U = self._turning(integrals)
        turned = _product(state, _rotation(U))
        gravity = arm_attribute(arm, "gravity", "BaseMotion")
        tilt = arm.base_coupling(q)[:, :3] @ (_into_base(turned, gravity) - gravity)
        force = arm_attribute(arm, "base_rotation_force", "BaseMotion")(q, v, omega)
        impulse = self.matrix(arm, q) @ integrals.increment + step * (tilt - force)
        t = step * (omega + Y / 2.0)
        return impulse, _product(_product(turned, _rotation(t)), _rotation(-U - t))

    def base_motion(
        self, arm: Dynamics, state: Any, integrals: StepIntegrals, step: float
    ) -> Traceable:
        """See `NoiseInput.base_motion`; the tilt is that at the start of the step."""
        acceleration = placed(self.linear, integrals.increment[: len(self.linear)]) / step
        if not self.angular:
            return specific_force(arm, acceleration)
        Y, omega, U = self._turning(integrals)
        gravity = arm_attribute(arm, "gravity", "BaseMotion")
        felt = acceleration - _into_base(_product(state, _rotation(U)), gravity)
        return np.concatenate([felt, omega + Y / 2.0])

    def _turning(self, integrals: StepIntegrals) -> Iterator[Traceable]:
        """Y, omega and U about all three axes, shape (3,) each."""
        return (placed(self.angular, one[len(self.linear) :]) for one in integrals)


def _cross(a: Traceable, b: Traceable) -> Traceable:
    """Cross product a x b, shape (3,)."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _into_base(orientation: Traceable, x: Traceable) -> Traceable:
    """R^T x, R the rotation of a unit quaternion (w, u)."""
    w, u = orientation[0], orientation[1:]
    c = _cross(u, x)
    return x - 2.0 * w * c + 2.0 * _cross(u, c)


def _product(a: Traceable, b: Traceable) -> Traceable:
    """Quaternion of rotation a followed by rotation b in the turned axes, shape (4,)."""
    w = a[0] * b[0] - a[1:] @ b[1:]
    return np.concatenate([np.reshape(w, (1,)), a[0] * b[1:] + b[0] * a[1:] + _cross(a[1:], b[1:])])


def _rotation(angle: Traceable) -> Traceable:
    """Quaternion of a rotation vector, shape (3,) [rad] -> (4,)."""
    half = np.sqrt(angle @ angle) / 2.0 + TINY
    return np.concatenate([np.reshape(np.cos(half), (1,)), np.sin(half) / half * angle / 2.0])
