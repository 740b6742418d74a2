"""What a newcomer types first and gets wrong: one clear sentence each, and nothing runs."""

import numpy as np
import pytest

import ftcfa
from ftcfa import FTCF, BaseAcceleration, ClosedLoop, ParameterError, ShapeError, Sinusoid
from ftcfa.model.urdf.catalogue import robots_folder

PENDULUM = ftcfa.load_arm("double_pendulum")
REFERENCE = Sinusoid([0.3, 0.2])
LOOP = ClosedLoop(PENDULUM, FTCF(PENDULUM), REFERENCE)


class Pair:
    """A law that returns (u, state), the commonest first mistake."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
        return np.zeros_like(q), state


class Clash(Pair):
    """A law with a signal named like a coordinate of the Dataset."""

    def step(self, state, measured, desired, period):
        q = measured.q
        return {"u": np.zeros_like(q), "time": np.zeros(1)}, state


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        (("panda", FTCF(PENDULUM), REFERENCE), "ClosedLoop arm: a str, expected an Arm"),
        ((PENDULUM, None, REFERENCE), "ClosedLoop controller: a NoneType, expected a control law"),
        ((PENDULUM, FTCF(PENDULUM), np.zeros(2)), "ClosedLoop reference: a ndarray, expected a"),
        (
            (PENDULUM, FTCF(PENDULUM), REFERENCE, BaseAcceleration()),
            r"ClosedLoop vibration: a BaseAcceleration, expected a Vibration\(input, excitation\)",
        ),
    ],
)
def test_parts_in_the_wrong_place(parts, text):
    with pytest.raises(ParameterError, match=text):
        ClosedLoop(*parts)


def test_a_controller_of_a_name_or_of_loose_gains():
    with pytest.raises(ParameterError, match="FTCF nominal: a str, expected an Arm"):
        FTCF("panda")
    with pytest.raises(ParameterError, match=r"FTCF gains: .*, expected Gains\(\.\.\.\)"):
        FTCF(PENDULUM, {"c1": 3.0})


def test_laws_that_return_something_else():
    with pytest.raises(ParameterError, match="step of Pair: a tuple without a dictionary that"):
        ftcfa.simulate(ClosedLoop(PENDULUM, Pair(), REFERENCE), 0.01)
    with pytest.raises(ParameterError, match="signal 'time' of Clash: a name that the Dataset has"):
        ftcfa.simulate(ClosedLoop(PENDULUM, Clash(), REFERENCE), 0.01)


@pytest.mark.parametrize(
    ("name", "values", "text"),
    [
        ("arm.home", np.zeros((2, 2)), "varied arm.home: no effect on the motion"),
        ("arm.effort_limit", -np.ones((2, 2)), "effort_limit of double_pendulum: -1, expected"),
        ("arm.inertias", -np.ones((2, 3, 10)), "inertias of double_pendulum: a pseudo-inertia"),
    ],
)
def test_what_cannot_vary(name, values, text):
    with pytest.raises(ParameterError, match=text):
        ftcfa.simulate_paths(LOOP, 2, 0.01, vary={name: values})


def test_a_record_larger_than_the_machine():
    with pytest.raises(
        ParameterError, match=r"record: .* GiB, .*; raise record_every, or run fewer"
    ):
        ftcfa.simulate_paths(LOOP, 10**8, 10.0)


def test_an_arm_says_briefly_what_it_is_and_is_not_changed_in_place():
    assert repr(PENDULUM) == "Arm('double_pendulum', 2 joints)"
    with pytest.raises(ValueError, match="read-only"):
        PENDULUM.effort_limit[:] = 3.0


def test_inertias_of_another_shape_or_of_no_body():
    with pytest.raises(ShapeError, match=r"inertias of double_pendulum: shape \(2, 10\)"):
        PENDULUM.with_inertias(np.ones((2, 10)))
    with pytest.raises(ParameterError, match="expected positive semidefinite pseudo-inertias"):
        PENDULUM.with_inertias(-PENDULUM.inertias)


def test_a_pinocchio_model_changed_in_place_is_noticed():
    arm = ftcfa.load_arm("ur5")
    reference = Sinusoid(offset=arm.home)
    before = ftcfa.simulate(ClosedLoop(arm, FTCF(arm), reference), 0.05)
    arm.model.inertias[2] = arm.model.inertias[2] + arm.model.inertias[2]
    loop = ClosedLoop(arm, FTCF(arm), reference)
    runs = [ftcfa.simulate(loop, 0.05, engine=e) for e in ("compiled", "interpreted")]
    assert runs[0].engine == "compiled"
    np.testing.assert_allclose(runs[0].u, runs[1].u, rtol=1e-9, atol=1e-9)
    assert np.max(np.abs(runs[0].u - before.u)) > 1e-3


def test_paths_are_ordinary_integers():
    paths = ftcfa.simulate_paths(LOOP, 2, 0.01).path
    assert (paths - 1).values.tolist() == [-1, 0]


def test_limits_of_an_exporter_mean_none(tmp_path):
    text = (robots_folder() / "double_pendulum_relative.urdf").read_text()
    huge = text.replace("continuous", "revolute").replace(
        'velocity="20"', 'velocity="20" lower="-1.79e308" upper="1.79e308"'
    )
    file = tmp_path / "huge.urdf"
    file.write_text(huge)
    assert np.all(np.isinf(ftcfa.load_arm(file).upper))
