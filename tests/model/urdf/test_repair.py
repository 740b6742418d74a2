"""The nearest physical inertias: what the projection is, and what a file's repair costs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ftcfa import UrdfError, load_arm
from ftcfa.model.inertia import check_bodies
from ftcfa.model.urdf.bodies import NEGLIGIBLE, projected

from ..refusal import sentence_of
from ..texts import BASE, ELBOW, SHOULDER, link, robot, with_upper

GRID = 1e-11
"""Relative: a repaired inertia is rounded."""
TINY = {"ixx": 1e-8, "iyy": 1e-8, "izz": 1e-7}
usual = st.floats(-1, 1).map(lambda x: x if abs(x) > 1e-9 else 0.0)  # files hold no others
symmetric = arrays(float, (3, 3), elements=usual).map(lambda A: A + A.T)


def moments(inertia):
    """S = tr(I)/2 1 - I."""
    return np.trace(inertia) / 2 * np.eye(3) - inertia


@given(symmetric)
def test_the_projection_is_physical_and_leaves_physical_bodies_alone(A):
    body = projected(A)
    slack = GRID * np.abs(A).max()
    assert np.linalg.eigvalsh(moments(body))[0] >= -slack
    np.testing.assert_allclose(projected(body), body, atol=10 * slack)


@settings(max_examples=50)
@given(symmetric, arrays(float, (20, 3, 3), elements=st.floats(-1, 1)))
def test_no_physical_body_is_nearer(A, roots):
    S, nearest = moments(A), moments(projected(A))
    distance = np.linalg.norm(S - nearest)
    for root in roots:
        for other in (root @ root.T, nearest + 1e-3 * root @ root.T):
            assert np.linalg.norm(S - other) >= distance - 1e-9


def test_a_negligible_repair_is_made_and_said(urdf):
    # A tool frame of 1e-8 kg with a placeholder tensor: the arm's M does not feel it.
    text = robot(BASE, link("upper"), link("lower", 1e-8, **TINY), SHOULDER, ELBOW, link("hand"))
    text = text.replace("</robot>", _fixed("lower", "hand") + "</robot>")
    arm = load_arm(urdf(text))
    (said,) = [warning for warning in arm.warnings if "principal moments" in warning]
    assert said.startswith("link 'lower': principal moments (1e-08, 1e-08, 1e-07) become (")
    assert "M changes by" in said
    check_bodies("arm", arm.inertias, 2)


def _fixed(parent, child):
    return (
        f'<joint name="weld" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
    )


def test_a_repair_that_changes_the_arm_is_refused_with_its_price(urdf):
    file = urdf(with_upper(link("upper", izz=0.9)))
    sentence = sentence_of(file)
    assert 'or pass repair="project" (--repair): M changes by' in sentence
    arm = load_arm(file, repair="project")
    check_bodies("arm", arm.inertias, 2)
    again = load_arm(file, repair="project")
    np.testing.assert_array_equal(arm.inertias, again.inertias)
    assert arm.source["repair"] == "project"


def test_the_price_is_the_largest_change_of_the_scaled_mass_matrix(urdf):
    # One joint about z: M is Izz plus m d^2, and the projection of (0.1, 0.1, 0.9) is
    # (0.45, 0.45, 0.9) - S = diag(0.45, 0.45, -0.35) loses -0.35 - so M does not change at all;
    # about x, M = 0.1 + d^2 becomes 0.45 + d^2.
    shoulder = SHOULDER.replace('xyz="0 1 0"', 'xyz="1 0 0"')
    file = urdf(robot(BASE, link("upper", 1, "0 0 0", izz=0.9), shoulder))
    with pytest.raises(UrdfError, match=r"M changes by 0\.78 at home and 0\.78 at worst"):
        load_arm(file)
    assert load_arm(file, repair="project").mass_matrix(np.zeros(1))[0, 0] == pytest.approx(0.45)
    about_z = SHOULDER.replace('xyz="0 1 0"', 'xyz="0 0 1"')
    arm = load_arm(urdf(robot(BASE, link("upper", 1, "0 0 0", izz=0.9), about_z)))
    assert arm.mass_matrix(np.zeros(1))[0, 0] == pytest.approx(0.9, abs=NEGLIGIBLE)


def test_a_negative_mass_cannot_be_repaired(urdf):
    file = urdf(with_upper(link("upper", -1)))
    assert "mass is -1 kg" in sentence_of(file, repair="project")


def test_an_unknown_repair_is_refused(urdf):
    with pytest.raises(Exception, match="repair 'heal'"):
        load_arm(urdf(with_upper(link("upper"))), repair="heal")
