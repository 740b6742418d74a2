"""summary.json and the table of `ftcfa reproduce`."""

import io
import json

import numpy as np
import pytest
from rich.console import Console

from ftcfa.report.reproduction import FIGURES, print_summary, reproduction_files, summary_record
from ftcfa.study.reproduction import CASES, QUICK_CASES, run_case

DURATION = 0.1


@pytest.fixture(scope="module")
def paths():
    return {case: run_case(case, DURATION) for case in QUICK_CASES}


def table(record, width) -> str:
    stream = io.StringIO()
    print_summary(record, Console(file=stream, width=width))
    return stream.getvalue()


def test_record_is_enough_to_run_again(paths) -> None:
    record = summary_record(paths, DURATION, quick=True)
    assert record["duration"] == DURATION
    assert record["seed"] == 0
    assert set(record["versions"]) == {"python", "ftcfa", "numpy", "pin", "matplotlib"}
    assert [row["kappa"] for row in record["cases"]] == [case.kappa for case in QUICK_CASES]
    assert record["units"]["rms_ote"] == "rad"


def test_files_are_figures_and_the_record(paths) -> None:
    record = summary_record(paths, DURATION, quick=True)
    steps = []
    files = reproduction_files(paths, record, lambda: steps.append(None))
    assert sorted(files) == sorted(
        [
            *(f"figure-{name}.{suffix}" for name in ("1-1", "1-2", "2", "filter")
              for suffix in ("png", "svg")),
            "summary.json",
        ]
    )  # fmt: skip
    assert len(steps) == FIGURES == 4
    assert json.loads(files["summary.json"]) == record


@pytest.mark.parametrize("width", [80, 120])
def test_the_whole_table_fits(paths, width) -> None:
    one = next(iter(paths.values()))
    text = table(summary_record(dict.fromkeys(CASES, one), DURATION, quick=False), width)
    assert all(len(line) <= width for line in text.splitlines())
    assert "…" not in text
    assert text.count("as printed ") == 4
    assert "below 0.05 rad" in text


def test_a_diverged_path_shows_its_time(paths) -> None:
    case, path = next(iter(paths.items()))
    diverged = path.where(path["time"] < 0.03).assign(diverged_at=((), 0.03))
    text = table(summary_record({case: diverged}, DURATION, quick=True), 80)
    assert "diverged" in text
    assert " 0.03 " in text
    assert np.isnan(diverged["ote"][-1])
