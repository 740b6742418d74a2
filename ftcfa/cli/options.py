"""Arguments and options of several commands, and what is made of the options that were given."""

from pathlib import Path
from typing import Annotated, Any

import typer

ExperimentFile = Annotated[
    Path, typer.Argument(metavar="EXPERIMENT.toml", help="File of the experiment.")
]
OptionalExperimentFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="EXPERIMENT.toml",
        help="File of the experiment. Without it: the paper's double pendulum.",
    ),
]
Duration = Annotated[
    float | None, typer.Option(help="Simulated time of every path, in s. Overrides the file.")
]
Paths = Annotated[int | None, typer.Option(help="Number of paths. Overrides the file.")]
Threads = Annotated[
    int | None, typer.Option(help="Number of threads. Without it: one for each core.")
]
FigureFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder for the figure and summary.json. Without it: nothing is written.",
    ),
]
AsJson = Annotated[
    bool,
    typer.Option(
        "--json", help="Print one JSON object and nothing else. Without it: print a table."
    ),
]


def given(**options: Any) -> dict[str, Any]:
    """The options that the user gave, without those that are None."""
    return {name: value for name, value in options.items() if value is not None}


def check_threads(threads: int | None) -> None:
    """Raise ParameterError unless a number of threads is at least 1."""
    from ftcfa.checks import counting

    if threads is not None:
        counting("--threads", threads)
