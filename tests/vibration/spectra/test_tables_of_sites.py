"""Tables as people write them: slopes, steps, estimates in CSV, and in experiment files."""

import numpy as np
import pytest

from ftcfa import load_experiment
from ftcfa.errors import FtcfaError, ParameterError
from ftcfa.vibration.spectra.standards import read_table, spectrum_of_points

G = 9.80665
SLOPES = [[20, "+3 dB/octave"], [80, 0.04], [350, 0.04], [2000, "-3 dB/octave"]]


def test_slopes_give_the_densities_to_which_they_lead():
    spectrum = spectrum_of_points(SLOPES)
    octaves = np.log2([20 / 80, 2000 / 350]) * [1, -1]
    ends = 0.04 * 10 ** (0.3 * octaves)
    np.testing.assert_allclose(spectrum.densities[[0, -1]] / G**2, ends, rtol=1e-12)
    two = spectrum_of_points([[10, 0.01], [20, "6 dB/oct"], [40, "+6dB/octave"]])
    np.testing.assert_allclose(two.densities / G**2, 0.01 * 10 ** np.array([0, 0.6, 1.2]))


def test_a_step():
    spectrum = spectrum_of_points([[10, 0.01], [40, 0.01], [40, 0.04], [100, 0.04]])
    S = spectrum.density([39.9, 40.1]) / G**2
    np.testing.assert_allclose(S, [0.01, 0.04], rtol=1e-9)
    assert spectrum.g_rms() == pytest.approx(np.sqrt(0.01 * 30 + 0.04 * 60), rel=1e-5)


@pytest.mark.parametrize(
    "points",
    [[[10, "3 dB"], [20, 0.1]], [[10, "+3 dB/octave"], [20, "+3 dB/octave"]], [[0, 1], [1, 1]]],
)
def test_wrong_points(points):
    with pytest.raises(ParameterError, match="points"):
        spectrum_of_points(points)


def test_welchs_estimates_of_a_csv(tmp_path):
    file = tmp_path / "welch.csv"
    file.write_text("frequency [Hz],hall [g^2/Hz],roof [(m/s^2)^2/Hz]\n0,1,1\n10,0.1,2\n20,0.2,4\n")
    tables = read_table(file)
    np.testing.assert_allclose(tables["hall"].spectrum.densities / G**2, [0.1, 0.2])
    np.testing.assert_allclose(tables["roof"].spectrum.densities, [2, 4])
    assert tables["hall"].source == "welch.csv"
    file.write_text("frequency [Hz],hall\n10,0.1\n20,0.2\n")
    with pytest.raises(FtcfaError, match="unit: 'not stated'"):
        read_table(file)
    file.write_text("f,hall [g^2/Hz]\n10,0.1\n20,0.2\n")
    with pytest.raises(FtcfaError, match="no column of frequencies in Hz"):
        read_table(file)


EXPERIMENT = """duration = 1.0
arm = {{ robot = "double_pendulum" }}
reference = {{ type = "Sinusoid", amplitude = [0.1, 0.1] }}
controller = {{ type = "FTCF" }}
[vibration]
input = {{ type = "BaseAcceleration", axes = "z" }}
[vibration.excitation]
type = "ShapedNoise"
axes = [{axis}]
"""


@pytest.mark.parametrize(
    "axis",
    [
        '{ table = "my_site.toml", name = "hall" }',
        '{ type = "Standard", table = "my_site.toml", name = "hall" }',
        "{ points = [[10, 0.001], [40, 0.001], [100, 0.0001]] }",
        '{ points = [[10, 0.001], [40, 0.001], [100, "-7.5647 dB/octave"]] }',
    ],
)
def test_a_table_of_a_site_in_an_experiment(tmp_path, axis):
    points = "[[10, 0.001], [40, 0.001], [100, 0.0001]]"
    (tmp_path / "my_site.toml").write_text(f"[hall]\npoints = {points}\n")
    file = tmp_path / "e.toml"
    file.write_text(EXPERIMENT.format(axis=axis))
    (found,) = load_experiment(file).loop.vibration.excitation.axes
    spectrum = getattr(found, "spectrum", found)
    np.testing.assert_allclose(spectrum.densities / G**2, [1e-3, 1e-3, 1e-4], rtol=1e-4)
    saved = tmp_path / "saved.toml"
    load_experiment(file).save(saved)
    again = load_experiment(saved).loop.vibration.excitation.axes[0]
    np.testing.assert_array_equal(getattr(again, "spectrum", again).densities, spectrum.densities)
