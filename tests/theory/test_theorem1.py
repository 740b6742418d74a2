"""Theorem 1 in numbers: the repaired constants, their conditions, and what `ftcfa bounds` says."""

import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from scipy.integrate import quad

from ftcfa import (
    FTCF,
    BaseAcceleration,
    ClosedLoop,
    ComputedTorque,
    Constant,
    Experiment,
    ExplicitFilter,
    Gains,
    PaperPendulum,
    ParameterError,
    SecondOrderFilter,
    ShapedNoise,
    Sinusoid,
    Vibration,
    bounds,
    load_arm,
    printed,
)
from ftcfa.cli import main
from ftcfa.report.bounds import bounds_record, print_bounds
from ftcfa.report.bounds_figure import bounds_figure
from ftcfa.report.figures import rendered
from ftcfa.statistics.moments import Moments
from ftcfa.study.reproduction import FINITE_TIME, closed_loop
from ftcfa.theory.bounds import saturation_gap
from ftcfa.theory.demonstrations import LINK_EPS, hanging_link, hanging_pendulum
from ftcfa.theory.gain_conditions import compensation_coefficient, default_weight
from ftcfa.theory.premises import theorem_paths

CONFIDENCE = 1 - 1e-6
SEARCH = 1e-6
"""Relative; the bounds of the mass matrix are found by a search."""
PRINTED = 2e-3
"""Relative; of numbers given to three or four digits."""

positive = st.floats(0.01, 100.0)


@pytest.fixture(scope="module")
def study():
    return bounds(closed_loop(FINITE_TIME))


@pytest.fixture(scope="module")
def link():
    return bounds(hanging_link(), eps=LINK_EPS)


def still(gains=None, robot="double_pendulum", **parts):
    """A loop at rest on its reference."""
    arm = load_arm(robot)
    return ClosedLoop(arm, printed(FTCF(arm, gains or Gains(), **parts)), Constant(arm.home))


# The paper's study


def test_the_papers_study(study):
    assert study.Delta == pytest.approx(4.353, rel=PRINTED)
    assert study.Gamma == pytest.approx(4.51e4, rel=PRINTED)
    assert study.ultimate_error == pytest.approx(37.6, rel=PRINTED)
    assert study.error_without_largest_term == pytest.approx(2.98, rel=PRINTED)
    assert (study.weight, study.p, study.n) == (1.0, 0.9, 2)
    assert study.applies
    assert study.first_entry == 0.0


def test_its_terms_in_closed_form(study):
    """Mmin is the pendulum's least eigenvalue, where the links are in line."""
    m1, m2, l1, l2 = 0.6, 0.8, 0.8, 1.2
    a, b, c = (m1 + m2) * l1**2, m2 * l2**2, m2 * l1 * l2
    Mmin = (a + b - np.hypot(a - b, 2 * c)) / 2
    assert study.Mmin == pytest.approx(Mmin, rel=SEARCH)
    assert study.Mmax == pytest.approx(a + b - Mmin, rel=SEARCH)
    gap = (1 - np.tanh(1)) * 15
    assert study.Gamma_terms == {
        "saturation": pytest.approx((2 * gap**2) ** 2 / 4 / Mmin**4, rel=10 * SEARCH),
        "tau": 1.0,
        "network error": 0.0,
        "filter error": 0.0,
        "network weights": 0.0,
        "fractional power": pytest.approx(100 * 0.1 * 0.9**9),
    }
    z1, z2 = np.array([-0.1, 0.25]), np.array([-0.3, 0.45]) - [1.5, 2.0]
    v2 = z2 + 7.5 * np.sign(z1) * np.abs(z1) ** 0.6 + 2.25 * z1  # abar(0) = alpha(0)
    start = study.V0
    assert start == pytest.approx(((z1 @ z1) ** 2 + (v2 @ v2) ** 2) / 4)


def test_what_it_says(study):
    assert "|z1| <= 37.6 rad where V <= Vinf" in study.verdict
    assert "says nothing about this arm: no two of its postures are more than" in study.verdict
    assert "is the saturation term, 99.99 % of it; without it the bound is 2.98" in study.verdict
    assert "V <= Vinf from the start" in study.verdict
    assert not study.informative


def test_premises_cost_what_the_theorem_says():
    loop = closed_loop(FINITE_TIME)
    base = bounds(loop).Gamma
    assert bounds(loop, eps=3.0).Gamma - base == pytest.approx(9.0)
    assert bounds(loop, pi1=2.0, weight=1.5).Gamma - base == pytest.approx(1.5 * 16 / 4)
    assert bounds(loop, theta=4.0).Gamma - base == pytest.approx(100 * 16 / 2)
    farther = bounds(loop, theta=4.0).V0 - bounds(loop).V0
    assert farther == pytest.approx(16 / 2)


def test_remark_6_as_printed_fails():
    """A small lambda raises Gamma; and 1 - tau, for 1 - sigma, would be zero here."""
    small, large = (bounds(still(Gains(lambda_=x)), theta=1.0).Gamma for x in (0.1, 10.0))
    assert small > large + 400
    assert bounds(still(Gains(tau=1.0))).Vinf > 0


# Any number of joints


@pytest.mark.parametrize(("n", "weight"), [(1, 1.0), (2, 1.0), (3, 1.0), (7, 2.56)])
def test_weight(n, weight):
    assert default_weight(n, Gains()) == pytest.approx(weight, rel=PRINTED)


def test_weight_makes_way_for_a_small_k1():
    result = bounds(still(Gains(k1=1.8)))
    assert result.weight == pytest.approx(1.5)
    assert result.applies
    assert not bounds(still(Gains(k1=1.8)), weight=1.0).applies


@pytest.mark.parametrize("weight", [0.5, 1.0, 2.56, 40.0])
def test_tracking_error_is_the_largest_within_the_level(study, weight):
    """|v1| + |s1| over |v1|^4 + w_s |s1|^4 = 4 Vinf, by brute force."""
    result = replace(
        study, weight=weight, law=printed(FTCF(study.law.nominal, Gains(k1=9.0, k2=9.0)))
    )
    v1 = np.linspace(0, (4 * result.Vinf) ** 0.25, 100_001)
    s1 = ((4 * result.Vinf - v1**4) / weight) ** 0.25
    assert result.ultimate_error == pytest.approx(np.max(v1 + s1), rel=1e-6)


@given(weight=st.floats(0.7, 50.0), s1=positive)
def test_terms_of_Delta_are_those_of_the_weight(study, weight, s1):
    """c_i s |s_i|^(3+kappa) of (28) as a multiple of (w_s |s_i|^4/4)^p."""
    result = replace(study, weight=weight)
    for name, c in (("(4/w_s)^p c1 s", 7.5), ("(4/w_s)^p c2 s", 25.0)):
        part = result.Delta_terms[name] * (weight * s1**4 / 4) ** 0.9
        assert part == pytest.approx(c * result.s * s1**3.6)


@given(weight=st.floats(0.3, 50.0))
def test_required_gains_are_where_nothing_is_left(study, weight):
    """w_s (k_1 - 3/2) = k_1/4 and w_s (k_2 - 1/4) = k_2/4."""
    needed = {each.name: each.required for each in replace(study, weight=weight).conditions}
    for name, least in (("k1", 1.5), ("k2", 0.25)):
        assert weight * (needed[name] - least) == pytest.approx(needed[name] / 4)


def test_panda():
    """Seven joints: at w_s = 1 nothing is left of the compensation, at 2.56 the theorem applies."""
    result = bounds(still(robot="panda"))
    assert result.applies
    assert result.Delta == pytest.approx(4**0.9 * 7.5 / 6)
    light = replace(result, weight=1.0)
    assert not light.applies
    assert compensation_coefficient(7, 0.6, 1.0) < 0
    assert (light.Vinf, light.ultimate_error, light.first_entry) == (np.inf,) * 3
    assert light.time_average(1.0) == np.inf
    assert light.verdict.startswith("Theorem 1 does not apply: s = -0.72")


@pytest.mark.parametrize("weak", [{"k1": 1.4}, {"k2": 0.2}])
def test_gains_that_no_weight_helps(weak):
    result = bounds(still(Gains(**weak)))
    (name,) = weak
    assert not result.applies
    assert [each.name for each in result.conditions if not each.holds] == [name]
    assert f"{name} = {weak[name]:g} is not >= " in result.verdict


def test_conditions_say_what_they_replace(study):
    replaced = {each.name: each.replaces for each in study.conditions}
    assert list(replaced) == ["k1", "k2", "s", "r1"]
    assert "(28)" in replaced["k1"]
    assert "(17) lacks the factor" in replaced["s"]


def test_filter_gains():
    slow = bounds(still(filter=ExplicitFilter(r1=10.0, r2=180.0)))
    r1 = slow.conditions[-1]
    assert (r1.name, r1.holds) == ("r1", False)
    assert r1.required == pytest.approx(1.5 * np.sqrt(180 / 1.1))
    assert slow.applies  # pi1 is the user's to supply
    other = bounds(still(filter=SecondOrderFilter()))
    assert other.filter_bound is None
    assert [each.name for each in other.conditions] == ["k1", "k2", "s"]


def test_kappa_one_is_the_limit():
    near, limit = (bounds(hanging(kappa), theta=1e-9) for kappa in (1 - 1e-7, 1.0))
    for name in ("Delta", "Gamma", "Vinf", "ultimate_error", "first_entry"):
        assert getattr(near, name) == pytest.approx(getattr(limit, name), rel=1e-4)


def hanging(kappa):
    """The hanging link under another fractional power."""
    loop = hanging_link()
    return replace(loop, controller=with_kappa(loop.controller, kappa))


def with_kappa(law, kappa):
    return replace(law, gains=replace(law.gains, kappa=kappa))


@settings(max_examples=30)
@given(pi1=st.floats(0, 5), weight=st.floats(1.0, 1e3))
def test_no_weight_is_better_than_the_best(study, pi1, weight):
    result = replace(study, pi1=pi1)
    _, error = result.best_weight()
    assert error <= replace(result, weight=weight).ultimate_error * 1.01  # a grid


def test_best_weight_is_finite_where_the_filter_errs(study):
    assert study.best_weight()[0] == pytest.approx(1e6)
    without_saturation = replace(study, etabar=np.zeros(2), pi1=1.0)
    assert 1.0 < without_saturation.best_weight()[0] < 100.0


@given(actual=positive, nominal=positive)
def test_saturation_gap_is_the_largest(actual, nominal):
    a, b = np.array([actual]), np.array([nominal])
    (gap,) = saturation_gap(a, b)
    u = np.concatenate([np.linspace(0, 5 * max(actual, nominal), 5001), [actual, 1e6]])
    largest = np.max(np.abs(np.clip(u, -actual, actual) - nominal * np.tanh(u / nominal)))
    assert gap == pytest.approx(largest, rel=1e-9)


# The first entry


@settings(max_examples=50)
@given(sigma=st.floats(0.05, 0.95), far=st.floats(1.01, 1e4), kappa=st.floats(0.1, 1.0))
def test_first_entry_of_the_fastest_fall_allowed(link, sigma, far, kappa):
    """V' = -Delta V^p + Gamma enters at the integral of dV/(Delta V^p - Gamma), by quadrature."""
    result = replace(link, law=with_kappa(link.law, kappa), sigma=sigma)
    result = replace(result, V0=far * result.Vinf)
    exact, _ = quad(
        lambda x: np.exp(x) / (result.Delta * np.exp(x) ** result.p - result.Gamma),
        np.log(result.Vinf),
        np.log(result.V0),
    )
    assert exact <= result.first_entry * (1 + 1e-9)
    # with Gamma = sigma Delta V^p left over at Vinf, no more than 1/sigma too long
    assert result.first_entry * sigma <= exact * (1 + 1e-9)


@pytest.mark.parametrize(
    ("loop", "eps", "times"),
    [(hanging_link(), LINK_EPS, 20.0), (hanging_pendulum(), 0.0, 100.0)],
    ids=["link", "pendulum"],
)
def test_first_entry_where_the_bound_says_something(loop, eps, times):
    """V0 > Vinf, all premises hold until the first entry, and E[first entry] is within the bound.

    How far within is the finding: the bound is 42 times too long for the link, 166 times for the
    pendulum.
    """
    result = bounds(loop, eps=eps, pi1=1e-3)
    assert result.applies
    assert result.informative
    ratio = result.V0 / result.Vinf
    assert ratio > 1.2
    assert "V first falls to Vinf within" in result.verdict
    paths = theorem_paths(loop, result, 256, 0.25)
    assert np.all(paths.premises_hold)
    entry = paths.entry
    assert np.all(entry > 0)
    estimate = Moments.of(entry).skewness_corrected(CONFIDENCE)
    assert estimate.high < result.first_entry / times


def test_premises_that_are_too_small_do_not_hold(study, link):
    paths = theorem_paths(hanging_link(), link, 16, 0.2)
    assert not np.any(paths.premises_hold)  # pi1 = 0
    supplied = replace(study, etabar=np.zeros(2), eps=1.0, pi1=1.0)
    pendulum = theorem_paths(closed_loop(FINITE_TIME), supplied, 2, 0.1)
    assert np.all(pendulum.filter_error < 1.0)
    assert not np.any(pendulum.premises_hold)  # eps = 1


def test_time_average(study):
    """E V^p over time, by the paths, against Gamma/Delta + V0/(Delta t)."""
    paths = theorem_paths(closed_loop(FINITE_TIME), study, 8, 1.0)
    measured = np.mean(paths.values.V**study.p)
    assert measured < study.time_average(1.0)
    assert study.time_average(1.0) == pytest.approx((study.Gamma + study.V0) / study.Delta)


# Refused arguments


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"theta": -1.0}, "bounds theta: -1.0, expected a number >= 0"),
        ({"eps": np.nan}, "bounds eps: nan"),
        ({"pi1": np.inf}, "bounds pi1: inf"),
        ({"sigma": 1.0}, "bounds sigma: 1.0, expected a number between 0 and 1"),
        ({"weight": 0.25}, "bounds weight: 0.25, expected a number > 1/4"),
    ],
)
def test_numbers_out_of_range(options, said):
    with pytest.raises(ParameterError, match=said):
        bounds(still(), **options)


def test_loops_that_theorem_1_does_not_cover():
    arm = load_arm("double_pendulum")
    rest = (Constant(arm.home),)
    with pytest.raises(ParameterError, match="controller: a ComputedTorque, expected an FTCF"):
        bounds(ClosedLoop(arm, ComputedTorque(arm), *rest))
    with pytest.raises(ParameterError, match="controller adaptation: off, expected on"):
        bounds(ClosedLoop(arm, FTCF(arm, adaptation=False), *rest))
    for gap in ("bounded", "none"):
        law = FTCF(arm, anti_saturation=gap)
        with pytest.raises(ParameterError, match=f"anti_saturation: '{gap}', expected 'paper'"):
            bounds(ClosedLoop(arm, law, *rest))
    with pytest.raises(ParameterError, match="nominal arm: a PaperPendulum, expected an Arm"):
        bounds(ClosedLoop(PaperPendulum(), printed(FTCF(PaperPendulum())), Sinusoid([0.0, 0.0])))
    noise = ShapedNoise.from_psd(*["mil_std_810g_highway_truck_vertical"] * 2)
    shaken = Vibration(BaseAcceleration("xz"), noise)
    with pytest.raises(ParameterError, match="vibration: ShapedNoise through BaseAcceleration"):
        bounds(ClosedLoop(arm, printed(FTCF(arm)), *rest, shaken, substeps=4))


# The command


def call(*words):
    with pytest.raises(SystemExit) as exit_:
        main(words)
    return int(exit_.value.code or 0)


def test_command_gives_the_papers_study(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert call("bounds") == 0
    shown = capsys.readouterr()
    words = ("37.6 rad", "says nothing", "4.51e+04", "4.353", "(28)", "E[first entry]")
    assert all(word in shown.out for word in words)
    assert "…" not in shown.out
    assert shown.err == ""


def test_command_json_is_one_object(capsys):
    assert call("bounds", "--eps", "2", "--pi1", "0.5", "--sigma", "0.25", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert record["supplied"] == {"theta": 0.0, "eps": 2.0, "pi1": 0.5, "sigma": 0.25}
    assert record["Gamma_terms"]["network error"] == 4.0
    measured = record["measured"]
    assert 0.002 < measured["rms_error"] < 0.004  # EQUATIONS.md, section 4
    assert measured["eps"] > 100  # theta = 0 is not true there
    assert measured["error_if_supplied"] > record["ultimate_error"]


def test_command_reads_an_experiment(capsys, tmp_path):
    file = tmp_path / "link.toml"
    Experiment(hanging_link(), 1.0).save(file)
    assert call("bounds", str(file), "--eps", str(LINK_EPS), "--pi1", "1e-3", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert record["informative"]
    assert record["measured"]["premises_hold"] == 1.0
    assert 0 < record["measured"]["first_entry"] < record["first_entry"]
    assert call("bounds", str(tmp_path / "none.toml")) == 2


def test_record_of_a_loop_that_the_theorem_does_not_cover():
    loop = replace(hanging_link(), vibration=None)
    result = bounds(loop, weight=0.3)
    assert not result.applies
    record = bounds_record(result, theorem_paths(loop, result, 2, 0.1))
    assert record["ultimate_error"] is None
    assert record["first_entry"] is None
    stream = io.StringIO()
    print_bounds(record, Console(file=stream, width=80))
    assert "does not apply" in stream.getvalue()
    json.dumps(record, allow_nan=False)


def test_figure():
    loop = hanging_link()
    paths = theorem_paths(loop, bounds(loop, eps=LINK_EPS), 8, 0.2)
    figure = bounds_figure(paths, paths, "title", ["a", "b", "c"])
    assert [ax.get_title() or ax.get_title("left") for ax in figure.axes] == ["a", "b", "c"]
    labels = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert any(text.startswith("promised: ") for text in labels)
    assert rendered(figure)["png"].startswith(b"\x89PNG")


@pytest.mark.slow
def test_script(tmp_path):
    script = Path(__file__).parents[2] / "scripts" / "generator.py"
    words = [sys.executable, "-W", "error", script, "--quick", "--out", tmp_path]
    done = subprocess.run(
        words, capture_output=True, text=True, env={**os.environ, "COLUMNS": "80"}
    )
    assert done.returncode == 0, done.stderr
    assert "Gamma = 4.51e+04" in done.stdout
    files = sorted(file.name for file in tmp_path.iterdir())
    assert files == ["generator.json", "generator.png"]
