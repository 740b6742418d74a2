"""The figure of a standard, and what is said of it as data and on a terminal."""

import io
import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from matplotlib.image import imread
from rich.console import Console

from ftcfa import read_table, standard, standards
from ftcfa.report.figures import figure_files, rendered
from ftcfa.report.vibration import (
    catalogue_record,
    print_catalogue,
    print_realised,
    realised_record,
    unverified,
)
from ftcfa.report.vibration_figure import vibration_figure
from ftcfa.study.realised_spectrum import realise_standard
from ftcfa.vibration.spectra.road import ROAD_CLASSES

TRUCK = "mil_std_810g_highway_truck_vertical"
SOURCE = (
    "costs $5 or $6, of [bold]no one[/bold] and of a campaign with a title so long that it "
    "certainly does not fit into a single line of a figure"
)
DECK = f"""[deck]
points = [[2, 0.001], [10, 0.01], [40, 0.001]]
source = "{SOURCE}"
"""
SEGMENTS = 6
"""Averaged in these tests, for speed: what is drawn is not judged here."""


@pytest.fixture(scope="module")
def realised(tmp_path_factory):
    """A table that comes along, and one of a user's own whose source is hard to print."""
    file = tmp_path_factory.mktemp("tables") / "own.toml"
    file.write_text(DECK)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ftcfa.study.realised_spectrum.LENGTHS", SEGMENTS)
        return [realise_standard(one) for one in (standard(TRUCK), read_table(file)["deck"])]


@pytest.fixture(scope="module")
def record(realised):
    return realised_record(realised)


@pytest.fixture(scope="module")
def figure(realised):
    return vibration_figure(realised)


@pytest.fixture(scope="module")
def files(realised, record):
    return figure_files("spectrum", vibration_figure(realised), record)


def printed(function, record, width):
    stream = io.StringIO()
    function(record, Console(file=stream, width=width))
    return stream.getvalue()


def test_files_are_the_figure_and_the_record(files, record):
    assert sorted(files) == ["spectrum.png", "spectrum.svg", "summary.json"]
    assert json.loads(files["summary.json"]) == record


def test_same_figure_same_bytes(realised, files):
    assert rendered(vibration_figure(realised))["svg"] == files["spectrum.svg"]


def test_png_shows_something_and_clips_nothing(files):
    picture = imread(io.BytesIO(files["spectrum.png"]), format="png")[..., :3]
    assert 0.01 < np.mean(picture.min(axis=2) < 0.9) < 0.5
    for border in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert np.all(border == 1.0)


def test_svg_holds_its_words_as_text(files):
    root = ElementTree.fromstring(files["spectrum.svg"])
    words = "".join("".join(e.itertext()) for e in root.iter() if e.tag.endswith("}text"))
    text = "".join(words.split())
    for expected in (
        TRUCK,
        "source: MIL-STD-810G, method 514.6",
        "unverified in a primary source",
        "costs $5 or $6, of [bold]no one[/bold]",
        "single line of a figure",
        "verified: not stated",
        "frequency [Hz]",
        "acceleration density [g²/Hz]",
        "±1.5 dB",
        "RandomPhase, 200 lines",
    ):
        assert "".join(expected.split()) in text


def test_each_panel_says_its_levels(realised, figure):
    panels = figure.axes
    assert [ax.get_title(loc="left") for ax in panels] == [TRUCK, "deck"]
    for ax, one in zip(panels, realised, strict=True):
        legend = ax.get_legend()
        specified, tolerance, fitted, shaped, tones = (t.get_text() for t in legend.get_texts())
        assert specified == f"specified\n{one.standard.spectrum.g_rms():#.4g} g rms"
        assert tolerance == "±1.5 dB"
        assert fitted.startswith(f"fitted filter, order {one.fit.filter.order}\n")
        assert f"\n{one.shaped.rms[0] / 9.80665:#.4g} g rms\nWelch, every" in shaped
        assert f"{one.tones.rms[0] / 9.80665:#.4g} g rms" in tones
    assert "1.043 g rms" in panels[0].get_legend().get_texts()[0].get_text()


def test_it_draws_the_table_in_its_own_unit(figure):
    ax = figure.axes[0]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    table, fitted, shaped, tones = ax.get_lines()
    points = [[10, 0.015], [40, 0.015], [500, 0.00015]]  # MIL-STD-810G's break points
    np.testing.assert_allclose(table.get_xydata(), points)
    (band,) = ax.collections
    corners = band.get_paths()[0].vertices
    at_40 = corners[np.isclose(corners[:, 0], 40.0), 1]
    np.testing.assert_allclose(sorted(at_40), 0.015 * 10 ** np.array([-0.15, 0.15]))
    for line, error_db in ((fitted, 1.5), (shaped, 6.0), (tones, 0.5)):
        f, S = line.get_data()
        (k,) = np.flatnonzero(np.abs(f - 25.0) == np.abs(f - 25.0).min())
        assert abs(10 * np.log10(S[k] / 0.015)) < error_db
    low, high = ax.get_ylim()
    assert low < 0.00015 * 10**-0.15
    assert high > 0.015 * 10**0.15


def test_a_very_wide_band_can_be_read(tmp_path):
    file = tmp_path / "wide.toml"
    file.write_text("[wide]\npoints = [[0.5, 0.001], [2000, 0.001]]\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ftcfa.study.realised_spectrum.LENGTHS", 1)
        patch.setattr("ftcfa.study.realised_spectrum.PERIODS", 2)
        figure = vibration_figure([realise_standard(read_table(file)["wide"])])
    figure.draw_without_rendering()
    shown = [text.get_text() for text in figure.axes[0].get_xticklabels()]
    assert {"1", "10", "100", "1000"} <= set(shown)
    assert "500" not in shown


def test_record_is_enough_to_judge_by(record):
    truck, deck = record["standards"]
    assert truck["points"][0] == pytest.approx([10, 0.015])
    assert (truck["unverified"], deck["unverified"]) == (True, True)
    assert truck["nominal_g_rms"] == 1.04
    assert truck["band"] == [10.0, 500.0]
    assert truck["largest_step"] == pytest.approx(2.5e-4)  # eight steps of 500 Hz
    assert (truck["substeps"], deck["substeps"]) == (4, 1)
    assert truck["fit"]["within_tolerance"] is True
    assert truck["fit"]["sentence"].startswith("shaping filter of order 6: 1.059 g rms")
    assert truck["realised"]["shaped_noise"]["g_rms"] == pytest.approx(1.06, rel=0.1)
    assert truck["realised"]["random_phase"]["g_rms"] == pytest.approx(1.04, rel=0.02)
    assert record["units"]["g_rms"] == "g"
    assert set(record["versions"]) == {"python", "ftcfa", "numpy", "scipy", "matplotlib"}


@pytest.mark.parametrize("width", [80, 120])
def test_what_is_printed_of_a_standard(record, width):
    text = printed(print_realised, record, width)
    assert all(len(line) <= width for line in text.splitlines())
    words = " ".join(text.split())
    for expected in (
        "unverified in a primary source",
        "of [bold]no one[/bold] and",
        "1.043 g rms, 10 to 500 Hz",
        "shaping filter of order 6",
        "within the tolerance of 1.5 dB",
        "at most 0.25 ms: substeps=4 for a period of 1 ms",
    ):
        assert expected in words


@pytest.mark.parametrize("width", [80, 120])
def test_the_list_names_all_with_their_provenance(width):
    text = printed(print_catalogue, catalogue_record(standards()), width)
    assert all(len(line) <= width for line in text.splitlines())
    for name, one in standards().items():
        at = text.index(f"  {name} ")
        above = text[:at].split("\n\n")[-1]
        assert one.source in above
        assert one.verified in above
    for name, roughness in ROAD_CLASSES.items():
        assert f"  {name}  {1e6 * roughness:g}e-6 m^3" in text
    assert "unverified in the standard itself" in text
    assert "10 to 500 Hz" in text


def test_what_counts_as_unverified():
    assert unverified("unverified in a primary source; the integral matches")
    assert unverified("not stated")
    assert not unverified("seen in two public code bases citing the standard")
