"""White noise: its two conventions, what it refuses, and the impulse it gives the joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ftcfa import (
    BaseAcceleration,
    PaperPendulum,
    ParameterError,
    ShapeError,
    UnknownNameError,
    Vibration,
    WhiteNoise,
    load_arm,
)

ROUNDING = 1e-12
"""Some products of well-scaled 3 x 3 matrices."""
FULL = [[0.5, 0.2, 0.0], [0.2, 0.3, -0.1], [0.0, -0.1, 0.4]]


@pytest.mark.parametrize(
    ("intensity", "varpi"),
    [
        (0.1, 0.1 * np.eye(3)),
        (2, 2.0 * np.eye(3)),
        ([0.1, 0.2, 0.3], np.diag([0.1, 0.2, 0.3])),
        (FULL, np.array(FULL)),
        (0.0, np.zeros((3, 3))),
        ([1.0, 0.0, 2.0], np.diag([1.0, 0.0, 2.0])),
        (np.ones((3, 3)), np.ones((3, 3))),  # of rank 1: three axes shaken as one
    ],
)
def test_both_conventions(intensity, varpi):
    sigma = WhiteNoise(intensity).amplitude(3)
    np.testing.assert_allclose(sigma @ sigma.T, varpi, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(WhiteNoise(intensity, "amplitude").amplitude(3), varpi)


def test_the_conventions_differ_by_a_root():
    assert WhiteNoise(0.1).amplitude(1)[0, 0] == pytest.approx(0.316, abs=5e-4)
    assert WhiteNoise(0.1, "amplitude").amplitude(1)[0, 0] == 0.1


@given(arrays(float, (3, 3), elements=st.floats(-10, 10)))
def test_sigma_is_a_root_of_any_positive_semidefinite_intensity(root):
    varpi = root @ root.T
    sigma = WhiteNoise(varpi).amplitude(3)
    scale = max(1.0, np.abs(varpi).max())
    np.testing.assert_allclose(sigma @ sigma.T, varpi, rtol=0, atol=ROUNDING * scale)


@pytest.mark.parametrize(
    "intensity",
    [
        -0.1,
        [0.1, -0.1],
        [[1.0, 2.0], [2.0, 1.0]],  # indefinite
        [[1.0, 0.5], [0.0, 1.0]],  # asymmetric
        [[1e-10, 5e-11], [0.0, 1e-10]],  # asymmetric and small
        np.nan,
        [0.1, np.inf],
        [[0.1, np.nan], [np.nan, 0.1]],
    ],
)
def test_what_is_no_covariance_is_refused(intensity):
    with pytest.raises(ParameterError, match=r"WhiteNoise intensity: .* positive semidefinite"):
        WhiteNoise(intensity)


@pytest.mark.parametrize("intensity", ["loud", None, object(), [0.1, "x"], [[0.1], [0.1, 0.2]]])
def test_what_is_no_number_is_refused(intensity):
    with pytest.raises(ParameterError, match="WhiteNoise intensity"):
        WhiteNoise(intensity)


@pytest.mark.parametrize("shape", [(2, 3), (2, 2, 2), (0,), (0, 0)])
def test_a_wrong_shape_is_refused(shape):
    with pytest.raises(ShapeError, match=r"WhiteNoise intensity: shape .* expected \(\), \(m,\)"):
        WhiteNoise(np.ones(shape))


def test_an_unknown_convention_is_refused():
    with pytest.raises(UnknownNameError, match=r"convention 'rms'.*one of: psd, amplitude"):
        WhiteNoise(0.1, "rms")


@pytest.mark.parametrize("intensity", [[0.1, 0.1], np.eye(4), [0.1]])
def test_the_channels_must_be_those_of_the_input(intensity):
    with pytest.raises(ShapeError, match="channels, expected 3 channels"):
        Vibration(BaseAcceleration("xyz"), WhiteNoise(intensity)).process(load_arm("ur5"), 1e-3)


def test_a_vibration_needs_an_input_and_an_excitation():
    with pytest.raises(ParameterError, match="Vibration input: 'shaking', expected a noise input"):
        Vibration("shaking", WhiteNoise())
    with pytest.raises(
        ParameterError, match="Vibration excitation: a float, expected an excitation"
    ):
        Vibration(BaseAcceleration(), 0.1)


@pytest.mark.parametrize("convention", ["psd", "amplitude"])
def test_the_impulse_over_a_step_has_the_covariance_of_the_noise(convention):
    varpi = np.array([[0.5, 0.2], [0.2, 0.3]])
    arm, q, step = PaperPendulum(), np.array([0.4, -1.1]), 0.003
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(varpi, convention))
    process = vibration.process(arm, step)
    still = vibration.init(process, np.zeros(0))
    assert process.normals == 2
    columns = [
        vibration.impulse(process, arm, q, np.zeros(2), still, normals, np.zeros(0), step)[0]
        for normals in np.eye(2)
    ]
    root = np.column_stack(columns)  # the impulse is linear in its two independent deviates
    Lambda = -arm.base_coupling(q)[:, [0, 2]]
    intensity = varpi if convention == "psd" else varpi @ varpi
    covariance = step * Lambda @ intensity @ Lambda.T
    np.testing.assert_allclose(root @ root.T, covariance, rtol=0, atol=ROUNDING)


def test_no_intensity_gives_no_impulse():
    vibration = Vibration(BaseAcceleration("xz"), WhiteNoise(0.0))
    arm, still = PaperPendulum(), np.zeros(2)
    process = vibration.process(arm, 1e-3)
    state = vibration.init(process, np.zeros(0))
    impulse, _ = vibration.impulse(process, arm, still, still, state, np.ones(2), np.zeros(0), 1e-3)
    np.testing.assert_array_equal(impulse, 0.0)
