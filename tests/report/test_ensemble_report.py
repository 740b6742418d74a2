"""An ensemble and a verification as files, figure and table: also with diverged paths."""

import io
import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread
from rich.console import Console
from scipy import stats

import ftcfa
from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    Constant,
    Sinusoid,
    Specification,
    Vibration,
    WhiteNoise,
    ensemble,
    load_arm,
    settling,
    verify,
)
from ftcfa.report.ensemble import ensemble_files, ensemble_record
from ftcfa.report.ensemble_figure import ensemble_figure
from ftcfa.report.ensemble_text import print_ensemble
from ftcfa.report.netcdf import netcdf
from ftcfa.report.verification import print_verification, verification_record

ARM = load_arm("double_pendulum")
PATHS, DURATION = 60, 0.7
REQUESTED = 100
TITLE = "a $ of $ [b]"


def shaken(controller, reference, intensity, **start):
    noise = Vibration(BaseAcceleration("xz"), WhiteNoise(intensity))
    return ClosedLoop(ARM, controller, reference, noise, **start)


class NoLaw:
    """No torque."""

    def init(self, measured, desired):
        return ()

    def step(self, state, measured, desired, period):
        q = measured.q
        return {"u": 0.0 * q}, state


SOUND = shaken(
    ftcfa.printed(FTCF(ARM)),
    Sinusoid((1.5, 1.0), (1.0, 2.0)),
    0.1,
    q0=(-0.1, 0.25),
    v0=(-0.3, 0.45),
)
DIVERGING = shaken(NoLaw(), Constant([0.0, 0.0]), 1e7)
"""Some of its paths diverge."""


@pytest.fixture(scope="module")
def sound():
    return ensemble(SOUND, PATHS, DURATION, seed=2, tolerance=0.052)


@pytest.fixture(scope="module")
def diverging():
    return ensemble(DIVERGING, PATHS, 0.3, seed=1)


@pytest.fixture(scope="module", params=["sound", "diverging"])
def either(request):
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def files(either):
    return ensemble_files(either, ensemble_record(either, REQUESTED), ARM.effort_limit, TITLE)


def printed(function, record, width):
    stream = io.StringIO()
    function(record, Console(file=stream, width=width, highlight=False))
    return stream.getvalue()


def test_files_are_the_dataset_the_record_and_the_figure(either, files):
    assert sorted(files) == ["ensemble.nc", "ensemble.png", "ensemble.svg", "summary.json"]
    assert json.loads(files["summary.json"]) == ensemble_record(either, REQUESTED)
    again = ensemble_files(either, ensemble_record(either, REQUESTED), ARM.effort_limit, TITLE)
    assert again == files


@pytest.mark.parametrize("engine", ["scipy", None])
def test_netcdf_reads_back_equal(either, files, tmp_path, engine):
    file = tmp_path / "e.nc"
    file.write_bytes(files["ensemble.nc"])
    with xr.open_dataset(file, engine=engine) as again:
        xr.testing.assert_identical(again, either)
        assert again["joint"].values.tolist() == ["shoulder", "elbow"]
        assert np.issubdtype(again["path"].dtype, np.integer)


@pytest.mark.parametrize("seed", [2**31 - 1, 2**31, 2**64 - 1])
def test_netcdf_keeps_every_seed(sound, tmp_path, seed):
    file = tmp_path / "e.nc"
    file.write_bytes(netcdf(sound.assign_attrs(seed=seed)))
    with xr.open_dataset(file, engine="scipy") as again:
        assert int(again.attrs["seed"]) == seed


def test_png_shows_something_and_clips_nothing(files):
    picture = imread(io.BytesIO(files["ensemble.png"]), format="png")[..., :3]
    assert 0.01 < np.mean(picture.min(axis=2) < 0.9) < 0.5
    for border in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert np.all(border == 1.0)


def words_of(svg):
    root = ElementTree.fromstring(svg)
    words = "".join("".join(e.itertext()) for e in root.iter() if e.tag.endswith("}text"))
    return "".join(words.split())


def test_the_figure_says_what_is_drawn(either, files):
    text = words_of(files["ensemble.svg"])
    diverged = either.attrs["diverged"]
    expected_note = f"{diverged} diverged;" if diverged else "all kept;"
    for expected in (
        "a $ of $ [b]",
        f"60 paths of seed {either.attrs['seed']},",
        expected_note,
        "[rad²]",
        "[rad]",
        "[N m]",
        "= 15 N m",
        "5 to 95 %",
        "25 to 75 %",
        "median",
        "share of paths",
        "time [s]",
        f"tolerance {either.attrs['tolerance']:g}",
        "95 % confidence at each single time",
    ):
        assert "".join(expected.split()) in text
    if diverged:
        assert "notdiverged" in text
        assert f"{diverged}divergedandneversettle" in text
    assert (f"{settling(either).censored}notby" in text) == (settling(either).censored > 0)


def test_the_figure_draws_the_data(sound):
    square, fan, torque, settle = ensemble_figure(sound, ARM.effort_limit, "t").axes
    assert (square.get_yscale(), fan.get_yscale()) == ("log", "log")
    np.testing.assert_allclose(square.get_lines()[0].get_ydata(), sound.ote_mean_square[0])
    low, high = square.get_ylim()
    assert low < sound.attrs["tolerance"] ** 2 < high
    np.testing.assert_allclose(fan.get_lines()[0].get_ydata(), sound.ote_quantile[0, 2])
    busiest = sound.u_mean.joint[np.argmax(sound.rms_torque.values.mean(axis=0))].item()
    assert torque.get_title(loc="left") == f"torque of {busiest}, quantiles as above"
    median = sound.u_quantile.sel(joint=busiest, quantile=0.5)[0]
    np.testing.assert_allclose(torque.get_lines()[0].get_ydata(), median)
    limits = {float(line.get_ydata()[0]) for line in torque.get_lines()[1:]}
    assert limits == {15.0, -15.0}
    time, share = settle.get_lines()[0].get_data()
    times = sound.settling_time.values
    for t, value in zip(time[:-1], share[:-1], strict=True):
        assert value == pytest.approx(np.mean(times <= t) if t > 0 else 0.0)


def test_the_mean_of_all_ends_where_the_first_path_diverges(diverging):
    square = ensemble_figure(diverging, ARM.effort_limit, "t").axes[0]
    others, everyone = (line.get_ydata() for line in square.get_lines()[:2])
    first = np.nanmin(diverging.diverged_at)
    assert np.all(np.isnan(everyone[diverging.time.values >= first]))
    assert np.all(np.isfinite(others[1:]))


def test_an_arm_without_limits_has_its_torque_drawn(sound):
    torque = ensemble_figure(sound, np.full(2, np.inf), "t").axes[2]
    assert len(torque.get_lines()) == 1


def test_one_path_alone_can_be_drawn_and_told():
    one = ensemble(SOUND, 1, 0.05)
    record = ensemble_record(one, 1)
    assert record["mean_square_error"]["low"] is None
    assert ensemble_files(one, record, ARM.effort_limit, "t")
    assert "1 of seed 0" in printed(print_ensemble, record, 80)


def test_record_against_scipy(sound):
    record = ensemble_record(sound, REQUESTED)
    assert (record["paths"], record["requested"], record["seed"]) == (PATHS, REQUESTED, 2)
    exact = stats.binomtest(0, PATHS).proportion_ci(method="exact")
    assert record["outcomes"]["diverged"]["count"] == 0
    assert record["outcomes"]["diverged"]["share"]["high"] == pytest.approx(exact.high)
    last = float(sound.ote_mean_square[0, -1])
    assert record["mean_square_error"]["estimate"] == last
    assert record["practical_settling"]["epsilon"] == pytest.approx(0.052**2)
    for row in record["metrics"]:
        values = sound[row["metric"]]
        values = values.sel(joint=row["joint"]) if "joint" in row else values
        x = np.sort(values.values)
        assert row["median"]["estimate"] == x[PATHS // 2 - 1]
        low, high = stats.binom.ppf([0.025, 0.975], PATHS, 0.5).astype(int)
        assert (row["median"]["low"], row["median"]["high"]) == (x[low - 1], x[high])
        assert row["largest"] == x[-1] == float(values.sel(path=row["path"]))
        assert row["without"] == 0
    assert [row["unit"] for row in record["metrics"][-3:]] == ["N m", "N m", "J"]


def test_record_with_diverged_paths(diverging):
    record = ensemble_record(diverging, PATHS)
    diverged = np.flatnonzero(np.isfinite(diverging.diverged_at.values))
    assert 0 < len(diverged) < PATHS
    assert record["outcomes"]["diverged"]["count"] == len(diverged)
    assert record["outcomes"]["diverged"]["first_paths"] == diverged[:10].tolist()
    assert record["mean_square_error"]["estimate"] is None
    others = diverging.ote_mean_square_not_diverged.values[0, -1]
    assert record["mean_square_error"]["not_diverged"]["estimate"] == others
    assert record["practical_settling"]["time"] is None
    energy = record["metrics"][-1]
    assert (energy["metric"], energy["without"]) == ("energy", len(diverged))
    assert energy["95 %"]["estimate"] is None  # diverged paths are the worst of all
    json.dumps(record, allow_nan=False)


@pytest.mark.parametrize("width", [80, 120])
def test_what_is_printed(either, width):
    record = ensemble_record(either, REQUESTED)
    text = printed(print_ensemble, record, width)
    assert all(len(line) <= width for line in text.splitlines())
    words = " ".join(text.split())
    diverged = record["outcomes"]["diverged"]
    for expected in (
        "interrupted, 100 were requested",
        "Definition 1 the 97.5 % upper bound of E|z1|^2",
        "with distribution-free 95 % intervals",
        "peak torque rate",
        "[N m/s]",
        "settling time 5 %: ",
    ):
        assert expected in words
    if diverged["count"]:
        assert f"paths {', '.join(map(str, diverged['first_paths']))}, ..." in words
        assert "later than 0.3 s" in words
        assert "not diverged" in words


@pytest.fixture(scope="module")
def verifications():
    def ask(**values):
        return verify(SOUND, Specification(**{"error": 0.05, "within": 0.6, **values}), DURATION)

    return {
        "yes": ask(within=0.65),
        "no": ask(within=0.3, effort=[15.0, 15.0]),
        "undecided": ask(within=0.56, share=0.5, budget=20),
    }


@pytest.mark.parametrize("answer", ["yes", "no", "undecided"])
def test_a_verification_as_a_record_and_in_words(verifications, answer):
    verification = verifications[answer]
    record = verification_record(verification, "dir/e.toml", DURATION)
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert (record["answer"], verification.answer) == (answer, answer)
    text = printed(print_verification, record, 80)
    assert text.splitlines()[0] == answer
    assert f"{verification.verdict.successes} of {verification.verdict.trials} paths" in text
    assert ("worst paths" in text) == bool(verification.worst)
    if verification.worst:
        worst = verification.worst[0]
        assert f"path {worst.path}: {worst.reason}" in text
        replay = (
            f"ftcfa.simulate(ftcfa.load_experiment('dir/e.toml').loop, {DURATION}, seed=0, "
            f'path={worst.path}, signals="all")'
        )
        assert replay in text.splitlines()
    assert ("Clopper and Pearson" in text) == (answer == "undecided")


def test_one_path_has_no_intervals(capsys):
    arm = ftcfa.load_arm("double_pendulum")
    loop = ftcfa.ClosedLoop(arm, ftcfa.FTCF(arm, compensation="bias"), ftcfa.Sinusoid([0.3, 0.2]))
    record = ensemble_record(ftcfa.ensemble(loop, 1, 1.0), 1)
    print_ensemble(record, Console(width=80))
    text = capsys.readouterr().out
    assert "kept" in text
    assert "settles" in text
    for word in ("share of", "quantile", "interval", " to -", "95 %"):
        assert word not in text
    shown = next(line for line in text.splitlines() if line.startswith("rms tool error"))
    metric = next(row for row in record["metrics"] if row["metric"] == "late_rms_tool_error")
    assert f"{metric['median']['estimate']:.4g}" in shown


def test_the_table_of_joints_is_that_of_the_dataset():
    arm = ftcfa.load_arm("double_pendulum", effort_limit=[15.0, 4.0])
    loop = ftcfa.ClosedLoop(
        arm, ftcfa.FTCF(arm, compensation="bias"), ftcfa.Sinusoid([1.5, 1.0], 2.0),
        hardware=ftcfa.Hardware(actuators=ftcfa.Actuators(rate_limit=[500.0, 200.0])),
        uncertainty=ftcfa.Uncertainty(mass=0.1),
    )  # fmt: skip
    runs = ftcfa.ensemble(loop, 9, 1.0)
    assert runs.torque_rate_limit.values.tolist() == [500.0, 200.0]
    joints = ensemble_record(runs, 9)["joints"]
    for k, it in enumerate(joints):
        assert it["effort_limit"] == [15.0, 4.0][k]
        assert it["peak_torque"] == runs.peak_torque.values[:, k].max()
        assert it["late_rms_joint_error"] == np.median(runs.late_rms_joint_error.values[:, k])
        assert it["rate_limited"] == np.median(runs.rate_limited.values[:, k])
