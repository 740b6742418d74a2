"""``ftcfa verify``: decide whether a share of all runs keeps a specification."""

import math
from dataclasses import replace
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, ExperimentFile, Hardware, Threads, given
from ftcfa.cli.progress import progress_of_paths

EXIT_STATUS = {"yes": 0, "no": 1, "undecided": 3}

REQUIRED = "Overrides the file; required if the file has no specification."
ERROR = f"Largest tracking error once settled, in rad or m. {REQUIRED}"
UNLIMITED = "Overrides the file. Without both: no limit."
TOOL = f"Largest distance of the tool from its desired place once settled, in m. {UNLIMITED}"
WITHIN = f"Time by which a run must have settled, in s. {REQUIRED}"
EFFORT = f"Largest torque of every joint, in N m or N. {UNLIMITED}"
RATE = f"Largest torque rate of every joint, in N m/s or N/s. {UNLIMITED}"
DEFAULT = "between 0 and 1. Overrides the file. Without both: 0.95."
SHARE = f"Share of all runs that must keep the specification, {DEFAULT}"
CONFIDENCE = f"Confidence of the answer, yes or no, {DEFAULT}"
BUDGET = "Largest number of paths to run. Overrides the file. Without both: 10000."


def verify(
    experiment: ExperimentFile,
    error: Annotated[float | None, typer.Option(help=ERROR)] = None,
    tool_error: Annotated[float | None, typer.Option(help=TOOL)] = None,
    within: Annotated[float | None, typer.Option(help=WITHIN)] = None,
    effort: Annotated[float | None, typer.Option(help=EFFORT)] = None,
    torque_rate: Annotated[float | None, typer.Option(help=RATE)] = None,
    share: Annotated[float | None, typer.Option(help=SHARE)] = None,
    confidence: Annotated[float | None, typer.Option(help=CONFIDENCE)] = None,
    budget: Annotated[int | None, typer.Option(help=BUDGET)] = None,
    hardware: Hardware = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Decide whether a share of all runs keeps the specification of the file or of the options.

    Exit status 0: yes, 1: no, 3: undecided within the budget of paths.

    Example: ftcfa verify truck.toml --error 0.05 --within 1 --hardware fr3
    """
    from ftcfa.experiment import load_experiment
    from ftcfa.report.verification import print_verification, verification_record

    loaded = load_experiment(experiment, hardware=hardware)
    options = given(
        error=error, tool_error=tool_error, within=within, effort=effort, torque_rate=torque_rate,
        share=share, confidence=confidence, budget=budget,
    )  # fmt: skip
    chosen = replace(loaded, specification=_specification(loaded.specification, options))
    with progress_of_paths() as report:
        verification = chosen.verify(threads=threads, progress=report)
    record = verification_record(verification, str(experiment), chosen.duration, hardware)
    finish(record, print_verification, as_json)
    raise typer.Exit(EXIT_STATUS[verification.answer])


def _specification(of_file: Any, options: dict[str, Any]) -> Any:
    """The specification of the file, overridden by the options."""
    from ftcfa.errors import ParameterError
    from ftcfa.study.verification import Specification

    if of_file is not None:
        return replace(of_file, **options)
    if "within" not in options or not options.keys() & {"error", "tool_error"}:
        expected = "a table [specification] in the file with error and within"
        remedy = "or give --within and --error or --tool-error"
        raise ParameterError("specification", "missing", expected, remedy)
    return Specification(**{"error": math.inf, **options})
