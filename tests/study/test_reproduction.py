"""The paper's study: its cases and its numbers."""

import itertools
import json

import numpy as np
import pytest
import xarray as xr

from ftcfa import FTCF, Arm, PaperPendulum, PaperPendulumInput
from ftcfa.report.reproduction import UNITS, summary_row
from ftcfa.statistics.settling import below_for_good
from ftcfa.study.reproduction import (
    ASYMPTOTIC,
    BAND,
    CASES,
    EXPLICIT,
    FINITE_TIME,
    QUICK_CASES,
    Case,
    closed_loop,
    run_case,
)

PROTOTYPE = {FINITE_TIME: 0.0030, ASYMPTOTIC: 0.038}
"""rms OTE of an independent prototype of the equations, mean of 20 seeds [rad]."""
AGREEMENT = 0.10
"""One path against that mean; the prototype's own seeds scatter by a few per cent."""
SAME_FINDING = 0.4
"""Corrections, conventions and filters move rms OTE by up to a third; kappa by a factor of ten."""
LIMIT = 15.0
SHORT = 0.05
"""A path of 50 steps [s]."""
R1 = 750.0
"""The paper's filter gain."""


@pytest.fixture(scope="module")
def paths() -> dict[Case, xr.Dataset]:
    """The whole study, 20 s a case."""
    return {case: run_case(case) for case in CASES}


@pytest.mark.parametrize("case", [FINITE_TIME, ASYMPTOTIC], ids=["finite-time", "asymptotic"])
def test_the_papers_result(paths: dict[Case, xr.Dataset], case: Case) -> None:
    row = summary_row(case, paths[case])
    assert row["rms_ote"] == pytest.approx(PROTOTYPE[case], rel=AGREEMENT)
    assert row["diverged_at"] is None
    assert row["largest_u"] <= LIMIT


def test_finite_time_settles_and_asymptotic_does_not(paths: dict[Case, xr.Dataset]) -> None:
    finite, asymptotic = (summary_row(c, paths[c]) for c in (FINITE_TIME, ASYMPTOTIC))
    assert 0.5 <= finite["settled_after"] <= 0.6
    assert asymptotic["settled_after"] is None or asymptotic["settled_after"] > 17.0


def test_torque_never_leaves_its_limits(paths: dict[Case, xr.Dataset]) -> None:
    for path in paths.values():
        assert float(abs(path["u"]).max()) <= LIMIT
        assert float(abs(path["u_command"]).max()) > LIMIT  # so the limit was needed


def test_the_finding_survives_corrections_and_conventions(paths: dict[Case, xr.Dataset]) -> None:
    for case, path in paths.items():
        row = summary_row(case, path)
        assert row["diverged_at"] is None
        expected = PROTOTYPE[FINITE_TIME] if case.kappa < 1 else PROTOTYPE[ASYMPTOTIC]
        assert row["rms_ote"] == pytest.approx(expected, rel=SAME_FINDING)


def test_explicit_filter_needs_a_tenth_of_the_period(paths: dict[Case, xr.Dataset]) -> None:
    fine = Case(filter="explicit", period=1e-4)
    rows = {case: summary_row(case, paths[case]) for case in (FINITE_TIME, EXPLICIT, fine)}
    share = {case: row["saturated_share"] for case, row in rows.items()}
    assert share[EXPLICIT] > 5 * share[FINITE_TIME]
    assert share[fine] < 2 * share[FINITE_TIME]
    error = {case: row["largest_filter_error"] for case, row in rows.items()}
    assert error[FINITE_TIME] < error[fine] < 0.05 * error[EXPLICIT]


def test_explicit_filter_limit_cycles(paths: dict[Case, xr.Dataset]) -> None:
    amplitude = (R1 * EXPLICIT.period / 2) ** 2
    late = {case: paths[case].sel(time=slice(10, None)) for case in (FINITE_TIME, EXPLICIT)}
    error = {case: np.abs(path["abar"] - path["alpha"]).values for case, path in late.items()}
    assert np.median(error[EXPLICIT]) == pytest.approx(amplitude, rel=0.25)
    assert np.max(error[FINITE_TIME]) < 0.01 * amplitude


def test_the_cases_are_those_of_the_study() -> None:
    assert len(set(CASES)) == len(CASES)
    for plant, noise, kappa in itertools.product(
        ("corrected", "as printed"), ("psd", "amplitude"), (0.6, 1.0)
    ):
        assert Case(plant, noise, kappa) in CASES
    assert {FINITE_TIME, ASYMPTOTIC, EXPLICIT} <= set(QUICK_CASES) <= set(CASES)
    assert Case(filter="explicit", period=1e-4) in CASES


@pytest.mark.parametrize(("noise", "amplitude"), [("psd", np.sqrt(0.1)), ("amplitude", 0.1)])
def test_noise_convention(noise, amplitude) -> None:
    loop = closed_loop(Case(noise=noise))
    np.testing.assert_allclose(loop.process.sigma, amplitude * np.eye(2), atol=1e-12)


def test_only_the_plant_is_as_printed() -> None:
    corrected, printed = closed_loop(Case()), closed_loop(Case(plant="as printed"))
    assert isinstance(corrected.arm, Arm)
    assert isinstance(printed.arm, PaperPendulum)
    assert printed.arm.as_printed
    assert isinstance(printed.vibration.input, PaperPendulumInput)
    for loop in (corrected, printed):
        assert isinstance(loop.controller, FTCF)
        assert isinstance(loop.controller.nominal, Arm)
        straight = np.array([np.pi / 2, 0.0])
        gravity = loop.controller.nominal.potential_force(straight)
        np.testing.assert_allclose(gravity, [1.4 * 9.8 * 0.8, 0.0], atol=1e-12)


def test_initial_state_and_reference() -> None:
    path = run_case(FINITE_TIME, SHORT)
    np.testing.assert_allclose(path["q"][0], [-0.1, 0.25])
    np.testing.assert_allclose(path["v"][0], [-0.3, 0.45])
    t = path["time"].values
    np.testing.assert_allclose(path["q_d"], np.stack([1.5 * np.sin(t), np.sin(2 * t)], axis=1))


def synthetic(ote: list[float], command: list[float], diverged_at: float = np.nan) -> xr.Dataset:
    """A path of one joint with given errors and commanded torques; limit 15, filter error 0.1."""
    time = np.arange(len(ote)) * 0.1
    column = np.array(command)[:, None]
    return xr.Dataset(
        {
            "ote": ("time", ote),
            "u_command": (("time", "joint"), column),
            "u": (("time", "joint"), np.clip(column, -LIMIT, LIMIT)),
            "alpha": (("time", "joint"), 0.0 * column),
            "abar": (("time", "joint"), 0.0 * column - 0.1),
            "diverged_at": ((), diverged_at),
        },
        coords={"time": time},
    )


def test_summary_of_a_known_path() -> None:
    row = summary_row(FINITE_TIME, synthetic([1.0, 0.04, 0.03, 0.04, 0.0], [20, -16, 3, 15, 0]))
    assert row["rms_ote"] == pytest.approx(np.sqrt((0.03**2 + 0.04**2) / 3))
    assert row["settled_after"] == pytest.approx(0.1)
    assert row["largest_u"] == LIMIT
    assert row["saturated_share"] == pytest.approx(2 / 5)
    assert row["largest_filter_error"] == pytest.approx(0.1)
    assert row["diverged_at"] is None
    assert set(UNITS) <= set(row)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kept", [1, 3])
def test_a_diverged_path_is_not_averaged_away(kept) -> None:
    nan = [np.nan] * (4 - kept)
    row = summary_row(FINITE_TIME, synthetic([0.01] * kept + nan, [30.0] * kept + nan, 0.1))
    assert row["rms_ote"] is None
    assert row["largest_filter_error"] is None
    assert row["settled_after"] is None
    assert row["diverged_at"] == 0.1
    assert row["largest_u"] == LIMIT
    assert row["saturated_share"] == 1.0
    json.dumps(row, allow_nan=False)


@pytest.mark.parametrize(
    ("ote", "expected"),
    [
        ([0.01, 0.02, 0.03], 0.0),
        ([0.10, 0.02, 0.03], 1.0),
        ([0.01, BAND, 0.03], 2.0),
        ([0.01, 0.02, 0.10], np.nan),
        ([0.01, np.nan, np.nan], np.nan),
    ],
)
def test_settled_after(ote, expected) -> None:
    np.testing.assert_equal(below_for_good(np.arange(3.0), np.array(ote), BAND), expected)
