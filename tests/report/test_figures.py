"""The figures: what they draw, that they can be read as PNG and as SVG, and honest edges."""

import io
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.image import imread

from ftcfa.report.figures import filters, overall_error, rendered, torque, tracking
from ftcfa.report.reproduction import reproduction_figures
from ftcfa.study.reproduction import QUICK_CASES, Case, run_case

DURATION = 0.2
EXPECTED_TEXT = {
    "figure-1-1": ["position against reference", "shoulder [rad]", "elbow [rad]", "desired q"],
    "figure-1-2": ["torque within its limits", "u* = 15 N m", "elbow", "[N m]", "corrected plant"],
    "figure-2": ["overall tracking error", "κ = 0.6", "κ = 1", "0.05 rad", "OTE", "[rad]"],
    "figure-filter": ["command filter", "explicit", "implicit", "[rad/s]", "50 ms of it"],
}


@pytest.fixture(scope="module")
def paths() -> dict[Case, xr.Dataset]:
    return {case: run_case(case, DURATION) for case in QUICK_CASES}


@pytest.fixture(scope="module")
def figures(paths) -> dict[str, Figure]:
    return reproduction_figures(paths)


@pytest.fixture(scope="module")
def files(figures) -> dict[str, dict[str, bytes]]:
    return {name: rendered(figure) for name, figure in figures.items()}


@pytest.mark.parametrize("name", EXPECTED_TEXT)
def test_png_shows_something_and_clips_nothing(files, name) -> None:
    picture = imread(io.BytesIO(files[name]["png"]), format="png")[..., :3]
    height, width = picture.shape[:2]
    assert width > 1000
    assert height > 500
    assert 0.01 < np.mean(picture.min(axis=2) < 0.9) < 0.5  # ink, but not all ink
    for border in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert np.all(border == 1.0)


@pytest.mark.parametrize("name", EXPECTED_TEXT)
def test_svg_holds_its_words_as_text(files, name) -> None:
    root = ElementTree.fromstring(files[name]["svg"])
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    words = "".join("".join(e.itertext()) for e in root.iter() if e.tag.endswith("}text"))
    text = "".join(words.split())  # formulas are laid out letter by letter
    for expected in [*EXPECTED_TEXT[name], "time [s]"]:
        assert "".join(expected.split()) in text


def test_same_figure_same_bytes(paths, files) -> None:
    assert rendered(reproduction_figures(paths)["figure-1-2"]) == files["figure-1-2"]


def test_tracking_draws_the_data(paths, figures) -> None:
    path = paths[QUICK_CASES[0]]
    for row, joint in enumerate(("shoulder", "elbow")):
        desired, measured = figures["figure-1-1"].axes[2 * row].get_lines()
        np.testing.assert_array_equal(desired.get_ydata(), path["q_d"].sel(joint=joint))
        np.testing.assert_array_equal(measured.get_ydata(), path["q"].sel(joint=joint))


def test_torque_stays_between_the_drawn_limits(figures) -> None:
    for ax in figures["figure-1-2"].axes:
        torque_line, low, high = ax.get_lines()
        levels = sorted(line.get_ydata()[0] for line in (low, high))
        assert levels == [-15.0, 15.0]
        assert np.max(np.abs(torque_line.get_ydata())) <= 15.0
        bottom, top = ax.get_ylim()
        assert bottom < -15.0
        assert top > 15.0


def test_overall_error_has_a_linear_and_a_log_axis(figures) -> None:
    linear, log = figures["figure-2"].axes
    assert (linear.get_yscale(), log.get_yscale()) == ("linear", "log")
    assert linear.get_ylim()[0] == 0.0


@pytest.mark.filterwarnings("error")
def test_a_diverged_path_can_be_drawn(paths) -> None:
    path = paths[QUICK_CASES[0]]
    diverged = path.where(path["time"] <= 0.05)
    for figure in (
        tracking(diverged, "title", "note"),
        torque(diverged, np.array([15.0, 15.0]), "title", "note"),
        overall_error({"diverged": diverged, "whole": path}, 0.05, "title", "note"),
        filters({"diverged": diverged, "whole": path}, "elbow", 15.0, "title", "note"),
    ):
        figure.draw_without_rendering()


def test_prismatic_joints_are_in_metres(paths) -> None:
    path = paths[QUICK_CASES[0]].assign_coords(
        joint=["slide", "turn"], joint_type=("joint", ["prismatic", "revolute"])
    )
    assert tracking(path, "", "").axes[0].get_ylabel() == "slide [m]"
    assert tracking(path, "", "").axes[2].get_ylabel() == "turn [rad]"
    assert torque(path, np.ones(2), "", "").axes[0].get_ylabel() == "slide $u$ [N]"


def test_no_window_and_no_global_state() -> None:
    code = (
        "import sys, ftcfa.report.reproduction;"
        "print('matplotlib.pyplot' in sys.modules, 'matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]
