"""Gains that differ from joint to joint."""

import numpy as np
import pytest

from ftcfa import (
    CONTROLLERS,
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ComputedTorque,
    Experiment,
    Gains,
    PDGravity,
    PositionFeedback,
    Sinusoid,
    SuperTwisting,
    Vibration,
    WhiteNoise,
    bounds,
    load_arm,
    printed,
    simulate,
    simulate_paths,
)
from ftcfa.errors import FtcfaError
from ftcfa.parts import fields_of

ARM = load_arm("double_pendulum")
LAWS = {
    **{name: CONTROLLERS[name] for name in CONTROLLERS if hasattr(CONTROLLERS[name](ARM), "gains")},
    **{law.__name__: law for law in (ComputedTorque, PDGravity, PositionFeedback, SuperTwisting)},
}


def loop(law):
    shaken = Vibration(BaseAcceleration(), WhiteNoise(0.1))
    return ClosedLoop(ARM, law, Sinusoid([0.5, 0.4], 2.0), shaken, q0=[0.1, -0.1])


def with_gains(law, change):
    """The law with other gains: ``change`` of each value that may differ from joint to joint."""
    holder = getattr(law, "gains", law)
    fields = fields_of(holder)
    other = type(holder)(**{**fields, **{name: change(fields[name]) for name in holder.per_joint}})
    return type(law)(**{**fields_of(law), "gains": other}) if holder is not law else other


@pytest.mark.parametrize("name", LAWS)
def test_equal_gains_of_all_joints_are_the_same_law(name):
    law = LAWS[name](ARM)
    same = with_gains(law, lambda value: [value, value])
    ours, theirs = simulate(loop(same), 0.2), simulate(loop(law), 0.2)
    np.testing.assert_allclose(ours.u, theirs.u, rtol=0, atol=1e-10)


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
@pytest.mark.parametrize("name", LAWS)
def test_each_joint_has_its_own(name, engine):
    """On two masses that do not touch, joint 2 moves alike: its gains are the same."""

    class Masses:
        """Two carts on rails of their own."""

        n = 2
        joint_names = ("a", "b")
        joint_types = ("revolute", "revolute")
        effort_limit = np.array([100.0, 100.0])
        home = np.zeros(2)

        def mass_matrix(self, q):
            return np.eye(2)

        def potential_force(self, q):
            return 0.0 * q

        def bias_force(self, q, v):
            return 0.0 * q

        def coriolis_matrix(self, q, v):
            return np.zeros((2, 2))

        def damping_matrix(self, v):
            return np.zeros((2, 2))

        def friction_force(self, v):
            return 0.0 * v

    masses = Masses()
    law = LAWS[name](masses)
    network = {"adaptation": False, "anti_saturation": "none"} if isinstance(law, FTCF) else {}
    law = type(law)(**{**fields_of(law), **network})
    if name == "CommandFilteredBackstepping":
        pytest.skip("its network joins the joints")
    law = with_gains(law, lambda value: [0.5 * value, 1.1 * value])
    shared = with_gains(law, lambda value: [value[1], value[1]])
    reference = Sinusoid([0.5, 0.4], 2.0)
    ours, theirs = (
        simulate(ClosedLoop(masses, one, reference, q0=[0.1, -0.1]), 0.3, engine=engine)
        for one in (law, shared)
    )
    np.testing.assert_allclose(ours.q[:, 1], theirs.q[:, 1], rtol=0, atol=1e-12)
    assert np.max(np.abs(ours.q[:, 0] - theirs.q[:, 0])) > 1e-3


def test_they_may_differ_from_path_to_path():
    law = FTCF(ARM, Gains(c1=[5.0, 6.0]))
    c1 = np.array([[3.0, 9.0], [9.0, 3.0]])
    many = simulate_paths(loop(law), 2, 0.1, vary={"controller.gains.c1": c1})
    for path in range(2):
        alone = simulate(loop(FTCF(ARM, Gains(c1=c1[path]))), 0.1, path=path)
        np.testing.assert_allclose(many.q[path], alone.q, rtol=0, atol=1e-12)


def test_files_have_them():
    experiment = Experiment(loop(FTCF(ARM, Gains(c1=[5.0, 6.0], k2=0.5))), 1.0)
    again = Experiment.from_text(experiment.to_text()).loop.controller.gains
    np.testing.assert_array_equal(again.c1, [5.0, 6.0])
    assert again.k2 == 0.5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: FTCF(ARM, Gains(c1=[1.0, 2.0, 3.0])),
            "Gains c1: 3 numbers, expected one number, ",
        ),
        (lambda: FTCF(ARM, Gains(c1=[1.0, 0.0])), "Gains c1: .*, expected numbers > 0"),
        (lambda: Gains(k1="fast"), "Gains k1"),
        (lambda: ComputedTorque(ARM, [1.0]), "ComputedTorque position_rate: 1 numbers"),
        (
            lambda: bounds(loop(printed(FTCF(ARM, Gains(c2=[1.0, 2.0]))))),
            "controller gains c2: a number for each joint, expected one number for all joints",
        ),
    ],
)
def test_wrong_ones_are_refused(make, message):
    with pytest.raises(FtcfaError, match=message):
        make()
