"""``ftcfa reproduce``: run the paper's study."""

from pathlib import Path
from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson
from ftcfa.cli.progress import progress_of_steps


def reproduce(
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for the figures and summary.json.")
    ] = Path("out"),
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="Run fewer cases and shorter paths, in seconds. Without it: all."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Run the paper's study: its figures, one that it lacks, and a table of all cases.

    Example: ftcfa reproduce --quick --out out
    """
    from ftcfa.files import make_folder
    from ftcfa.report.reproduction import (
        FIGURES,
        print_summary,
        reproduction_files,
        summary_record,
    )
    from ftcfa.study.reproduction import (
        CASES,
        DURATION,
        QUICK_CASES,
        QUICK_DURATION,
        run_case,
    )

    make_folder(out)
    cases, duration = (QUICK_CASES, QUICK_DURATION) if quick else (CASES, DURATION)
    paths = {}
    with progress_of_steps("cases", len(cases)) as advance:
        for case in cases:
            paths[case] = run_case(case, duration)
            advance()
    record = summary_record(paths, duration, quick)
    with progress_of_steps("figures", FIGURES) as advance:
        files = reproduction_files(paths, record, advance)
    finish(record, print_summary, as_json, files, out)
