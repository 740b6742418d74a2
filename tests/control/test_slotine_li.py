"""The regressor against Pinocchio's matrices, the law against its Lyapunov function."""

import casadi as ca
import numpy as np
import pytest

from ftcfa import SlotineLi, load_arm
from ftcfa.control.protocol import Desired, Measured
from ftcfa.model.twins import traced
from ftcfa.model.urdf.catalogue import catalogue

ROUNDING = 1e-11
"""Rounding of sums of some hundred products, relative to the largest."""
DIFFERENCE = 1e-6
"""Relative error of a central difference."""
GANTRY = """<robot name="gantry"><link name="rail"/>
<link name="trolley"><inertial><origin xyz="0 0.1 0"/><mass value="5"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="rod"><inertial><origin xyz="0.02 0 -0.4"/><mass value="1.5"/>
  <inertia ixx="0.08" ixy="0.001" ixz="0" iyy="0.09" iyz="0" izz="0.03"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="trolley"/>
  <axis xyz="1 0.2 0"/><limit lower="-3" upper="3" effort="80" velocity="2"/></joint>
<joint name="swing" type="revolute"><parent link="trolley"/><child link="rod"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="40" velocity="4"/></joint>
</robot>"""


def gantry(folder):
    file = folder / "gantry.urdf"
    file.write_text(GANTRY)
    return load_arm(str(file))


ARMS = {
    "double_pendulum, mimic": lambda _: load_arm("double_pendulum"),
    "panda, fingers locked": lambda _: load_arm("panda"),
    "panda's gripper, mimic": lambda _: load_arm(str(catalogue()["panda"].path())),
    "kinova, a joint locked": lambda _: load_arm("kinova", lock={"j2s6s200_joint_3": 1.0}),
    "baxter, branched": lambda _: load_arm("baxter"),
    "gantry, prismatic": gantry,
}


@pytest.fixture(scope="module", params=ARMS)
def arm(request, tmp_path_factory):
    return ARMS[request.param](tmp_path_factory.mktemp("arm"))


def test_the_regressor_gives_the_torque_of_any_inertial_parameters(arm):
    rng = np.random.default_rng(1)
    for _ in range(3):
        q, v, v_r, a_r = rng.normal(size=(4, arm.n))
        other = arm.perturbed(rng, mass=0.3)
        torque = (
            other.mass_matrix(q) @ a_r
            + other.coriolis_matrix(q, v) @ v_r
            + other.potential_force(q)
        )
        Y = arm.regressor(q, v, v_r, a_r)
        assert Y.shape == (arm.n, 10 * len(arm.g0))
        product = Y @ other.inertias.ravel()
        np.testing.assert_allclose(product, torque, rtol=0, atol=ROUNDING * np.max(np.abs(torque)))


def test_the_traced_regressor_is_the_same(arm):
    state = np.random.default_rng(2).normal(size=(4, arm.n))
    Y = arm.regressor(*state)
    traced_Y = np.asarray(ca.DM(traced(arm).regressor(*state).to_casadi()))
    np.testing.assert_allclose(traced_Y, Y, rtol=0, atol=ROUNDING * np.max(np.abs(Y)))


def test_a_body_weighs_by_its_mass_and_radius_of_gyration(tmp_path):
    """The trolley: m = 5 at 0.1 m, tr I = 0.3 + 2 m 0.01 about the joint."""
    W = gantry(tmp_path).inertial_weights.reshape(2, 10)
    r2 = (0.3 + 2.0 * 5.0 * 0.01) / 2.0 / 5.0
    np.testing.assert_allclose(W[0], 5.0 * np.array([1.0] + [r2] * 3 + [r2**2] * 6))
    np.testing.assert_array_equal(load_arm("double_pendulum").inertial_weights >= 0, True)


def test_the_lyapunov_function_falls_as_slotine_and_li_say():
    """V' = -a2 s^T M s on another robot than the nominal, M' by central differences."""
    nominal = load_arm("ur5")
    true = nominal.perturbed(np.random.default_rng(5), mass=0.3)
    law = SlotineLi(nominal, leakage=1e-12)
    rng, h = np.random.default_rng(6), 1e-6
    weights = nominal.inertial_weights
    felt = weights > 0
    gamma = law.adaptation_rate * law.velocity_rate / 9.81**2
    deviation = rng.normal(size=weights.size) * weights
    q, v, q_d, dq_d, ddq_d = 0.05 * rng.normal(size=(5, nominal.n))
    desired = Desired(q_d, dq_d, ddq_d)
    state = law.init(Measured(q, v), desired)._replace(deviation=deviation)
    signals, after = law.step(state, Measured(q, v), desired, h)
    s = signals["s"]
    wanted_rate = ddq_d - 9.75 * (v - dq_d)
    ds = true.forward_dynamics(q, v, signals["u"]) - wanted_rate
    dM = (true.mass_matrix(q + h * v) - true.mass_matrix(q - h * v)) / (2 * h)
    missing = deviation - (true.inertias - nominal.inertias).ravel()
    learning = (after.deviation - deviation) / h
    parameters = np.sum(missing[felt] * learning[felt] / weights[felt]) / gamma
    motion = s @ true.mass_matrix(q) @ ds + s @ dM @ s / 2.0
    expected = -26.5 * s @ nominal.mass_matrix(q) @ s
    assert abs(parameters) > 0.01 * abs(expected)  # the adaptation is at work
    assert motion + parameters == pytest.approx(expected, rel=DIFFERENCE)


def test_a_wrong_weight_is_learnt():
    """Held still with 20 % more mass than in the nominal arm, the arm rises back to its posture."""
    nominal = load_arm("ur5")
    rows = nominal.inertias.copy()
    rows[1:4] *= 1.2
    true, errors = nominal.with_inertias(rows), {}
    still = Desired(nominal.home, np.zeros(nominal.n), np.zeros(nominal.n))
    for rate in (1e-9, 0.975):
        law = SlotineLi(nominal, adaptation_rate=rate, leakage=1e-9)
        q, v, h = nominal.home, np.zeros(nominal.n), 4e-3
        state = law.init(Measured(q, v), still)
        for _ in range(2500):
            signals, state = law.step(state, Measured(q, v), still, h)
            v = v + h * true.forward_dynamics(q, v, signals["u"])
            q = q + h * v
        errors[rate] = np.max(np.abs(q - still.q))
    assert errors[1e-9] > 5e-3
    assert errors[0.975] < 0.02 * errors[1e-9]
