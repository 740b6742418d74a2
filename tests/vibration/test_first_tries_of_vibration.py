"""What a newcomer to vibration types first and gets wrong: one clear sentence, and what to do."""

import numpy as np
import pytest

from ftcfa import JointTorque, ParameterError, RecordedAcceleration, ShapedNoise, load_arm, realise


def test_the_name_of_a_file_is_no_record():
    with pytest.raises(ParameterError, match=r"a str, expected a Record; read_record\(file\)"):
        RecordedAcceleration("floor.csv")


def test_break_points_are_no_spectrum_yet():
    with pytest.raises(ParameterError, match=r"break points make one: Spectrum\.from_g\(\["):
        ShapedNoise.from_psd([[10, 0.015], [40, 0.015], [500, 0.00015]])


def test_a_name_is_no_excitation_yet():
    with pytest.raises(ParameterError, match="realise excitation: 'gevs_acceptance', expected an"):
        realise("gevs_acceptance", 1, 1.0, 1e-4)


def test_a_single_joint_needs_no_brackets():
    arm = load_arm("double_pendulum")
    matrix = JointTorque("elbow").matrix(arm, np.zeros(2))
    np.testing.assert_array_equal(matrix, [[0.0], [1.0]])
