"""The generator L V of Definition 2 on the closed loop, by automatic differentiation.

    V  = |v1|^4/4 + |v2|^4/4 + (theta - thetahat)^2/(2 lambda) + w_s (|s1|^4 + |s2|^4)/4
    LV = V_x f + 1/2 Tr(Phi^T V_xx Phi)

(Definition 2 with the transpose that the paper leaves out.) f is the drift of the continuous
closed loop, of which the sampled one is the discretisation: the controller's rates are the
derivatives of its own step in the period where the period vanishes, the plant's are those of (4).
Phi is the noise, M^-1 Lambda Sigma in the rows of v and zero elsewhere: abar is the state of a
filter and q has no noise, so that none reaches v2 through them (as it would in (13) as printed).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import casadi as ca
import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array, solve_spd
from ftcfa.control.fractional import sig
from ftcfa.control.ftcf import FTCF, FTCFState
from ftcfa.control.protocol import Desired, Signals
from ftcfa.engine.compiler.flatten import leaves, like
from ftcfa.errors import ParameterError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.twin import twin
from ftcfa.model.traced import column, symbols
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.base_motion import BaseMotion
from ftcfa.vibration.inputs.noise_input import NoiseInput

VANISHING = 1e-18
"""Stands for a period of zero, at which the implicit filter's step is 0/0 [s]."""
WATCHED = ("psi", "s1", "s2", "rho", "theta")
"""Signals that `Generator.along` needs of a watched loop."""


@dataclass(frozen=True, eq=False)
class Watched:
    """A controller whose filter's state is among its signals, as ``psi``.

    Attributes:
        law: The controller.
    """

    law: FTCF

    def init(self, q: Array, v: Array, desired: Desired) -> FTCFState:
        """See `ftcfa.control.protocol.Controller`."""
        return self.law.init(q, v, desired)

    def step(
        self, state: FTCFState, q: Array, v: Array, desired: Desired, period: float
    ) -> tuple[Signals, FTCFState]:
        """The law's own; psi is the filter's after the sample: an implicit one's psi1 is abar."""
        signals, new = self.law.step(state, q, v, desired, period)
        return {**signals, "psi": np.concatenate(leaves(new.filter))}, new


def watched(loop: ClosedLoop) -> ClosedLoop:
    """The same loop with its filter's state recorded, for `Generator.along`."""
    return replace(loop, controller=Watched(paper_law(loop)))


def paper_law(loop: ClosedLoop) -> FTCF:
    """The controller of a loop to which Theorem 1 applies.

    Raises:
        ParameterError: If it is another than the paper's, or a part of it is switched off.
    """
    law = loop.controller
    if not isinstance(law, FTCF):
        expected = "an FTCF, of which Theorem 1 speaks"
        raise ParameterError("controller", f"a {type(law).__name__}", expected)
    for part in ("error_compensation", "anti_saturation", "adaptation"):
        if not getattr(law, part):
            raise ParameterError(f"controller {part}", "off", "on, as in Theorem 1")
    return law


def check_white(loop: ClosedLoop) -> None:
    """Raise ParameterError unless a loop is shaken by white noise (Assumption 1) or not at all."""
    shaken = loop.vibration
    if shaken is None:
        return
    if not isinstance(shaken.excitation, WhiteNoise) or isinstance(shaken.input, BaseMotion):
        raise ParameterError(
            "vibration",
            f"{type(shaken.excitation).__name__} through {type(shaken.input).__name__}",
            "WhiteNoise through an input that depends on q alone, as in Theorem 1",
        )


class Along(NamedTuple):
    """Theorem 1's quantities at some states, arrays of one shape."""

    V: Array
    """The Lyapunov function."""
    LV: Array
    """Its generator [1/s]."""
    demand: Array
    """phihat = v2^T (phi - L abar) + 3/2 tr(phi~^T phi~), what the network stands for; the paper's
    3/2 m sqrt(m) |phi~^T phi~| of (22) to (24) is no less than this trace."""
    basis: Array
    """B^T B."""

    @property
    def needed_theta(self) -> Array:
        """The least theta with which |H||B| covers the demand where eps = 0.

        In (25) the network enters only through H^T B <= |H||B|, so the proof needs no more of
        theta and eps than phihat <= sqrt(theta B^T B) + eps at every state that is visited.
        """
        return np.maximum(self.demand, 0.0) ** 2 / self.basis


@dataclass(frozen=True, eq=False)
class Generator:
    """V and L V of one loop as compiled expressions; made by `generator`.

    Attributes:
        function: (states, desired, theta, weight) -> V, LV, phihat, B^T B; a state a column.
    """

    function: ca.Function

    def at(
        self,
        states: npt.ArrayLike,
        desired: npt.ArrayLike,
        theta: float = 0.0,
        weight: float = 1.0,
    ) -> Along:
        """At given states.

        Args:
            states: q, v, psi1, psi2 (or what else the filter has), s1, s2, rho and thetahat,
                shape (..., 7 n + 1).
            desired: q_d, q_d' and q_d'', shape (..., 3 n).
            theta: Bound of the squared norm of the network's weights.
            weight: w_s.
        """
        x, d = np.asarray(states, dtype=float), np.asarray(desired, dtype=float)
        rows = (x.reshape(-1, x.shape[-1]).T, d.reshape(-1, d.shape[-1]).T)
        found = self.function(*(np.ascontiguousarray(row) for row in rows), theta, weight)
        return Along(*(np.asarray(values).reshape(x.shape[:-1]) for values in found))

    def along(
        self, loop: ClosedLoop, paths: xr.Dataset, theta: float = 0.0, weight: float = 1.0
    ) -> Along:
        """Along simulated paths of a watched loop, shape (paths, times).

        Args:
            loop: The loop, for its reference.
            paths: Of `simulate_paths(watched(loop), ..., signals=WATCHED)`.
            theta: As of `at`.
            weight: As of `at`.
        """
        names = ("q", "v", "psi", "s1", "s2", "rho")
        states = [paths[name].values for name in names] + [paths["theta"].values[..., None]]
        desired = np.concatenate(loop.reference.at(paths["time"].values), axis=-1)
        x = np.concatenate(states, axis=-1)
        rows = np.broadcast_to(desired, (len(x), *desired.shape))
        return self.at(x, rows, theta, weight)


def generator(loop: ClosedLoop) -> Generator:
    """The generator of a loop's continuous limit.

    Args:
        loop: A loop with the paper's controller, shaken by white noise or not at all.

    Raises:
        ParameterError: If the controller is another, or the noise is not white.
    """
    check_white(loop)
    n, traced = loop.arm.n, twin(loop)
    law, arm = paper_law(traced), traced.arm
    g = law.gains
    q, v = symbols("q", n), symbols("v", n)
    desired = Desired(*(symbols(name, n) for name in Desired._fields))
    theta, weight = ca.SX.sym("theta"), ca.SX.sym("weight")

    still = np.zeros(n)
    template = law.init(still, still, Desired(still, still, still))
    state = like(template, iter([symbols("x", len(leaf)) for leaf in leaves(template)]))
    psi1, s1, s2, rho = state.filter[0], state.s1, state.s2, state.rho
    estimate = column(state.theta)
    signals, rates = _limit(law, state, q, v, desired)
    u = np.clip(signals["u"], -arm.effort_limit, arm.effort_limit)
    acceleration = solve_spd(arm.mass_matrix(q), u - arm.bias_force(q, v))
    noise = _noise(traced, q)  # (n, m)

    v1, v2 = column(q - desired.q - s1), column(v - psi1 - s2 - rho)
    parts = (v1, v2, column(s1), column(s2))
    fourth = [ca.dot(part, part) ** 2 / 4 for part in parts]
    missing = (theta - estimate) ** 2 / (2 * g.lambda_)
    V = fourth[0] + fourth[1] + missing + weight * (fourth[2] + fourth[3])

    x = ca.vertcat(column(q), column(v), *(column(leaf) for leaf in leaves(state)))
    f = ca.vertcat(column(v), column(acceleration), rates)
    moving = ca.jtimes(V, column(desired.q), column(desired.v))  # dV/dt: the reference moves
    V_vv = ca.hessian(V, column(v))[0]
    LV = ca.jtimes(V, x, f) + moving + ca.trace(noise.T @ V_vv @ noise) / 2

    B = law.network.basis(q, v)
    BB = column(B @ B)
    gap = column(solve_spd(law.nominal.mass_matrix(q), u - _eta(law, signals["u"])))
    damped = (
        g.c2 * column(sig(v - psi1 - s2 - rho, g.kappa) - sig(s2, g.kappa))
        + (0.75 * g.k2 + 1.25) * v2
        + estimate * v2 * BB / (4 * g.tau)
        - g.k2 * column(s2)
    )
    unknown = ca.jtimes(v2, x, f) + damped - gap  # phi - L abar
    demand = ca.dot(v2, unknown) + 1.5 * ca.sumsqr(noise)
    outputs = [V, LV, demand, BB]
    told = ca.vertcat(*(column(part) for part in desired))
    return Generator(ca.Function("generator", [x, told, theta, weight], outputs, {"cse": True}))


def _limit(
    law: FTCF, state: FTCFState, q: Array, v: Array, desired: Desired
) -> tuple[Signals, ca.SX]:
    """Signals and rates of a law at a vanishing period, from its own step.

    x' = d step(x, h)/dh   at h = 0
    """
    h = symbols("h", 1)
    signals, new = law.step(state, q, v, desired, cast(float, h))
    after = ca.vertcat(*(column(leaf) for leaf in leaves(new)))
    rates = ca.jacobian(after, column(h))
    u, rates = ca.substitute([column(signals["u"]), rates], [column(h)], [ca.SX(VANISHING)])
    return {"u": ca.ArrayInterface(u.T, ndim=1)}, rates


def _eta(law: FTCF, u: Array) -> Array:
    """eta(u) = u* tanh(u/u*), with the limits that the controller believes in."""
    limit = law.nominal.effort_limit
    return limit * np.tanh(u / limit)


def _noise(loop: ClosedLoop, q: Array) -> ca.SX:
    """phi~ varpi^(1/2) = M^-1 Lambda Sigma, shape (n, m)."""
    vibration = loop.vibration
    if vibration is None:
        return ca.SX(loop.arm.n, 1)
    Lambda = cast(NoiseInput, vibration.input).matrix(loop.arm, q)
    noise = cast(WhiteNoise, vibration.excitation)
    Sigma = vibration.level * noise.amplitude(Lambda.shape[1])
    M = loop.arm.mass_matrix(q)
    columns = [solve_spd(M, (Lambda @ Sigma)[:, k]) for k in range(len(Sigma))]
    return ca.horzcat(*(column(each) for each in columns))
