"""Rotor inertia: from an argument or a transmission, in numbers and in code, beside MuJoCo."""

import mujoco
import numpy as np
import pytest

from ftcfa import FTCF, ClosedLoop, ShapeError, Sinusoid, Uncertainty, load_arm, simulate_paths
from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.model.twins import traced
from ftcfa.model.urdf.load import arm_from_source

from ..refusal import sentence_of
from ..texts import TWO_JOINTS

EXACT = 1e-10
"""Relative: M beside MuJoCo's."""
ROTORS = {"shoulder": 0.3, "elbow": 0.02}
DRAKE = """<transmission><type>SimpleTransmission</type><joint name="{joint}"/>
<actuator name="m"><drake:rotor_inertia value="{J}"/><drake:gear_ratio value="{r}"/></actuator>
</transmission>"""


def postures(n, count=5):
    return np.random.default_rng(1).uniform(-1, 1, (count, n))


def test_m_is_mujocos(urdf):
    arm = load_arm(urdf(TWO_JOINTS), armature=ROTORS)
    model = mujoco.MjModel.from_xml_string(TWO_JOINTS)
    data = mujoco.MjData(model)
    model.dof_armature[:] = list(ROTORS.values())
    for q in postures(2):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        M = np.zeros((2, 2))
        mujoco.mj_fullM(model, data, M)
        for ours in (arm.mass_matrix(q), np.asarray(traced(arm).mass_matrix(q), dtype=float)):
            np.testing.assert_allclose(ours, M, rtol=EXACT, atol=EXACT)


def test_a_transmission_of_drake(urdf):
    text = TWO_JOINTS.replace(
        "</robot>", DRAKE.format(joint="elbow", J="1e-4", r="30") + "</robot>"
    )
    arm = load_arm(urdf(text))
    np.testing.assert_allclose(arm.armature, [0.0, 0.09])
    assert "joint 'elbow': rotor inertia 0.09 of its <transmission> is in M" in arm.warnings
    np.testing.assert_array_equal(load_arm(urdf(text), armature={"elbow": 0}).armature, [0, 0])
    bad = text.replace('value="1e-4"', 'value="light"')
    assert "transmission 'elbow': <rotor_inertia value=\"light\">" in sentence_of(urdf(bad))


@pytest.mark.parametrize("armature", [0.1, [0.1, 0.1], {"shoulder": 0.1, "elbow": 0.1}])
def test_the_forms_of_the_argument(urdf, armature):
    arm = load_arm(urdf(TWO_JOINTS), armature=armature)
    np.testing.assert_array_equal(arm.armature, [0.1, 0.1])
    np.testing.assert_array_equal(arm_from_source(**arm.source).armature, arm.armature)


@pytest.mark.parametrize(
    ("armature", "error"),
    [({"wrist": 1.0}, UnknownNameError), (-1.0, ParameterError), ([1.0] * 3, ShapeError)],
)
def test_wrong_arguments(urdf, armature, error):
    with pytest.raises(error, match="armature"):
        load_arm(urdf(TWO_JOINTS), armature=armature)


def loop_of(arm):
    return ClosedLoop(arm, FTCF(arm, compensation="bias"), Sinusoid([0.2] * arm.n))


def test_both_engines_agree(urdf):
    loop = loop_of(load_arm(urdf(TWO_JOINTS), armature=ROTORS))
    compiled, interpreted = (
        simulate_paths(loop, 1, 0.1, engine=engine) for engine in ("compiled", "interpreted")
    )
    np.testing.assert_allclose(compiled.q, interpreted.q, rtol=1e-9, atol=1e-12)
    without = simulate_paths(loop_of(load_arm(urdf(TWO_JOINTS))), 1, 0.1)
    assert np.max(np.abs(without.q - compiled.q)) > 1e-6


def test_it_may_vary_from_path_to_path(urdf):
    arm = load_arm(urdf(TWO_JOINTS), armature=ROTORS)
    values = np.array([[0.3, 0.02], [0.6, 0.04]])
    found = simulate_paths(loop_of(arm), 2, 0.05, vary={"arm.armature": values})
    single = simulate_paths(loop_of(arm.with_armature(values[1])), 1, 0.05)
    loops = loop_of(arm), loop_of(arm.with_armature(values[1]))
    assert loops[1].arm.source["armature"] == {"shoulder": 0.6, "elbow": 0.04}
    # The law of the varied loop knows the nominal rotors; its plant has the others.
    mixed = ClosedLoop(loops[1].arm, loops[0].controller, loops[0].reference)
    np.testing.assert_allclose(found.q[1], simulate_paths(mixed, 1, 0.05).q[0], atol=1e-12)
    assert np.max(np.abs(found.q[1] - single.q[0])) > 0


def test_uncertain_rotors(urdf):
    arm, sure = load_arm(urdf(TWO_JOINTS), armature=ROTORS), load_arm(urdf(TWO_JOINTS))
    drawn = Uncertainty(armature=0.2).draw(arm, 0, range(4000))["armature"]
    np.testing.assert_allclose(np.log(drawn / arm.armature).std(axis=0), 0.2, rtol=0.05)
    both = Uncertainty(mass=0.1, armature=0.2).draw(arm, 0, range(3))
    alone = Uncertainty(mass=0.1).draw(arm, 0, range(3))
    np.testing.assert_array_equal(both["inertias"], alone["inertias"])
    assert Uncertainty(armature=0.2).robot(arm, 0, 1).armature.tolist() == drawn[1].tolist()
    with pytest.raises(ParameterError, match="no armature"):
        Uncertainty(armature=0.2).check(sure)
