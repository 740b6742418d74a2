"""The model's constants, against those that Pinocchio computes from the same URDF."""

import numpy as np
import pinocchio as pin
import pytest

from ftcfa.model.urdf.catalogue import catalogue, locate
from ftcfa.model.urdf.description import read_urdf
from ftcfa.model.urdf.load import MOUNTINGS
from ftcfa.model.urdf.model import model_of_urdf

DOWN = np.array([0.0, 0.0, -9.81])


@pytest.mark.parametrize("robot", catalogue())
@pytest.mark.parametrize("mounting", MOUNTINGS)
def test_placements_and_inertias_are_pinocchios(robot, mounting):
    turn = MOUNTINGS[mounting]
    xml = read_urdf(locate(robot, ())[1]).pinocchio_xml()
    ours, theirs = model_of_urdf(xml, DOWN, turn), pin.buildModelFromXML(xml)
    base = pin.SE3(turn, np.zeros(3))
    for i in range(1, theirs.njoints):
        placement = theirs.jointPlacements[i]
        expected = base * placement if theirs.parents[i] == 0 else placement
        assert ours.jointPlacements[i].isApprox(expected, 1e-14)
        assert ours.inertias[i].isApprox(theirs.inertias[i], 1e-13)
    for mine, its in zip(list(ours.frames)[1:], list(theirs.frames)[1:], strict=True):
        expected = base * its.placement if its.parentJoint == 0 else its.placement
        assert mine.placement.isApprox(expected, 1e-14), mine.name
