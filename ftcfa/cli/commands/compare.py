"""``ftcfa compare``: compare a loop with others under the same noise."""

from dataclasses import replace
from typing import Annotated, Literal

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import (
    AsJson,
    Duration,
    FigureFolder,
    OptionalExperimentFile,
    Paths,
    Threads,
    check_threads,
    given,
)
from ftcfa.cli.progress import progress_of_paths

Against = Literal["rivals", "ablations", "conditions"]


def compare(
    experiment: OptionalExperimentFile = None,
    against: Annotated[
        Against,
        typer.Option(
            help="What the loop is compared with: other control laws (rivals), its law without "
            "one ingredient at a time (ablations), or harder conditions."
        ),
    ] = "rivals",
    controller: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LAW",
            help="Name of a control law to compare with that of the file; repeatable. "
            "Without it: all.",
        ),
    ] = None,
    paths: Paths = None,
    duration: Duration = None,
    out: FigureFolder = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compare a loop with others under the same noise: means, and paired differences.

    Example: ftcfa compare truck.toml --controller FTCF --controller ComputedTorque
    """
    from ftcfa.errors import ParameterError
    from ftcfa.experiment import Experiment, load_experiment
    from ftcfa.files import make_folder
    from ftcfa.report.comparison import comparison_files, comparison_record
    from ftcfa.report.comparison_table import print_comparison
    from ftcfa.study import comparison, variants
    from ftcfa.study.reproduction import FINITE_TIME, closed_loop

    if experiment is None:
        loaded = Experiment(closed_loop(FINITE_TIME), duration=10.0, paths=1000)
    else:
        loaded = load_experiment(experiment)
    chosen = replace(loaded, specification=None, **given(paths=paths, duration=duration))
    check_threads(threads)
    if out is not None:
        make_folder(out)
    if controller and against != "rivals":
        given_with = f"{', '.join(controller)} with --against {against}"
        raise ParameterError("--controller", given_with, "--against rivals")
    if against == "rivals":
        loops = variants.rivals(chosen.loop, controller)
    elif against == "ablations":
        loops = variants.ablations(chosen.loop)
    else:
        loops = variants.conditions(chosen.loop)
    with progress_of_paths() as report:
        dataset = comparison.compare(
            loops, chosen.paths, chosen.duration, seed=chosen.seed, tolerance=chosen.tolerance,
            after=chosen.after, threads=threads, progress=report,
        )  # fmt: skip
    name = getattr(chosen.loop.arm, "name", type(chosen.loop.arm).__name__)
    record = comparison_record(dataset)
    files = {} if out is None else comparison_files(dataset, record, f"{name}: {against}")
    finish(record, print_comparison, as_json, files, out)
