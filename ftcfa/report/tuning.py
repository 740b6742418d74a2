"""The answer of `tune` as plain data and as a table."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from ftcfa.report.comparison import print_comparison
from ftcfa.report.records import finite
from ftcfa.report.terminal import print_line, print_table
from ftcfa.study.tuning.result import Tuning


def tuning_record(tuning: Tuning, validation: Mapping[str, Any] | None) -> dict[str, Any]:
    """What a search found.

    Args:
        tuning: The answer of `tune`.
        validation: The record of its validation, see `ftcfa.report.comparison.comparison_record`.
    """
    start, ranges = tuning.space.start, tuning.space.ranges
    gains = {
        name: {"value": value, "before": start[name].tolist(), "unit": ranges[name].unit}
        for name, value in tuning.gains.items()
    }
    return {
        "answer": tuning.answer,
        "sentence": tuning.sentence,
        "broken": list(tuning.broken),
        "gains": gains,
        "candidates": tuning.tried,
        "cost": finite(tuning.cost),
        "cost as given": finite(tuning.cost_given),
        "less": [finite(x) for x in tuning.less],
        "paths of the final": tuning.final_paths,
        "excess as given": finite(tuning.excess_given),
        "cost in the search": finite(tuning.cost_in_search),
        "excess": finite(tuning.excess),
        "seed": tuning.plan.seed,
        "validation": None if validation is None else dict(validation),
    }


def print_tuning(record: Mapping[str, Any], console: Console) -> None:
    """Print the result of `tuning_record`."""
    print_line(f"{record['sentence']}\n", console)
    rows = [
        [name, _shown(it["before"]), _shown(it["value"]), it["unit"]]
        for name, it in record["gains"].items()
    ]
    print_table(["parameter", "as given", "tuned", "unit"], rows, console)
    if record["validation"] is not None:
        paths = record["validation"]["paths"]
        print_line(f"\nBeside the loop as given on {paths:,} fresh paths of each:\n", console)
        print_comparison(record["validation"], console)


def _shown(value: float | list[float]) -> str:
    return ", ".join(f"{x:.4g}" for x in value) if isinstance(value, list) else f"{value:.4g}"
