"""The dynamics of an arm as CasADi expressions, compared with Pinocchio when they are built.

The recursions use the constants of one Arm. CasADi folds them, so that the expressions contain
only the arithmetic that this robot needs.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import ClassVar

import casadi as ca

from ftcfa.arrays import Array, Traceable
from ftcfa.model.abstract_arm import AbstractArm
from ftcfa.model.arm import Arm
from ftcfa.model.pose import Pose
from ftcfa.model.recursions import Chain
from ftcfa.model.rigid_body import Body, bodies_of
from ftcfa.model.symbols import SymbolArray, array, column
from ftcfa.parts import Parameter, Parameters, number_fields
from ftcfa.portable import product


@dataclass(frozen=True, eq=False)
class TracedArm(AbstractArm):
    """The twin of an Arm: the same methods, for symbols.

    Fields of its `varies` are numbers, or symbols where they are inputs of compiled code; the
    others are constants, `inertial_weights` included, whatever the bodies are.
    """

    gravity: Array
    inertial_weights: Array
    chain: Chain
    bodies: Traceable  # regrouped parameters of the moving joints' bodies, (moving ENTRIES,)

    @classmethod
    def of(cls, arm: Arm) -> "TracedArm":
        """The twin of an Arm, unchecked."""
        names = (*(field.name for field in fields(AbstractArm)), "gravity", "inertial_weights")
        chain = Chain(arm)
        bodies = product(chain.regrouping, arm.inertias.reshape(-1, 1))[:, 0]
        return cls(**{name: getattr(arm, name) for name in names}, chain=chain, bodies=bodies)

    def regrouped(self, inertias: Array) -> Array:
        """Regrouped inertial parameters, shape (paths, moving ENTRIES), of those of an Arm."""
        regrouping = self.chain.regrouping
        rows = inertias.reshape(len(inertias), regrouping.shape[1])
        return product(regrouping, rows.T).T

    def with_bodies(self, bodies: Traceable) -> "TracedArm":
        """The same arm with other regrouped inertial parameters, numbers or symbols."""
        return replace(self, bodies=bodies)

    varies: ClassVar[Parameters] = {
        **number_fields("home", "lower", "upper", "velocity_limit"),
        **number_fields("effort_limit", "damping", "friction", "armature"),
        "inertias": Parameter(with_bodies, prepare=regrouped),
    }

    @cached_property
    def _inertia(self) -> ca.Function:
        """Function q -> M of the bodies (n, n), M_qb (n, 6)."""
        q, G = ca.SX.sym("q", self.n), self.chain.G
        M, coupling = self.chain.composite_inertia(q, self._bodies)
        return self._function("inertia", [q], [G.T @ M @ G, G.T @ coupling])

    @cached_property
    def _forces(self) -> ca.Function:
        """Function q, v -> C v + h (n,)."""
        q, v, chain = ca.SX.sym("q", self.n), ca.SX.sym("v", self.n), self.chain
        force = chain.inverse_dynamics(q, v, self._bodies, gravity=chain.gravity)
        return self._function("forces", [q, v], [chain.G.T @ force])

    @cached_property
    def _rotation_forces(self) -> ca.Function:
        """Function q, v, omega -> c_cent + c_cor (n,)."""
        q, v, omega = ca.SX.sym("q", self.n), ca.SX.sym("v", self.n), ca.SX.sym("omega", 3)
        turning = self.chain.inverse_dynamics(q, v, self._bodies, omega=omega)
        still = self.chain.inverse_dynamics(q, v, self._bodies)
        return self._function("rotation", [q, v, omega], [self.chain.G.T @ (turning - still)])

    def _function(self, name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(name, [*inputs, self._parameters], outputs, {"cse": True})

    @cached_property
    def _parameters(self) -> ca.SX:
        """Symbols of the bodies as an input of the functions; empty if the bodies are numbers."""
        return column(self.bodies) if isinstance(self.bodies, SymbolArray) else ca.SX(0, 1)

    @cached_property
    def _bodies(self) -> list[Body]:
        """The bodies; parameters that regrouping makes zero for any inertia are exact zeros."""
        nonzero = ca.DM(self.chain.regrouping.any(axis=1).astype(float))
        return bodies_of(column(self.bodies) * nonzero)

    def mass_matrix(self, q: Traceable) -> Traceable:
        """M(q), shape (n, n)."""
        return array(self._inertia(column(q), self._parameters)[0], 2) + self.rotor_matrix

    def coriolis_matrix(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) from Christoffel's symbols, shape (n, n).

        C = (M' + J - J^T)/2,   J = d(M v)/dq,   M' = sum_k dM/dq_k v_k
        """
        return array(self._coriolis(column(q), column(v), self._parameters), 2)

    @cached_property
    def _coriolis(self) -> ca.Function:
        q, v = ca.SX.sym("q", self.n), ca.SX.sym("v", self.n)
        M = self._inertia(q, self._parameters)[0]
        J = ca.jacobian(M @ v, q)
        rate = ca.reshape(ca.jtimes(ca.vec(M), q, v), self.n, self.n)
        return self._function("coriolis", [q, v], [(rate + J - J.T) / 2])

    def potential_force(self, q: Traceable) -> Traceable:
        """h(q), shape (n,)."""
        return array(self._forces(column(q), ca.DM.zeros(self.n), self._parameters), 1)

    def bias_force(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) v + h(q) + f(v), shape (n,)."""
        force = self._forces(column(q), column(v), self._parameters)
        return array(force, 1) + self.friction_force(v)

    def regressor(self, q: Traceable, v: Traceable, v_r: Traceable, a_r: Traceable) -> Traceable:
        """Y(q, v, v_r, a_r), shape (n, 10 N); see `Arm.regressor`."""
        return array(self._regressor(*map(column, (q, v, v_r, a_r))), 2)

    @cached_property
    def _regressor(self) -> ca.Function:
        """Function q, v, v_r, a_r -> Jacobian of the bodies' M a_r + C v_r + h in p."""
        q, v, w, a = (ca.SX.sym(name, self.n) for name in ("q", "v", "w", "a"))
        chain, regrouping = self.chain, ca.sparsify(ca.DM(self.chain.regrouping))
        p = ca.SX.sym("p", regrouping.shape[1])
        bodies = bodies_of(regrouping @ p)
        M, _ = chain.composite_inertia(q, bodies)
        plus, minus = (chain.inverse_dynamics(q, rate, bodies) for rate in (v + w, v - w))
        weight = chain.inverse_dynamics(q, ca.SX(self.n, 1), bodies, gravity=chain.gravity)
        torque = M @ chain.G @ a + (plus - minus) / 4 + weight
        Y = ca.jacobian(chain.G.T @ torque, p)
        return ca.Function("regressor", [q, v, w, a], [Y], {"cse": True})

    def base_rotation_force(self, q: Traceable, v: Traceable, omega: Traceable) -> Traceable:
        """c_cent + c_cor of a turning base, shape (n,); see `Arm.base_rotation_force`."""
        return array(self._rotation_forces(*map(column, (q, v, omega)), self._parameters), 1)

    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q), shape (n, 6)."""
        return array(self._inertia(column(q), self._parameters)[1], 2)

    def pose(self, q: Traceable, frame: str | None = None) -> Pose:
        """Place of a frame, by default of the tool; see `Arm.pose`."""
        rotation, position = self.chain.pose(column(q), frame or self.tool)
        return Pose(array(rotation, 2), array(position, 1))

    def frame_jacobian(self, frame: str, q: Traceable) -> Traceable:
        """Jacobian of a link or joint of the URDF, shape (6, n); see `Arm.frame_jacobian`."""
        return array(self.chain.jacobian(column(q), frame), 2)
