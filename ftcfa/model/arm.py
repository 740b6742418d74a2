"""The dynamics of an arm as numbers, computed by Pinocchio."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from numpy.random import Generator

from ftcfa.arrays import Array
from ftcfa.checks import known_name, vector
from ftcfa.errors import ParameterError
from ftcfa.model.abstract_arm import AbstractArm
from ftcfa.model.inertia import check_bodies, inertial_weights, perturbed_inertias
from ftcfa.model.pinocchio_model import (
    KinematicTree,
    TurningBase,
    body_inertias,
    frames_by_name,
    kinematic_tree,
    with_body_inertias,
)
from ftcfa.model.pose import Pose
from ftcfa.parts import Parameter, Parameters, cached, number_field, number_fields


@dataclass(frozen=True, eq=False)
class Arm(AbstractArm):
    """A fixed-base arm: a Pinocchio model and the linear map q_model = G q + g0.

    The map expresses mimic joints (and with them the paper's absolute angles) and locked joints,
    whose rows of G are zero. Every joint has one coordinate, so q and v are n-vectors.

        M = G^T (M_model + diag(armature)) G,   C = G^T C_model G,   h = G^T h_model,
        D = G^T D_model G

    An Arm owns Pinocchio's work space: use it in one thread at a time.

    Attributes:
        name: The robot's name or file.
        model: Pinocchio model of N single-axis joints.
        G: Linear part of the coordinate map, shape (N, n).
        g0: Constant part of the coordinate map, shape (N,).
        joint_names: URDF names of the n coordinates.
        joint_types: revolute, continuous or prismatic, for each coordinate.
        lower: Lower joint limits, shape (n,) [rad or m]; -inf where unlimited.
        upper: Upper joint limits, shape (n,) [rad or m]; inf where unlimited.
        velocity_limit: Velocity limits, shape (n,) [rad/s or m/s]; inf where not given.
        effort_limit: The saturation u*, shape (n,) [N m or N].
        damping: Viscous friction of the model's joints, shape (N,) [N m s/rad or N s/m].
        friction: Coulomb friction of the model's joints, shape (N,) [N m or N].
        armature: Inertia J r^2 at each model's joint of a rotor J behind a gear of ratio r, shape
            (N,) [kg m^2 or kg], without gyroscopic effect and coupling with the base.
        home: A posture to start from, shape (n,) [rad or m].
        tool: Name of the link or joint whose errors in metres are shown.
        warnings: Warnings about the URDF.
        source: Arguments that load the arm again, as plain data.
    """

    model: pin.Model
    g0: Array
    warnings: tuple[str, ...] = ()
    source: Mapping[str, Any] | None = None

    def __repr__(self) -> str:
        return f"Arm({self.name!r}, {self.n} joints)"

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @cached_property
    def _data(self) -> pin.Data:
        return self.model.createData()

    @property
    def moving_mass(self) -> float:
        """Mass of all bodies that some coordinate moves [kg]."""
        moving = set(np.flatnonzero(self.G.any(axis=1)) + 1)  # Pinocchio's joint 0 is the base
        bodies = zip(self.model.inertias[1:], self.model.supports[1:], strict=True)
        return float(sum(body.mass for body, above in bodies if moving.intersection(above)))

    @property
    def inertias(self) -> Array:
        """Inertial parameters of the model's N bodies in their joint frames, shape (N, 10).

        A row: m [kg], m c (3) [kg m]; Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin [kg m^2].
        """
        return body_inertias(self.model)

    @property
    def inertial_weights(self) -> Array:
        """Scale of the inertial parameters, shape (10 N,); see `ftcfa.model.inertia`."""
        return inertial_weights(self.inertias)

    def with_inertias(self, inertias: Array) -> "Arm":
        """The same arm with other inertial parameters, shape (N, 10) as in `inertias`.

        Raises:
            ShapeError: If the shape is wrong.
            ParameterError: If no body can have these parameters.
        """
        self.check_inertias(inertias)
        source = {**(self.source or {}), "inertias": np.asarray(inertias).tolist()}
        return replace(self, model=with_body_inertias(self.model, inertias), source=source)

    def with_joint_friction(
        self, damping: npt.ArrayLike | None = None, friction: npt.ArrayLike | None = None
    ) -> "Arm":
        """The same arm with other ``damping`` or ``friction`` of its joints, shape (N,) each.

        Raises:
            ShapeError: If a shape is wrong, or a coefficient is not finite.
            ParameterError: If a coefficient is negative.
        """
        changed: dict[str, Any] = {}
        for name, values in {"damping": damping, "friction": friction}.items():
            if values is not None:
                changed[name] = vector(f"{name} of {self.name}", values, len(self.g0), field=name)
                self.refuse_negative("friction", changed[name])
        lists = {name: values.tolist() for name, values in changed.items()}
        return replace(self, **changed, source={**(self.source or {}), **lists})

    def with_armature(self, armature: npt.ArrayLike) -> "Arm":
        """The same arm with other rotor inertias, shape (N,).

        Raises:
            ShapeError, ParameterError: If the shape is wrong, or an inertia is negative.
        """
        values = vector(f"armature of {self.name}", armature, len(self.g0), field="armature")
        self.refuse_negative("armature", values)
        by_name = dict(zip(list(self.model.names)[1:], values.tolist(), strict=True))
        return replace(self, armature=values, source={**(self.source or {}), "armature": by_name})

    def check_inertias(self, inertias: Array) -> None:
        """Raise unless inertial parameters, shape (..., N, 10), are those of possible bodies."""
        check_bodies(f"inertias of {self.name}", inertias, len(self.g0))

    def refuse_negative(self, name: str, values: Array) -> None:
        """Raise ParameterError if a value is below zero."""
        if not np.all(values >= 0):
            raise ParameterError(f"{name} of {self.name}", f"{values.min():g}", "numbers >= 0")

    def check_effort_limit(self, limits: Array) -> None:
        """Raise ParameterError unless all torque limits are positive."""
        if not np.all(limits > 0):
            raise ParameterError(f"effort_limit of {self.name}", f"{limits.min():g}", "numbers > 0")

    def tree(self) -> KinematicTree:
        """Constants of the model as plain arrays."""
        return kinematic_tree(self.model)

    @property
    def gravity(self) -> Array:
        """The gravity field, shape (3,) [m/s^2]."""
        return np.array(self.model.gravity.linear)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of the links and joints of the URDF, as `frame_jacobian` takes them."""
        return tuple(self._frames)

    @cached_property
    def _frames(self) -> dict[str, pin.Frame]:
        return frames_by_name(self.model)

    def __getstate__(self) -> dict[str, Any]:
        """State without Pinocchio's work space, which belongs to this object."""
        return {name: vars(self)[name] for name in vars(self).keys() - cached(self)}

    def _model_q(self, q: Array) -> Array:
        self._check_shape("q", q)
        return self.G @ q + self.g0

    def mass_matrix(self, q: Array) -> Array:
        """M(q), symmetric positive definite, shape (n, n) [kg m^2 or kg], by CRBA."""
        M = pin.crba(self.model, self._data, self._model_q(q))
        return self.G.T @ M @ self.G + self.rotor_matrix

    def coriolis_matrix(self, q: Array, v: Array) -> Array:
        """C(q, v) with M' - 2 C skew-symmetric, shape (n, n)."""
        C = pin.computeCoriolisMatrix(self.model, self._data, self._model_q(q), self._model_v(v))
        return self.G.T @ C @ self.G

    def potential_force(self, q: Array) -> Array:
        """h(q), the force against gravity, shape (n,) [N m or N]."""
        h = pin.computeGeneralizedGravity(self.model, self._data, self._model_q(q))
        return self.G.T @ h

    def bias_force(self, q: Array, v: Array) -> Array:
        """C(q, v) v + h(q) + f(v), shape (n,) [N m or N]."""
        b = pin.nonLinearEffects(self.model, self._data, self._model_q(q), self._model_v(v))
        return self.G.T @ b + self.friction_force(v)

    def regressor(self, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
        """Y(q, v, v_r, a_r), shape (n, 10 N), linear in the inertial parameters p = `inertias`.

            Y p = M a_r + C(q, v) v_r + h,   M of the bodies, without armature

        C v_r is bilinear and symmetric in v and v_r (Christoffel's C). It is therefore a quarter of
        the difference between C v at v + v_r and C v at v - v_r. v_r [rad/s or m/s] and a_r
        [rad/s^2 or m/s^2] are the reference velocity and acceleration, shape (n,) each.
        """
        at, zero = self._model_q(q), np.zeros(self.model.nv)

        def Y(v: Array, a: Array) -> Array:
            return np.array(pin.computeJointTorqueRegressor(self.model, self._data, at, v, a))

        plus, minus = Y(self._model_v(v + v_r), zero), Y(self._model_v(v - v_r), zero)
        return self.G.T @ (Y(zero, self._model_v(a_r)) + (plus - minus) / 4.0)

    def base_coupling(self, q: Array) -> Array:
        """M_qb(q), the joint-base block of the free-floating mass matrix, shape (n, 6).

        An acceleration a of the base at rest (linear, then angular, world axes, at the base
        origin) loads the joints with -M_qb a; gravity g loads them with h = -M_qb[linear] g.
        It is the centroidal momentum matrix, shifted from the centre of mass to the base origin.
        """
        A = pin.computeCentroidalMap(self.model, self._data, self._model_q(q))
        A = A.reshape(6, -1)  # for a single joint Pinocchio drops the second dimension
        at_base = np.vstack([A[:3], A[3:] + pin.skew(self._data.com[0]) @ A[:3]])
        return self.G.T @ at_base.T

    def pose(self, q: Array, frame: str | None = None) -> Pose:
        """Place of a link or joint of the URDF, by default of the tool, in world axes.

        Raises:
            UnknownNameError: If there is no such frame; the message lists the frames.
        """
        number = self._frame_number(frame or self.tool)
        pin.forwardKinematics(self.model, self._data, self._model_q(q))
        placement = pin.updateFramePlacement(self.model, self._data, number)
        return Pose(placement.rotation.copy(), placement.translation.copy())

    def position(self, q: Array, frame: str | None = None) -> Array:
        """Origin of a frame, shape (3,) [m]; see `pose`."""
        return self.pose(q, frame).position

    def _frame_number(self, frame: str) -> int:
        known_name(f"frame of {self.name}", frame, self._frames)
        return int(self.model.getFrameId(frame, self._frames[frame].type))

    def frame_jacobian(self, frame: str, q: Array) -> Array:
        """Jacobian of a link or joint of the URDF, shape (6, n).

        It maps v to the velocity of the frame's origin and its angular velocity, in world axes.
        Its transpose maps a force and a moment at the frame's origin to joint forces.

        Raises:
            UnknownNameError: If there is no such frame; the message lists the frames.
        """
        where = self._frame_number(frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(self.model, self._data, self._model_q(q), *where)
        return J.reshape(6, -1) @ self.G

    def base_rotation_force(self, q: Array, v: Array, omega: Array) -> Array:
        """Centrifugal and Coriolis load of a turning base, shape (n,) [N m or N].

            c_cent(q; omega, omega) + c_cor(q; omega, v)

        It is added to C v + h if the base turns with omega, shape (3,) [rad/s], in its own axes.
        The Coriolis part does no work, v^T c_cor = 0.
        """
        return self.G.T @ self._turning_base.force(self._model_q(q), self._model_v(v), omega)

    @cached_property
    def _turning_base(self) -> TurningBase:
        return TurningBase(self.model)

    def perturbed(
        self, rng: Generator, *, mass: float = 0.1, centre: float = 0.01, shape: float = 0.05
    ) -> "Arm":
        """The same arm with a random change of every body: the paper's M = Mbar + dM.

        Each pseudo-inertia stays positive (semi)definite, so every draw is a possible robot.

        Args:
            rng: Source of randomness.
            mass: Standard deviation of the logarithm of each mass.
            centre: Standard deviation of each coordinate of each centre of mass [m].
            shape: Standard deviation of the logarithm of lengths of each body.

        Raises:
            ParameterError: If a spread is not a number from 0 to LARGEST_SPREAD.
        """
        return self.with_inertias(perturbed_inertias(self.inertias, rng, mass, centre, shape))

    varies: ClassVar[Parameters] = {
        **number_fields("G", "g0", "home", "lower", "upper", "velocity_limit"),
        "effort_limit": number_field("effort_limit", check_effort_limit),
        "damping": number_field("damping", lambda arm, x: arm.refuse_negative("friction", x)),
        "friction": number_field("friction", lambda arm, x: arm.refuse_negative("friction", x)),
        "armature": number_field("armature", lambda arm, x: arm.refuse_negative("armature", x)),
        "inertias": Parameter(with_inertias, check_inertias),
    }
