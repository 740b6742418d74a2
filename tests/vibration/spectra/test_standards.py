"""The specifications that come with the package, and tables of a user's own."""

import math
from itertools import pairwise

import pytest
from scipy.integrate import quad

from ftcfa.errors import ParameterError, UnknownNameError
from ftcfa.vibration.spectra.standards import read_table, standard, standards

INTEGRAL = 0.01
"""The tables state their integral to three or four digits."""
NOMINAL = {  # overall level [g], as the specifications state it
    "mil_std_810g_highway_truck_vertical": 1.04,
    "mil_std_810g_highway_truck_transverse": 0.20,
    "mil_std_810g_highway_truck_longitudinal": 0.74,
    "gevs_qualification": 14.1,
    "gevs_acceptance": 10.0,
    "astm_d4169_truck_low": 0.40,
    "astm_d4169_truck_medium": 0.54,
    "astm_d4169_truck_high": 0.70,
}
NOMINAL_TOLERANCE = 0.02
"""Nominal levels are rounded to two digits."""
POINTS = "points = [[10, 0.015], [40, 0.015], [500, 0.00015]]\n"


def test_the_standards_are_these():
    assert list(standards()) == list(NOMINAL)


@pytest.mark.parametrize("name", NOMINAL)
def test_a_standard_has_its_level(name):
    one = standard(name)
    points = one.spectrum.frequencies
    power = sum(quad(one.spectrum.density, low, high)[0] for low, high in pairwise(points))
    level = math.sqrt(power) / 9.80665
    assert one.spectrum.g_rms() == pytest.approx(level, rel=1e-7)
    assert level == pytest.approx(NOMINAL[name], rel=NOMINAL_TOLERANCE)
    assert one.nominal_g_rms == NOMINAL[name]


@pytest.mark.parametrize("name", NOMINAL)
def test_a_standard_shows_its_provenance(name):
    one = standard(name)
    assert one.name == name
    assert one.source in str(one)
    assert one.verified in str(one)
    if not name.startswith("gevs"):
        assert "unverified" in str(one)


def test_the_text_of_a_standard():
    assert str(standard("mil_std_810g_highway_truck_vertical")) == (
        "mil_std_810g_highway_truck_vertical: 1.04 g rms from 10 to 500 Hz (source: MIL-STD-810G, "
        "method 514.6, figure 514.6C-1 (US highway truck); verified: unverified in a primary "
        "source; the integral matches the nominal level)"
    )


def test_an_unknown_standard_lists_the_known():
    with pytest.raises(UnknownNameError) as refused:
        standard("truck")
    for name in NOMINAL:
        assert name in str(refused.value)


def test_the_standards_cannot_be_changed():
    with pytest.raises(TypeError):
        standards()["mine"] = None


@pytest.fixture
def table(tmp_path):
    def write(text):
        file = tmp_path / "mine.toml"
        file.write_text(text)
        return file

    return write


def test_a_table_of_ones_own(table):
    file = table("[floor]\n" + POINTS + "[wall]\nsource = 'measured'\n" + POINTS)
    read = read_table(file)
    assert list(read) == ["floor", "wall"]
    assert read["floor"].spectrum.g_rms() == pytest.approx(1.043, rel=INTEGRAL)
    assert read["floor"].nominal_g_rms is None
    assert str(read["floor"]) == (
        "floor: 1.04 g rms from 10 to 500 Hz (source: not stated; verified: not stated)"
    )
    assert "source: measured" in str(read["wall"])


def test_a_table_in_si(table):
    read = read_table(table('[floor]\nunit = "(m/s^2)^2/Hz"\npoints = [[10, 1], [20, 1]]'))
    assert read["floor"].spectrum.rms() == pytest.approx(math.sqrt(10.0))


def test_a_level_that_is_meant(table):
    text = "[floor]\nplausible_g_rms = 1000\npoints = [[20, 100], [2000, 100]]"
    assert read_table(table(text))["floor"].spectrum.g_rms() > 400


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "{file}: no table, expected one TOML table for each standard; such as [floor] with"),
        ("points = [[10, 1], [20, 1]]", "{file}: 'points': [[10, 1], [20, 1]], expected a TOML"),
        ("[floor]\nsource = 'x'", "{file}: [floor]: points: missing, expected [[frequency,"),
        ("[floor]\npoints = []", "{file}: [floor]: points: [], expected [[frequency, density]"),
        ("[floor]\npoints = [[10, 1], [20]]", "{file}: [floor]: points: [[10, 1], [20]], expected"),
        ("[floor]\npoints = [[10, '1'], [20, 1]]", "{file}: [floor]: points: [[10, '1'], [20, 1]]"),
        (
            "[floor]\npoints = [[10, -1], [20, 1]]",
            "{file}: [floor]: points: Spectrum density 1: -1, expected a number > 0; outside",
        ),
        (
            "[floor]\npoints = [[20, 1], [10, 1]]",
            "{file}: [floor]: points: Spectrum frequencies 1 and 2: 20 then 10 Hz, expected rising",
        ),
        (
            "[floor]\npoints = [[20, 100], [2000, 100]]",
            "{file}: [floor]: points: Spectrum densities: 445 g rms overall when read as g^2/Hz",
        ),
        ("[floor]\nsource = 1\n" + POINTS, "{file}: [floor]: source: 1, expected a text"),
        (
            "[floor]\nunit = 'dB'\n" + POINTS,
            '{file}: [floor]: unit: \'dB\', expected "g^2/Hz" or "(m/s^2)^2/Hz"',
        ),
        (
            "[floor]\nnominal_g_rms = -1\n" + POINTS,
            "{file}: [floor]: nominal_g_rms: -1, expected a number > 0 [g]",
        ),
        (
            "[floor]\nlevel = 1\n" + POINTS,
            "{file}: [floor]: key 'level': unknown name, expected one of: points, unit, source,",
        ),
        (
            "[floor]\nintegral_g_rms = 1.1\n" + POINTS,
            "{file}: [floor]: integral_g_rms: 1.1 stated, 1.043 g rms by integration of the "
            "points, expected agreement to 1 %; correct the points or the level",
        ),
        (
            "[floor]\nnominal_g_rms = 10.2\n" + POINTS,
            "{file}: [floor]: nominal_g_rms: 10.2 stated, 1.043 g rms by integration of the "
            "points, expected agreement to 5 %; the points are 9.81 times too small in amplitude",
        ),
        (
            "[floor]\nnominal_g_rms = 0.106\n" + POINTS,
            "{file}: [floor]: nominal_g_rms: 0.106 stated, 1.043 g rms by integration of the "
            "points, expected agreement to 5 %; the points are 9.81 times too large in amplitude: "
            'state unit = "(m/s^2)^2/Hz"',
        ),
        ("[floor\n", "{file}: Expected ']'"),
    ],
)
def test_a_bad_table_names_file_table_and_key(table, text, message):
    file = table(text)
    with pytest.raises((ParameterError, UnknownNameError)) as refused:
        read_table(file)
    assert str(refused.value).startswith(message.format(file=file))


def test_a_missing_file(tmp_path):
    with pytest.raises(ParameterError, match=r"none.toml: no such file or directory, expected a r"):
        read_table(tmp_path / "none.toml")
