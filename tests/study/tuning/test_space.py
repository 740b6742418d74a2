"""What a tuner may change."""

import numpy as np
import pytest

from ftcfa import FTCF, FeedForward, Gains, SlotineLi, joint_by_joint, search_space
from ftcfa.errors import FtcfaError
from ftcfa.study.tuning.space import Space

from .loops import ARM, Spring, loop, paper


def test_it_is_what_the_law_declares_and_has_an_effect():
    names = set(search_space(paper()))
    gains = {f"controller.gains.{name}" for name in ("c1", "c2", "k1", "k2", "kappa", "iota")}
    filters = {"controller.filter.r1", "controller.filter.r2"}
    assert names == {*gains, *filters, "controller.gains.lambda_"}
    still = search_space(loop(FTCF(ARM, adaptation=False)))
    assert names - set(still) == {"controller.gains.iota", "controller.gains.lambda_"}


def test_a_law_of_ones_own_needs_nothing_else():
    space = search_space(loop(Spring(ARM)))
    assert space == {
        "controller.stiffness": (1.0, 1000.0, "N m/rad"),
        "controller.damping": (0.1, 100.0, "N m s/rad"),
    }


def test_the_law_inside_of_another_is_searched():
    law = FeedForward(ARM, SlotineLi(ARM), 30.0)
    from ftcfa import Accelerometer, Hardware

    space = search_space(loop(law, hardware=Hardware(accelerometer=Accelerometer(3))))
    assert {"controller.band", "controller.law.leakage"} <= set(space)


def test_points_are_logarithmic_and_come_back():
    it = loop()
    ranges = {"controller.position_rate": (0.1, 10.0), "controller.velocity_rate": (1, 100)}
    space = Space(it, ranges)
    found = space.values(np.array([[0.0, 0.5], [1.0, 1.0]]))
    np.testing.assert_allclose(found["controller.position_rate"], [0.1, 10.0])
    np.testing.assert_allclose(found["controller.velocity_rate"], [10.0, 100.0])
    np.testing.assert_allclose(space.unit_start, np.log([30.0, 5.0]) / np.log(100.0))
    same = space.loop_at(it, space.unit_start).controller
    np.testing.assert_allclose([same.position_rate, same.velocity_rate], [3.0, 5.0])
    assert type(same.position_rate) is float


def test_joint_by_joint_every_joint_counts():
    it = joint_by_joint(paper())
    space = Space(it, {"controller.gains.c1": (1.0, 100.0), "controller.gains.kappa": (0.5, 1.0)})
    names = ["c1[0]", "c1[1]", "kappa"]
    assert space.names == [f"controller.gains.{name}" for name in names]
    found = space.loop_at(it, np.array([0.0, 1.0, 0.5])).controller.gains
    np.testing.assert_allclose(found.c1, [1.0, 100.0])
    assert found.kappa == pytest.approx(np.sqrt(0.5))
    assert it.controller.gains.kappa == Gains().kappa


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({}, "tune space: nothing of ComputedTorque, expected parameters to tune"),
        ({"controller.position_rates": (1.0, 2.0)}, "mean 'position_rate'"),
        ({"controller.position_rate": (2.0, 1.0)}, "expected 0 < smallest < largest"),
        ({"controller.position_rate": (0.0, 1.0)}, "expected 0 < smallest < largest"),
        ({"controller.position_rate": 3.0}, "expected 0 < smallest < largest"),
        ({"controller.position_rate": ("a", "b")}, "expected 0 < smallest < largest"),
        ({"reference": (1.0, 2.0)}, "common to all paths"),
    ],
)
def test_wrong_ranges_are_refused(ranges, message):
    with pytest.raises(FtcfaError, match=message):
        Space(loop(), ranges)
