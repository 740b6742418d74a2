"""The rivals against the error dynamics that each promises, seen through Pinocchio."""

from itertools import pairwise

import numpy as np
import pytest

from ftcfa import (
    ABLATIONS,
    CONTROLLERS,
    FTCF,
    CommandFilteredBackstepping,
    ComputedTorque,
    FiniteTimeBackstepping,
    Gains,
    PaperPendulum,
    ParameterError,
    PDGravity,
    RBFNetwork,
    SecondOrderFilter,
    SlotineLi,
    StochasticBackstepping,
    SuperTwisting,
    UnknownNameError,
    ablated,
    load_arm,
)
from ftcfa.control.finite_time_backstepping import joined_power
from ftcfa.control.protocol import Desired, Measured

from .arms import Mass

ROUNDING = 1e-9
"""Relative: two solves with an inertia matrix of condition 1e3 or so."""
DIFFERENCE = 1e-6
"""Relative error of a central difference with a step of 1e-6."""
PERIOD = 1e-3
A1, A2 = 9.75, 26.5
"""c1 + 3/4 (1 + k1) and c2 + 3/4 k2 + 5/4 at the gains of Section V [1/s]."""


@pytest.fixture(scope="module")
def arm():
    return load_arm("ur5")  # without friction, which the laws take elsewhere than the plant


def sample(n, seed=0, scale=0.3):
    q, v, q_d, dq_d, ddq_d = scale * np.random.default_rng(seed).normal(size=(5, n))
    return q, v, Desired(q_d, dq_d, ddq_d)


def acceleration(law, arm, q, v, desired):
    """Acceleration of the arm under the torque of a law's first sample."""
    signals, _ = law.step(law.init(Measured(q, v), desired), Measured(q, v), desired, PERIOD)
    return arm.forward_dynamics(q, v, signals["u"])


def test_gains_know_the_rates_of_the_asymptotic_law():
    assert (Gains().position_rate, Gains().velocity_rate) == (A1, A2)


@pytest.mark.parametrize("law", [ComputedTorque, StochasticBackstepping])
def test_the_error_has_the_poles_of_the_rule(arm, law):
    q, v, desired = sample(arm.n)
    e, de = q - desired.q, v - desired.v
    expected = desired.a - (A1 + A2) * de - A1 * A2 * e
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(
        acceleration(law(arm), arm, q, v, desired), expected, rtol=0, atol=ROUNDING * scale
    )


def test_with_a_fast_filter_and_no_network_the_filtered_law_has_them_too(arm):
    """A filter that follows within a step: abar = alpha, abar' = (alpha - alpha_old)/h."""
    law = CommandFilteredBackstepping(
        arm, filter=SecondOrderFilter(1e9), network=RBFNetwork(width=1e-3)
    )
    q, v, desired = sample(arm.n)
    state = law.init(
        Measured(q - PERIOD * v, v), desired._replace(q=desired.q - PERIOD * desired.v)
    )
    signals, _ = law.step(state, Measured(q, v), desired, PERIOD)
    e, de = q - desired.q, v - desired.v
    expected = -A1 * de - A2 * (de + A1 * e)  # q_d' was the same before: q_d'' plays no part
    rate = arm.forward_dynamics(q, v, signals["u"])
    np.testing.assert_allclose(rate, expected, rtol=0, atol=1e-5 * np.max(np.abs(expected)))


def test_command_filtered_signals_obey_their_equations():
    """Number by number over jumping measurements, the second-order filter's step written out."""
    arm, omega, zeta = PaperPendulum(), 50.0, 0.9
    law = CommandFilteredBackstepping(
        arm, filter=SecondOrderFilter(omega, zeta), compensation="none"
    )
    state = s1 = psi1 = psi2 = None
    theta = 0.0
    for seed in range(6):
        q, v, desired = sample(2, seed, scale=0.8)
        z1 = q - desired.q
        alpha = -A1 * z1 + desired.v
        if state is None:
            state = law.init(Measured(q, v), desired)
            s1, psi1, psi2 = np.zeros(2), alpha, np.zeros(2)
        error = np.stack([psi1 - alpha, psi2])
        A = np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])
        psi1, psi2 = np.linalg.solve(np.eye(2) - PERIOD * A, error) + np.stack([alpha, 0 * alpha])
        z2 = v - psi1
        B = np.exp(-(((np.append(q, v)[:, None] - np.linspace(-2, 2, 10)) ** 2).sum(0)) / 16.0)
        BB = np.sum(B**2)
        u = arm.mass_matrix(q) @ (psi2 - A2 * z2 - theta * z2 * BB / 4.0)
        signals, state = law.step(state, Measured(q, v), desired, PERIOD)
        for name, value in (("u", u), ("abar", psi1), ("v1", z1 - s1), ("theta", theta)):
            np.testing.assert_allclose(signals[name], value, rtol=1e-9, atol=1e-9, err_msg=name)
        s1 = (s1 + PERIOD * (psi1 - alpha)) / (1.0 + PERIOD * A1)
        theta = (theta + PERIOD / 4.0 * np.sum(z2**2) ** 2 * BB) / (1.0 + PERIOD * 100.0)
    assert np.max(np.abs(s1)) > 1e-3
    assert theta > 1e-3


def power(x, a):
    return np.sign(x) * np.abs(x) ** a


@pytest.mark.parametrize("width", [0.0, 0.2])
def test_finite_time_backstepping_differentiates_its_virtual_control(arm, width):
    """alpha' by central differences along the motion."""
    g, law = Gains(), FiniteTimeBackstepping(arm, width=width)
    q, v, desired = sample(arm.n)

    def alpha(t):
        z = q - desired.q + t * (v - desired.v)
        inside = (1.4 * width**-0.4 * z - 0.4 * width**-1.4 * z**2 * np.sign(z)) if width else 0.0
        beta = np.where(np.abs(z) < width, inside, power(z, 0.6))
        return -7.5 * beta - 2.25 * z + desired.v + t * desired.a

    dalpha = (alpha(1e-6) - alpha(-1e-6)) / 2e-6
    z2 = v - alpha(0.0)
    expected = dalpha - 25.0 * power(z2, g.kappa) - 1.5 * z2
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(
        acceleration(law, arm, q, v, desired), expected, rtol=0, atol=DIFFERENCE * scale
    )


def demanded(arm, width, error):
    """Largest torque with one error for all joints, at v - q_d' = 1."""
    law = FiniteTimeBackstepping(arm, width=width)
    q, desired = np.full(arm.n, error), Desired(*np.zeros((3, arm.n)))
    signals, _ = law.step(
        law.init(Measured(q, q), desired), Measured(q, np.ones(arm.n)), desired, PERIOD
    )
    return np.max(np.abs(signals["u"]))


def test_the_torque_of_finite_time_backstepping_grows_with_the_power_kappa_minus_one(arm):
    torques = [demanded(arm, 0.0, error) for error in (1e-12, 1e-15, 1e-18)]
    for small, large in pairwise(torques):
        assert large / small == pytest.approx(1e-3**-0.4, rel=1e-3)
    assert np.isfinite(demanded(arm, 0.0, 0.0))


def test_regularised_its_torque_stays_bounded(arm):
    """The slope is at most (2 - kappa) mu^(kappa - 1), and is that at zero."""
    M = arm.mass_matrix(np.zeros(arm.n)) @ np.ones(arm.n)
    jumps = [demanded(arm, 0.01, error) for error in (0.0, 1e-18, 1e-9)]
    np.testing.assert_allclose(jumps, jumps[0], rtol=1e-3)
    steepest = 7.5 * 1.4 * 0.01**-0.4
    assert jumps[0] < (steepest + 2.25 + 25.0 + 1.5) * np.max(np.abs(M)) + 100.0


@pytest.mark.parametrize("kappa", [0.3, 0.6, 1.0])
def test_the_joined_power_is_smooth_and_the_power_outside(kappa):
    mu = 0.05
    z = np.array([-1.0, -mu, -1e-3, 0.0, 1e-3, mu, 0.4])
    beta, slope = joined_power(z, kappa, mu)
    outside = np.abs(z) >= mu
    np.testing.assert_allclose(beta[outside], power(z, kappa)[outside], rtol=ROUNDING)
    e = 1e-7
    ahead, behind = joined_power(z + e, kappa, mu)[0], joined_power(z - e, kappa, mu)[0]
    np.testing.assert_allclose(slope, (ahead - behind) / (2 * e), rtol=1e-5)
    np.testing.assert_allclose(beta, -joined_power(-z, kappa, mu)[0])


def test_pd_with_gravity_is_a_servo_a_joint(arm):
    q, v, desired = sample(arm.n)
    signals, _ = PDGravity(arm).step((), Measured(q, v), desired, PERIOD)
    D = np.diag(arm.mass_matrix(arm.home))
    expected = arm.potential_force(q) - D * (
        A1 * A2 * (q - desired.q) + (A1 + A2) * (v - desired.v)
    )
    np.testing.assert_allclose(signals["u"], expected, rtol=ROUNDING)


def sliding(law, arm, seed=3, steps=4000):
    """Sliding variable of a law on its own nominal arm, the velocity moved by Euler steps."""
    q, v, desired = sample(arm.n, seed)
    state, s = law.init(Measured(q, v), desired), []
    for _ in range(steps):
        signals, state = law.step(state, Measured(q, v), desired, PERIOD)
        s.append(signals["s"])
        rate = arm.forward_dynamics(q, v, signals["u"])
        moved = Desired(desired.q + PERIOD * desired.v, desired.v + PERIOD * desired.a, desired.a)
        q, v, desired = q + PERIOD * v, v + PERIOD * rate, moved
    return np.array(s)


class Pendulum(PaperPendulum):
    """With forward dynamics, as an Arm has."""

    def forward_dynamics(self, q, v, u):
        return np.linalg.solve(self.mass_matrix(q), u - self.bias_force(q, v))


def test_super_twisting_reaches_its_surface_in_finite_time_and_does_not_chatter():
    """Without disturbance s is zero to rounding from then on; an explicit law would cycle."""
    arm = Pendulum()
    s = sliding(SuperTwisting(arm), arm)
    assert np.max(np.abs(s[0])) > 0.5
    assert np.max(np.abs(s[2000:])) < 1e-12


def test_super_twisting_rejects_a_ramp_of_disturbance():
    """The integral follows: the ramp 5 t leaves s within some h^2 times its slope."""
    law = SuperTwisting(Mass())
    q, v, at_rest = np.zeros(1), np.zeros(1), Desired(np.zeros(1), np.zeros(1), np.zeros(1))
    state = law.init(Measured(q, v), at_rest)
    for k in range(5000):
        signals, state = law.step(state, Measured(q, v), at_rest, PERIOD)
        q, v = q + PERIOD * v, v + PERIOD * (signals["u"] + 5.0 * k * PERIOD)
    assert np.abs(signals["s"]) == pytest.approx(PERIOD**2 * 5.0, rel=1e-3)
    np.testing.assert_allclose(state.nu, -5.0 * 5.0, rtol=1e-3)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_law_refuses_a_nominal_arm_that_is_none(name):
    with pytest.raises(ParameterError, match=r"nominal: a str, expected an Arm"):
        CONTROLLERS[name]("panda")


def test_slotine_li_needs_an_arm_with_a_regressor():
    with pytest.raises(
        ParameterError, match=r"SlotineLi nominal: a PaperPendulum, expected an Arm"
    ):
        SlotineLi(PaperPendulum())


@pytest.mark.parametrize(
    ("law", "name"),
    [
        (ComputedTorque, "position_rate"),
        (ComputedTorque, "velocity_rate"),
        (PDGravity, "position_rate"),
        (SuperTwisting, "r1"),
        (SuperTwisting, "r2"),
        (SlotineLi, "adaptation_rate"),
        (SlotineLi, "leakage"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, "fast", None, True])
def test_bad_rates_are_refused(arm, law, name, value):
    expected = "expected (a number|numbers) > 0"
    with pytest.raises(ParameterError, match=rf"{law.__name__} {name}: .*, {expected}"):
        law(arm, **{name: value})


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "wide", None, True])
def test_bad_widths_are_refused(arm, value):
    with pytest.raises(ParameterError, match=r"width: .*, expected a number >= 0"):
        FiniteTimeBackstepping(arm, width=value)


@pytest.mark.parametrize(
    "law", [CommandFilteredBackstepping, StochasticBackstepping, FiniteTimeBackstepping]
)
def test_backstepping_laws_refuse_wrong_choices(arm, law):
    with pytest.raises(UnknownNameError, match=r"compensation 'all'"):
        law(arm, compensation="all")
    with pytest.raises(ParameterError, match=rf"{law.__name__} gains: 3, expected Gains"):
        law(arm, gains=3)


def states_after(law, count=5):
    state = None
    for seed in range(count):
        q, v, desired = sample(2, seed)
        state = law.init(Measured(q, v), desired) if state is None else state
        _, state = law.step(state, Measured(q, v), desired, PERIOD)
    return state


SWITCHES = {
    "without error compensation": {"s1", "s2"},
    "without the anti-saturation state": {"rho", "s2"},
    "without the network": {"theta", "s2"},
    "with the second-order filter": {"s2"},
    "kappa = 1": {"s2"},
}
"""States that stay zero; s2 always does."""


@pytest.mark.parametrize("name", ABLATIONS)
def test_an_ablation_stills_its_state_and_no_other(name):
    state = states_after(ablated(FTCF(PaperPendulum()), name))
    still = {part for part in ("s1", "s2", "rho", "theta") if not np.any(getattr(state, part))}
    assert still == SWITCHES[name]


def test_all_switched_off_the_law_is_one_line():
    law = FTCF(PaperPendulum(), error_compensation=False, anti_saturation=False, adaptation=False)
    state = None
    for seed in range(5):
        q, v, desired = sample(2, seed)
        state = law.init(Measured(q, v), desired) if state is None else state
        signals, state = law.step(state, Measured(q, v), desired, PERIOD)
        z1 = q - desired.q
        np.testing.assert_allclose(
            signals["alpha"], -7.5 * power(z1, 0.6) - 2.25 * z1 + desired.v, rtol=ROUNDING
        )
        z2 = v - signals["abar"]
        u = PaperPendulum().mass_matrix(q) @ (-25.0 * power(z2, 0.6) - 1.5 * z2)
        np.testing.assert_allclose(signals["u"], u, rtol=ROUNDING)


def test_ablations_change_what_they_say():
    law = FTCF(PaperPendulum(), Gains(c1=3.0))
    assert ablated(law, "kappa = 1").gains == Gains(c1=3.0, kappa=1.0)
    assert ablated(law, "with the second-order filter").filter == SecondOrderFilter()
    with pytest.raises(UnknownNameError, match=r"ablation 'without luck'.*one of: without error"):
        ablated(law, "without luck")


@pytest.mark.parametrize("name", ["error_compensation", "adaptation"])
@pytest.mark.parametrize("value", [0, 1.0, "no", None])
def test_switches_are_true_or_false(name, value):
    with pytest.raises(ParameterError, match=rf"FTCF {name}: .*, expected True or False"):
        FTCF(PaperPendulum(), **{name: value})
