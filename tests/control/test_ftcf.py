"""The paper's controller against the equations written out by hand, and against its ODEs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.integrate import solve_ivp

from ftcfa import (
    FTCF,
    ClosedLoop,
    Constant,
    ExplicitFilter,
    Gains,
    PaperPendulum,
    ParameterError,
    RBFNetwork,
    UnknownNameError,
    load_arm,
    printed,
)
from ftcfa.control.protocol import Desired, Measured
from ftcfa.loop.state import DIVERGED, LoopState, Motion

ROUNDING = 1e-12
"""Relative to the largest number of the step: some hundred operations on well-scaled numbers."""
HIGHER_ORDER = 0.1
"""What terms of second order may change in a ratio that is 2 to first order."""
PERIOD = 1e-3
M1, M2, L1, L2, G = 0.6, 0.8, 0.8, 1.2, 9.8
LIMIT = 15.0


def sig(x, a):
    return math.copysign(abs(x) ** a, x) if x != 0 else 0.0


def inertia(q):
    coupling = M2 * L1 * L2 * math.cos(q[1] - q[0])
    return [[(M1 + M2) * L1**2, coupling], [coupling, M2 * L2**2]]


def solve_two(M, b):
    """Cramer's rule."""
    determinant = M[0][0] * M[1][1] - M[0][1] * M[1][0]
    return [
        (b[0] * M[1][1] - M[0][1] * b[1]) / determinant,
        (M[0][0] * b[1] - b[0] * M[1][0]) / determinant,
    ]


def centrifugal_and_gravity(q, v):
    s = M2 * L1 * L2 * math.sin(q[1] - q[0])
    C_v = [-s * v[1] * v[1], s * v[0] * v[0]]
    h = [(M1 + M2) * G * L1 * math.sin(q[0]), M2 * G * L2 * math.sin(q[1])]
    return C_v, h


class HandWritten:
    """EQUATIONS section 3 for two joints, number by number, with the implicit filter.

    Each of s1, s2, rho and theta takes one Euler step a period, its linear decay implicit, from
    the values at the sample; alpha, the filter and u come before them.
    """

    def __init__(self, g, q, desired, compensation="none"):
        self.g, self.compensation = g, compensation
        self.s1, self.s2, self.rho, self.theta = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], 0.0
        self.psi1 = self.alpha(q, desired)
        self.psi2 = [0.0, 0.0]

    def alpha(self, q, desired):
        g = self.g
        v1 = [q[i] - desired.q[i] - self.s1[i] for i in range(2)]
        return [
            -g.c1 * sig(v1[i], g.kappa) - 3 / 4 * (1 + g.k1) * v1[i] + desired.v[i] - self.rho[i]
            for i in range(2)
        ]

    def filtered(self, alpha, h):
        r1, r2 = 750.0, 180.0
        for i in range(2):
            b = self.psi1[i] - alpha[i] + h * self.psi2[i]
            if abs(b) <= h * h * r2:
                self.psi1[i], self.psi2[i] = alpha[i], self.psi2[i] - b / h
            else:
                s = math.copysign(1.0, b)
                y = (-h * r1 + math.sqrt(h * h * r1 * r1 + 4 * (abs(b) - h * h * r2))) / 2
                self.psi1[i], self.psi2[i] = alpha[i] + s * y * y, self.psi2[i] - h * r2 * s
        return list(self.psi1)

    def step(self, q, v, desired, h):
        g = self.g
        alpha = self.alpha(q, desired)
        abar = self.filtered(alpha, h)
        v2 = [v[i] - abar[i] - self.s2[i] - self.rho[i] for i in range(2)]
        BB = 0.0
        for k in range(10):
            gamma = -2.0 + 4.0 * k / 9.0
            squares = sum((x - gamma) ** 2 for x in [*q, *v])
            BB += math.exp(-squares / 16.0) ** 2
        a = [
            -g.c2 * sig(v2[i], g.kappa)
            - (3 / 4 * g.k2 + 5 / 4) * v2[i]
            - self.theta * v2[i] * BB / (4 * g.tau)
            - self.rho[i]
            for i in range(2)
        ]
        M = inertia(q)
        u = [M[i][0] * a[0] + M[i][1] * a[1] for i in range(2)]
        C_v, h_q = centrifugal_and_gravity(q, v)
        for i in range(2):
            u[i] += h_q[i] if self.compensation in ("gravity", "bias") else 0.0
            u[i] += C_v[i] if self.compensation == "bias" else 0.0
        gap = solve_two(M, [LIMIT * math.tanh(u[i] / LIMIT) - u[i] for i in range(2)])
        signals = {
            "u": u,
            "alpha": alpha,
            "abar": abar,
            "s1": list(self.s1),
            "s2": list(self.s2),
            "rho": list(self.rho),
            "theta": self.theta,
            "v2": v2,
        }
        norm4 = (v2[0] ** 2 + v2[1] ** 2) ** 2
        self.theta = (self.theta + h * g.lambda_ / (4 * g.tau) * norm4 * BB) / (1 + h * g.iota)
        for i in range(2):
            drive1 = -g.c1 * sig(self.s1[i], g.kappa) + abar[i] - alpha[i] + self.s2[i]
            drive2 = -g.c2 * sig(self.s2[i], g.kappa)
            self.s1[i] = (self.s1[i] + h * drive1) / (1 + h * g.k1)
            self.s2[i] = (self.s2[i] + h * drive2) / (1 + h * g.k2)
            self.rho[i] = (self.rho[i] + h * gap[i]) / (1 + h)
        return signals


def measurements(seed, count=8):
    """Jumping measurements and desired motions: every term of the law is at work."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q, v, q_d, dq_d, ddq_d = rng.normal(size=(5, 2)) * [[0.5], [1], [0.5], [1], [1]]
        yield q, v, Desired(q_d, dq_d, ddq_d)


@pytest.mark.parametrize("period", [1e-4, 1e-3])
@pytest.mark.parametrize(
    ("gains", "compensation"),
    [
        (Gains(), "none"),
        (Gains(), "gravity"),
        (Gains(), "bias"),
        (Gains(kappa=1.0), "none"),
        (Gains(3.0, 8.0, 1.0, 0.7, 0.8, iota=20.0, lambda_=0.5, tau=0.7), "bias"),
    ],
)
def test_the_law_is_section_3_number_by_number(gains, compensation, period):
    law = printed(FTCF(PaperPendulum(), gains, compensation=compensation))
    state = by_hand = None
    for q, v, desired in measurements(seed=3):
        if state is None:
            state = law.init(Measured(q, v), desired)
            by_hand = HandWritten(gains, q, desired, compensation)
        signals, state = law.step(state, Measured(q, v), desired, period)
        expected = by_hand.step(q.tolist(), v.tolist(), desired, period)
        for name, value in expected.items():
            scale = 1.0 + np.max(np.abs(value))
            np.testing.assert_allclose(signals[name], value, rtol=0, atol=ROUNDING * scale)
    assert np.max(np.abs(state.s1)) > 1e-3  # all states were at work
    assert np.max(np.abs(state.rho)) > 1e-3
    assert state.theta[0] > 1e-3


def test_the_errors_among_the_signals_are_their_definitions():
    law, state = FTCF(PaperPendulum()), None
    for q, v, desired in measurements(seed=4):
        state = law.init(Measured(q, v), desired) if state is None else state
        signals, state = law.step(state, Measured(q, v), desired, PERIOD)
        s = signals
        np.testing.assert_array_equal(s["z1"], q - desired.q)
        np.testing.assert_array_equal(s["z2"], v - s["abar"])
        np.testing.assert_array_equal(s["v1"], s["z1"] - s["s1"])
        np.testing.assert_array_equal(s["v2"], s["z2"] - s["s2"] - s["rho"])


def test_s2_stays_zero_whatever_happens():
    law, state = FTCF(PaperPendulum()), None
    for q, v, desired in measurements(seed=5, count=50):
        state = law.init(Measured(q, v), desired) if state is None else state
        _, state = law.step(state, Measured(10 * q, 10 * v), desired, PERIOD)
        np.testing.assert_array_equal(state.s2, 0.0)


def test_kappa_one_is_linear_in_the_errors():
    """u = -M (c2 + 3/4 k2 + 5/4) (v - q_d' + (c1 + 3/4 (1 + k1)) z1) while all states are zero."""
    g = Gains(kappa=1.0)
    law = FTCF(PaperPendulum(), g)
    for q, v, desired in measurements(seed=6):
        signals, _ = law.step(law.init(Measured(q, v), desired), Measured(q, v), desired, PERIOD)
        z2 = v - desired.v + (7.5 + 0.75 * 3.0) * (q - desired.q)
        expected = -np.array(inertia(q)) @ ((25.0 + 0.25 + 1.25) * z2)
        scale = np.max(np.abs(expected))
        np.testing.assert_allclose(signals["u"], expected, rtol=0, atol=ROUNDING * scale)


STILL_Q, STILL_V = np.array([0.3, -0.2]), np.array([0.1, 0.2])
STILL_DESIRED = Desired(np.array([0.25, -0.1]), np.array([0.3, -0.1]), np.zeros(2))


def sampled_states(period, duration):
    """psi1, rho and theta of the law after a while of one and the same measurement."""
    law = printed(FTCF(PaperPendulum()))
    state = law.init(Measured(STILL_Q, STILL_V), STILL_DESIRED)
    for _ in range(round(duration / period)):
        _, state = law.step(state, Measured(STILL_Q, STILL_V), STILL_DESIRED, period)
    return np.concatenate([state.filter.psi1, state.rho, state.theta])


def continuous_states(duration):
    """The same from (6) to (12) as differential equations."""
    g, q, v, desired = Gains(), STILL_Q, STILL_V, STILL_DESIRED
    M = np.array(inertia(q))
    BB = sum(
        math.exp(-sum((x - c) ** 2 for x in [*q, *v]) / 16) ** 2 for c in np.linspace(-2, 2, 10)
    )

    def power(x, a):
        return np.sign(x) * np.abs(x) ** a

    def alpha_of(s1, rho):
        v1 = q - desired.q - s1
        return -g.c1 * power(v1, g.kappa) - 0.75 * (1 + g.k1) * v1 + desired.v - rho

    def ode(_, x):
        psi1, psi2, s1, rho, theta = x[:2], x[2:4], x[4:6], x[6:8], x[8]
        alpha = alpha_of(s1, rho)
        v2 = v - psi1 - rho
        a = -g.c2 * power(v2, g.kappa) - (0.75 * g.k2 + 1.25) * v2 - rho
        u = M @ (a - theta * v2 * BB / (4 * g.tau))
        return [
            *(-750.0 * power(psi1 - alpha, 0.5) + psi2),
            *(-180.0 * np.sign(psi1 - alpha)),
            *(-g.k1 * s1 - g.c1 * power(s1, g.kappa) + psi1 - alpha),
            *(-rho + np.linalg.solve(M, LIMIT * np.tanh(u / LIMIT) - u)),
            -g.iota * theta + g.lambda_ / (4 * g.tau) * (v2 @ v2) ** 2 * BB,
        ]

    start = np.concatenate([alpha_of(np.zeros(2), np.zeros(2)), np.zeros(7)])
    solution = solve_ivp(ode, (0.0, duration), start, method="Radau", rtol=1e-9, atol=1e-12)
    return np.delete(solution.y[:, -1], slice(2, 6))


def test_small_periods_approach_the_differential_equations():
    """Against an implicit high-order solution, the error halves with the period."""
    duration = 0.04
    exact = continuous_states(duration)
    assert np.min(np.abs(exact)) > 0.1
    coarse, fine = (np.abs(sampled_states(h, duration) - exact) for h in (1e-4, 5e-5))
    assert np.all(fine < 1e-3 * np.abs(exact))
    assert coarse / fine == pytest.approx(2.0, rel=HIGHER_ORDER)


def torque(arm, compensation, q, v, desired):
    law = FTCF(arm, compensation=compensation)
    return law.step(law.init(Measured(q, v), desired), Measured(q, v), desired, PERIOD)[0]


def test_compensation_adds_the_nominal_forces():
    """Friction is that of v - v2, the velocity that the law steers to."""
    arm = load_arm("xarm7")  # damping of 2 to 10 N m s/rad and friction of 1 N m
    rng = np.random.default_rng(1)
    q, v, q_d, dq_d = rng.normal(size=(4, 7))
    desired = Desired(q_d, dq_d, np.zeros(7))
    none, gravity, bias = (torque(arm, c, q, v, desired) for c in ("none", "gravity", "bias"))
    h, C_v = arm.potential_force(q), arm.coriolis_matrix(q, v) @ v
    scale = np.max(np.abs(none["u"]))
    np.testing.assert_allclose(gravity["u"] - none["u"], h, rtol=0, atol=ROUNDING * scale)
    friction = arm.friction_force(v - none["v2"])
    assert np.all(np.abs(friction) > 0.1)
    np.testing.assert_allclose(
        bias["u"] - none["u"], C_v + h + friction, rtol=0, atol=ROUNDING * scale
    )


def test_the_filter_is_a_choice():
    q, v, desired = next(measurements(seed=7))
    law = FTCF(PaperPendulum(), filter=ExplicitFilter(10.0, 20.0))
    state = law.init(Measured(q, v), desired)
    signals, state = law.step(state, Measured(q, v), desired, PERIOD)
    np.testing.assert_array_equal(signals["abar"], signals["alpha"])  # psi1(0) = alpha(0)
    moved = Desired(desired.q + 1.0, desired.v, desired.a)
    signals, _ = law.step(state, Measured(q, v), moved, PERIOD)
    assert np.all(np.abs(signals["abar"] - signals["alpha"]) > 1.0)  # too slow to follow a jump
    assert FTCF(PaperPendulum(), filter="explicit").filter == ExplicitFilter()


def test_a_silent_network_leaves_the_adaptation_out():
    q, v, desired = next(measurements(seed=8))
    law = FTCF(PaperPendulum(), network=RBFNetwork(width=1e-3))
    state = law.init(Measured(q, v), desired)
    for _ in range(3):
        _, state = law.step(state, Measured(q, v), desired, PERIOD)
    assert state.theta[0] == 0.0


@pytest.mark.parametrize("name", ["c1", "c2", "k1", "k2", "kappa", "iota", "lambda_", "tau"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "2", None, True])
def test_bad_gains_are_refused(name, value):
    expected = "0 < kappa <= 1" if name == "kappa" else "a number > 0"
    with pytest.raises(ParameterError, match=rf"Gains {name}: .*, expected {expected}") as caught:
        Gains(**{name: value})
    assert caught.value.field == name


def test_kappa_above_one_is_refused():
    with pytest.raises(ParameterError, match=r"Gains kappa: 1\.1, expected 0 < kappa <= 1"):
        Gains(kappa=1.1)


def test_gains_may_be_any_kind_of_number():
    assert Gains(c1=np.int64(7), c2=np.float32(25.0), k1=2).c1 == 7


def test_unknown_choices_list_the_known_ones():
    with pytest.raises(UnknownNameError, match=r"compensation 'all'.*one of: none, gravity, bias"):
        FTCF(PaperPendulum(), compensation="all")
    with pytest.raises(
        UnknownNameError, match=r"filter 'slow'.*one of: implicit, explicit, second-order, proper"
    ):
        FTCF(PaperPendulum(), filter="slow")


def loop_of(robot, compensation):
    arm = PaperPendulum() if robot == "closed form" else load_arm(robot)
    return ClosedLoop(arm, FTCF(arm, compensation=compensation), Constant([0.3, -0.2]))


@pytest.fixture(scope="module", params=["closed form", "double_pendulum"])
def loop(request):
    return loop_of(request.param, "bias")


STILL = Desired(np.array([0.3, -0.2]), np.zeros(2), np.zeros(2))


def measured(loop, q, v):
    """Two samples of the law: its states take part in the second."""
    state = loop.init(STILL)
    for _ in range(2):
        state = LoopState(Motion(q, v), state.controller)
        signals, state = loop.step(state, STILL, np.zeros((1, 0)))
    return signals


within = arrays(float, 2, elements=st.floats(-DIVERGED, DIVERGED))
anything = arrays(float, 2, elements=st.floats(allow_nan=True, allow_infinity=True))


@given(q=within, v=within)
def test_the_torque_that_acts_is_within_the_limits_for_any_live_state(loop, q, v):
    signals = measured(loop, q, v)
    assert np.all(np.abs(signals["u"]) <= 15.0)
    assert np.all(np.isfinite(signals["u_command"]))


@given(q=anything, v=anything)
def test_no_measurement_raises_or_passes_the_limits(loop, q, v):
    with np.errstate(all="ignore"):
        u = measured(loop, q, v)["u"]
    assert np.all((np.abs(u) <= 15.0) | np.isnan(u))
