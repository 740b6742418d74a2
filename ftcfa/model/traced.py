"""The dynamics of an arm as CasADi expressions, compared with Pinocchio when they are built.

The recursions use the constants of one Arm. CasADi folds them, so that the expressions contain
only the arithmetic that this robot needs.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np

from ftcfa.arrays import Array, Traceable, solve_spd
from ftcfa.errors import TracingError
from ftcfa.model.arm import Arm
from ftcfa.model.friction import damping_matrix
from ftcfa.model.recursions import Chain
from ftcfa.model.rigid_body import Body, bodies_of
from ftcfa.model.symbols import SymbolArray, array, column
from ftcfa.parts import Parameter, Parameters, number_fields

AGREEMENT = 1e-9
"""Largest difference from Pinocchio that is accepted, relative to the largest entry."""
NEGLIGIBLE = 1e-6
"""Quantities whose largest entry is below this are compared absolutely [SI units]."""
CHECKED_STATES = 8
"""Number of random states at which the expressions are compared."""


@dataclass(frozen=True, eq=False)
class TracedArm:
    """The twin of an Arm: the same methods, for symbols.

    Attributes:
        joint_names: Names of the coordinates.
        joint_types: Types of the coordinates.
        home: A posture to start from, shape (n,).
        lower: Lower joint limits, shape (n,).
        upper: Upper joint limits, shape (n,).
        velocity_limit: Velocity limits, shape (n,).
        gravity: Gravity field, shape (3,) [m/s^2].
        linear_map: G of the Arm, shape (N, n); a constant here, hence another name.
        damping: Viscous friction, shape (N,); numbers, or symbols if it is an input.
        friction: Coulomb friction, shape (N,); likewise.
        chain: Geometry and recursions.
        bodies: Regrouped inertial parameters of the moving joints' bodies, one after the other,
            shape (moving ENTRIES,); likewise.
        effort_limit: u*, shape (n,) [N m or N]; likewise.
        inertial_weights: Weights of the Arm; a constant here, whatever the bodies are.
    """

    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    home: Array
    lower: Array
    upper: Array
    velocity_limit: Array
    gravity: Array
    linear_map: Array
    damping: Traceable
    friction: Traceable
    chain: Chain
    bodies: Traceable
    effort_limit: Traceable
    inertial_weights: Array

    @classmethod
    def of(cls, arm: Arm) -> "TracedArm":
        """The twin of an Arm, unchecked."""
        chain = Chain(arm)
        return cls(
            joint_names=arm.joint_names,
            joint_types=arm.joint_types,
            home=arm.home,
            lower=arm.lower,
            upper=arm.upper,
            velocity_limit=arm.velocity_limit,
            gravity=arm.gravity,
            linear_map=arm.G,
            damping=arm.damping,
            friction=arm.friction,
            chain=chain,
            bodies=chain.regrouping @ arm.inertias.ravel(),
            effort_limit=arm.effort_limit,
            inertial_weights=arm.inertial_weights,
        )

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.joint_names)

    def regrouped(self, inertias: Array) -> Array:
        """Regrouped inertial parameters, shape (paths, moving ENTRIES), of those of an Arm."""
        regrouping = self.chain.regrouping
        rows = inertias.reshape(len(inertias), regrouping.shape[1])
        return np.einsum("pj,ij->pi", rows, regrouping)

    def with_bodies(self, bodies: Traceable) -> "TracedArm":
        """The same arm with other regrouped inertial parameters, numbers or symbols."""
        return replace(self, bodies=bodies)

    varies: ClassVar[Parameters] = {
        **number_fields("home", "lower", "upper", "velocity_limit"),
        **number_fields("effort_limit", "damping", "friction"),
        "inertias": Parameter(with_bodies, prepare=regrouped),
    }

    @cached_property
    def _inertia(self) -> ca.Function:
        """Function q -> M (n, n), M_qb (n, 6)."""
        q, G = ca.SX.sym("q", self.n), self.chain.G
        M, coupling = self.chain.composite_inertia(G @ q + self.chain.g0, self._bodies)
        return self._function("inertia", [q], [G.T @ M @ G, G.T @ coupling])

    @cached_property
    def _forces(self) -> ca.Function:
        """Function q, v -> C v + h (n,)."""
        q, v, G = ca.SX.sym("q", self.n), ca.SX.sym("v", self.n), self.chain.G
        force = self.chain.inverse_dynamics(
            G @ q + self.chain.g0, G @ v, self._bodies, self.chain.gravity, ca.SX(3, 1)
        )
        return self._function("forces", [q, v], [G.T @ force])

    @cached_property
    def _rotation_forces(self) -> ca.Function:
        """Function q, v, omega -> c_cent + c_cor (n,)."""
        q, v, omega = ca.SX.sym("q", self.n), ca.SX.sym("v", self.n), ca.SX.sym("omega", 3)
        chain, G = self.chain, self.chain.G

        def force(w: ca.SX) -> ca.SX:
            at = G @ q + chain.g0
            return chain.inverse_dynamics(at, G @ v, self._bodies, ca.SX(3, 1), w)

        difference = force(omega) - force(ca.SX(3, 1))
        return self._function("rotation_forces", [q, v, omega], [G.T @ difference])

    def _function(self, name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(name, [*inputs, self._parameters], outputs, {"cse": True})

    @cached_property
    def _parameters(self) -> ca.SX:
        """Symbols of the bodies as an input of the functions; empty if the bodies are numbers."""
        symbolic = isinstance(self.bodies, SymbolArray)
        return column(self.bodies) if symbolic else ca.SX(0, 1)

    @cached_property
    def _bodies(self) -> list[Body]:
        """The bodies; parameters that regrouping makes zero for any inertia are exact zeros."""
        nonzero = ca.DM(self.chain.regrouping.any(axis=1).astype(float))
        return bodies_of(column(self.bodies) * nonzero)

    def mass_matrix(self, q: Traceable) -> Traceable:
        """M(q), shape (n, n)."""
        return array(self._inertia(column(q), self._parameters)[0], 2)

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

    def damping_matrix(self, v: Traceable) -> Traceable:
        """D(v), shape (n, n); see `ftcfa.model.friction.damping_matrix`."""
        return damping_matrix(self.linear_map, self.damping, self.friction, v)

    def friction_force(self, v: Traceable) -> Traceable:
        """f(v), shape (n,)."""
        return self.damping_matrix(v) @ v

    def bias_force(self, q: Traceable, v: Traceable) -> Traceable:
        """C(q, v) v + h(q) + f(v), shape (n,)."""
        force = self._forces(column(q), column(v), self._parameters)
        return array(force, 1) + self.friction_force(v)

    def regressor(self, q: Traceable, v: Traceable, v_r: Traceable, a_r: Traceable) -> Traceable:
        """Y(q, v, v_r, a_r), shape (n, 10 N); see `Arm.regressor`."""
        return array(self._regressor(*map(column, (q, v, v_r, a_r))), 2)

    @cached_property
    def _regressor(self) -> ca.Function:
        """Function q, v, v_r, a_r -> Jacobian of M a_r + C v_r + h in the inertial parameters."""
        q, v, w, a = (ca.SX.sym(name, self.n) for name in ("q", "v", "w", "a"))
        chain, G = self.chain, self.chain.G
        regrouping = ca.sparsify(ca.DM(chain.regrouping))
        p = ca.SX.sym("p", regrouping.shape[1])
        bodies = bodies_of(regrouping @ p)
        at, still = G @ q + chain.g0, ca.SX(3, 1)

        def force(rate: ca.SX, gravity: ca.SX) -> ca.SX:
            return chain.inverse_dynamics(at, G @ rate, bodies, gravity, still)

        M, _ = chain.composite_inertia(at, bodies)
        rotation = (force(v + w, still) - force(v - w, still)) / 4
        torque = M @ G @ a + rotation + force(ca.SX(self.n, 1), chain.gravity)
        return ca.Function("regressor", [q, v, w, a], [ca.jacobian(G.T @ torque, p)], {"cse": True})

    def forward_dynamics(self, q: Traceable, v: Traceable, tau: Traceable) -> Traceable:
        """M^-1 (tau - C v - h - f), shape (n,)."""
        return solve_spd(self.mass_matrix(q), tau - self.bias_force(q, v))

    def base_rotation_force(self, q: Traceable, v: Traceable, omega: Traceable) -> Traceable:
        """c_cent + c_cor of a turning base, shape (n,); see `Arm.base_rotation_force`."""
        return array(
            self._rotation_forces(column(q), column(v), column(omega), self._parameters), 1
        )

    def base_coupling(self, q: Traceable) -> Traceable:
        """M_qb(q), shape (n, 6)."""
        return array(self._inertia(column(q), self._parameters)[1], 2)

    def frame_jacobian(self, frame: str, q: Traceable) -> Traceable:
        """Jacobian of a link or joint of the URDF, shape (6, n); see `Arm.frame_jacobian`."""
        chain = self.chain
        J = chain.jacobian(chain.G @ column(q) + chain.g0, frame)
        return array(J @ chain.G, 2)


_twins: WeakKeyDictionary[Arm, TracedArm] = WeakKeyDictionary()


def traced(arm: Arm) -> TracedArm:
    """The twin of an Arm, checked against Pinocchio at random states.

    Raises:
        TracingError: If any quantity differs by more than AGREEMENT.
    """
    try:  # the earlier twin, unless the Pinocchio model has changed since
        _check(arm, _twins[arm])
    except (KeyError, TracingError):
        _twins[arm] = TracedArm.of(arm)
        _check(arm, _twins[arm])
    return _twins[arm]


def _check(arm: Arm, twin: TracedArm) -> None:
    """Raise TracingError unless a twin agrees with Pinocchio in the quantities of every loop.

    Quantities that few laws use (Coriolis matrix, base rotation) are built when a law needs them;
    the comparison of the traced loop with the interpreted one then covers them.
    """
    rng = np.random.default_rng(0)
    quantities: dict[str, tuple[Callable[..., Array], Callable[..., Array], int]] = {
        "mass matrix": (arm.mass_matrix, twin.mass_matrix, 1),
        "bias force": (arm.bias_force, twin.bias_force, 2),
        "potential force": (arm.potential_force, twin.potential_force, 1),
        "base coupling": (arm.base_coupling, twin.base_coupling, 1),
    }
    for _ in range(CHECKED_STATES):
        state = (rng.uniform(-np.pi, np.pi, arm.n), rng.standard_normal(arm.n))
        for name, (number, expression, arguments) in quantities.items():
            truth = number(*state[:arguments])
            value = np.asarray(expression(*state[:arguments]), dtype=float)
            error = np.max(np.abs(value - truth)) / max(np.max(np.abs(truth)), NEGLIGIBLE)
            if not error <= AGREEMENT:
                raise TracingError(
                    f"{arm.name}: traced {name}",
                    f"differs from Pinocchio's by {error:.1e} relative",
                    f"agreement to {AGREEMENT:g}",
                    'run it with engine="interpreted" and report this robot',
                )
