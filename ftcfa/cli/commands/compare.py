"""``ftcfa compare``: compare a loop with others under the same noise."""

from dataclasses import replace
from typing import Annotated, Literal

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import (
    AsJson,
    Duration,
    FigureFolder,
    Hardware,
    OptionalExperimentFile,
    Paths,
    Threads,
    experiment_of,
    given,
)
from ftcfa.cli.progress import progress_of_paths

Against = Literal["rivals", "ablations", "conditions"]
AGAINST = (
    "What the loop is compared with: other control laws (rivals), its law without one ingredient "
    "at a time (ablations), or harder conditions."
)
LAWS = "Name of a control law to compare with that of the file; repeatable. Without it: all."


def compare(
    experiment: OptionalExperimentFile = None,
    against: Annotated[Against, typer.Option(help=AGAINST)] = "rivals",
    controller: Annotated[list[str] | None, typer.Option(metavar="LAW", help=LAWS)] = None,
    paths: Paths = None,
    duration: Duration = None,
    hardware: Hardware = None,
    out: FigureFolder = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compare a loop with others under the same noise: means, and paired differences.

    Example: ftcfa compare truck.toml --controller FTCF --controller ComputedTorque

    Example: ftcfa compare truck.toml --hardware fr3
    """
    from ftcfa.errors import ParameterError
    from ftcfa.files import make_folder
    from ftcfa.report.comparison import comparison_record, print_comparison
    from ftcfa.report.comparison_figure import comparison_figure
    from ftcfa.report.figures import figure_files
    from ftcfa.study import comparison, variants

    options = given(paths=paths, duration=duration)
    loaded = experiment_of(experiment, hardware)
    chosen = replace(loaded, specification=None, **options)
    if out is not None:
        make_folder(out)
    if controller and against != "rivals":
        given_with = f"{', '.join(controller)} with --against {against}"
        raise ParameterError("--controller", given_with, "--against rivals")
    if against == "rivals":
        loops = variants.rivals(chosen.loop, controller)
    else:
        make = {"ablations": variants.ablations, "conditions": variants.conditions}[against]
        loops = make(chosen.loop)
    with progress_of_paths() as report:
        dataset = comparison.compare(
            loops, chosen.paths, chosen.duration, seed=chosen.seed, tolerance=chosen.tolerance,
            after=chosen.after, threads=threads, progress=report,
        )  # fmt: skip
    name = getattr(chosen.loop.arm, "name", type(chosen.loop.arm).__name__)
    record, files = comparison_record(dataset), {}
    if out is not None:
        figure = comparison_figure(dataset, f"{name}: {against}")
        files = figure_files("comparison", figure, record)
    finish(record, print_comparison, as_json, files, out)
