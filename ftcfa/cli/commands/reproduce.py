"""``ftcfa reproduce``: run the paper's study."""

from pathlib import Path
from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, local
from ftcfa.cli.progress import progress_of_steps

OUT = "Folder for the figures and summary.json."
QUICK = "Run fewer cases and shorter paths, in seconds. Without it: all."


def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help=OUT, callback=local)] = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help=QUICK)] = False,
    as_json: AsJson = False,
) -> None:
    """Run the paper's study: its figures, one that it lacks, and a table of all cases.

    Example: ftcfa reproduce --quick --out out
    """
    from ftcfa.files import make_folder
    from ftcfa.report import reproduction as report
    from ftcfa.study import reproduction as study

    make_folder(out)
    cases = study.QUICK_CASES if quick else study.CASES
    duration = study.QUICK_DURATION if quick else study.DURATION
    paths = {}
    with progress_of_steps("cases", len(cases)) as advance:
        for case in cases:
            paths[case] = study.run_case(case, duration)
            advance()
    record = report.summary_record(paths, duration, quick)
    with progress_of_steps("figures", report.FIGURES) as advance:
        files = report.reproduction_files(paths, record, advance)
    finish(record, report.print_summary, as_json, files, out)
