"""The generator L V of Definition 2 on the closed loop, by automatic differentiation.

    V  = |v1|^4/4 + |v2|^4/4 + (theta - thetahat)^2/(2 lambda) + w_s (|s1|^4 + |s2|^4)/4
    LV = V_x f + 1/2 Tr(Phi^T V_xx Phi)

This is Definition 2 with the transpose that the paper leaves out. f is the drift of the continuous
closed loop, which the sampled one approximates: the rates of the controller's states are the
derivatives of its own step with respect to the period, at a period of zero; those of the plant are
(4). Phi is the noise, M^-1 Lambda Sigma in the rows of v and zero elsewhere. Neither q nor abar,
the state of a filter, has noise of its own, so that none reaches v2 through them; (13) as printed
says otherwise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import casadi as ca
import numpy as np
import numpy.typing as npt
import xarray as xr

from ftcfa.arrays import Array, solve_spd
from ftcfa.control.ftcf import FTCF, FTCFState, commanded_acceleration
from ftcfa.control.protocol import Desired, Measured, Quantity, Signals
from ftcfa.engine.compiler.flatten import leaves, like
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.loop.twin import twin
from ftcfa.model.symbols import array, column, symbols
from ftcfa.theory.assumptions import check_white, paper_law
from ftcfa.vibration.excitations.white_noise import WhiteNoise
from ftcfa.vibration.inputs.noise_input import NoiseInput

VANISHING = 1e-18
"""Period that replaces zero, where the implicit filter's step is 0/0 [s]."""
STATE_SIGNALS = ("psi", "s1", "s2", "rho", "theta")
"""Signals that `Generator.along` needs of a loop that `with_filter_state` made."""


@dataclass(frozen=True, eq=False)
class FilterStateRecorder:
    """A controller that gives the state of its filter as one more signal, ``psi``.

    Attributes:
        law: The controller.
    """

    law: FTCF

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Unit and meaning of the signals."""
        psi = Quantity("rad/s, rad/s^2", "state of the command filter (6)")
        return {**self.law.quantities, "psi": psi}

    def init(self, measured: Measured, desired: Desired) -> FTCFState:
        """Initial state of the law: see `ftcfa.control.protocol.Controller`."""
        return self.law.init(measured, desired)

    def step(
        self, state: FTCFState, measured: Measured, desired: Desired, period: float
    ) -> tuple[Signals, FTCFState]:
        """One sample of the law; psi is the filter's state after it, so that psi1 is abar."""
        signals, new = self.law.step(state, measured, desired, period)
        return {**signals, "psi": np.concatenate(leaves(new.filter))}, new


def with_filter_state(loop: ClosedLoop) -> ClosedLoop:
    """The same loop with the state of its filter among its signals, for `Generator.along`."""
    return replace(loop, controller=FilterStateRecorder(paper_law(loop)))


class LyapunovValues(NamedTuple):
    """V, L V and phihat at some states; arrays of one shape."""

    V: Array
    """Lyapunov function."""
    LV: Array
    """Generator of V [1/s]."""
    demand: Array
    """phihat = v2^T (phi - L abar) + 3/2 tr(phi~^T phi~), which the network must approximate (24).
    The paper's 3/2 m sqrt(m) |phi~^T phi~| of (22) to (24) is at least this trace."""
    basis: Array
    """B^T B of the network."""

    @property
    def needed_theta(self) -> Array:
        """Least theta with which |H||B| covers phihat if eps = 0.

        The network enters (25) only through H^T B <= |H||B|, so the proof needs of theta and eps
        only that phihat <= sqrt(theta B^T B) + eps at every state that is visited.
        """
        return np.maximum(self.demand, 0.0) ** 2 / self.basis


@dataclass(frozen=True, eq=False)
class Generator:
    """V and L V of one loop as compiled expressions; `generator` makes it.

    Attributes:
        function: (states, desired, theta, weight) -> V, LV, phihat, B^T B; one state a column.
    """

    function: ca.Function

    def at(
        self, states: npt.ArrayLike, desired: npt.ArrayLike, theta: float = 0.0, weight: float = 1.0
    ) -> LyapunovValues:
        """Values at given states.

        Args:
            states: q, v, psi1, psi2 (or the states of another filter), s1, s2, rho and thetahat,
                shape (..., 7 n + 1).
            desired: q_d, q_d' and q_d'', shape (..., 3 n).
            theta: Bound of the squared norm of the network's weights.
            weight: w_s.
        """
        x, d = np.asarray(states, dtype=float), np.asarray(desired, dtype=float)
        rows = (x.reshape(-1, x.shape[-1]).T, d.reshape(-1, d.shape[-1]).T)
        outputs = self.function(*(np.ascontiguousarray(row) for row in rows), theta, weight)
        return LyapunovValues(*(np.asarray(values).reshape(x.shape[:-1]) for values in outputs))

    def along(
        self, loop: ClosedLoop, paths: xr.Dataset, theta: float = 0.0, weight: float = 1.0
    ) -> LyapunovValues:
        """Values along simulated paths, shape (paths, times).

        Args:
            loop: The loop, for its reference.
            paths: Result of `simulate_paths` for ``with_filter_state(loop)`` with
                ``signals=STATE_SIGNALS``.
            theta: Bound of the squared norm of the network's weights.
            weight: w_s.
        """
        names = ("q", "v", "psi", "s1", "s2", "rho")
        states = [paths[name].values for name in names] + [paths["theta"].values[..., None]]
        desired = np.concatenate(loop.desired(paths["time"].values), axis=-1)
        x = np.concatenate(states, axis=-1)
        rows = np.broadcast_to(desired, (len(x), *desired.shape))
        return self.at(x, rows, theta, weight)


def generator(loop: ClosedLoop) -> Generator:
    """The generator of a loop in the limit of a zero period.

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
    template = law.init(Measured(still, still), Desired(still, still, still))
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
    moving = ca.jtimes(V, column(desired.q), column(desired.v))  # by the moving reference
    V_vv = ca.hessian(V, column(v))[0]
    LV = ca.jtimes(V, x, f) + moving + ca.trace(noise.T @ V_vv @ noise) / 2

    B = law.network.basis(q, v)
    BB = B @ B
    a = commanded_acceleration(g, v - psi1 - s2 - rho, state.theta, BB, rho)
    excess = solve_spd(law.nominal.mass_matrix(q), u - signals["u"])  # Mbar^-1 (sat(u) - u)
    # phi - L abar: by (4) and (8), v' = a + excess + phi and L abar = psi1'
    unknown = ca.jtimes(column(v - psi1), x, f) - column(a + excess)
    demand = ca.dot(v2, unknown) + 1.5 * ca.sumsqr(noise)
    outputs = [V, LV, demand, column(BB)]
    reference = ca.vertcat(*(column(part) for part in desired))
    inputs = [x, reference, theta, weight]
    return Generator(ca.Function("generator", inputs, outputs, {"cse": True}))


def _limit(
    law: FTCF, state: FTCFState, q: Array, v: Array, desired: Desired
) -> tuple[Signals, ca.SX]:
    """Signals of a law and rates of its states at a period of zero, from its own step.

    x' = d step(x, h)/dh   at h = 0
    """
    h = symbols("h", 1)
    signals, new = law.step(state, Measured(q, v), desired, cast(float, h))
    after = ca.vertcat(*(column(leaf) for leaf in leaves(new)))
    rates = ca.jacobian(after, column(h))
    u, rates = ca.substitute([column(signals["u"]), rates], [column(h)], [ca.SX(VANISHING)])
    return {"u": array(u, 1)}, rates


def _noise(loop: ClosedLoop, q: Array) -> ca.SX:
    """Noise input of (4), phi~ Sigma = M^-1 Lambda Sigma, shape (n, m)."""
    vibration = loop.vibration
    if vibration is None:
        return ca.SX(loop.arm.n, 1)
    Lambda = cast(NoiseInput, vibration.input).matrix(loop.arm, q)
    noise = cast(WhiteNoise, vibration.excitation)
    Sigma = vibration.level * noise.amplitude(Lambda.shape[1])
    M = loop.arm.mass_matrix(q)
    columns = [solve_spd(M, (Lambda @ Sigma)[:, k]) for k in range(len(Sigma))]
    return ca.horzcat(*(column(each) for each in columns))
