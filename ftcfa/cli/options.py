"""Arguments and options of several commands, and what is made of the options that were given."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ftcfa.experiment import Experiment


def _check_threads(threads: int | None) -> int | None:
    """Raise ParameterError unless a number of threads is at least 1."""
    from ftcfa.checks import counting

    if threads is not None:
        counting("--threads", threads)
    return threads


def local(path: Path | None) -> Path | None:
    """A path of this machine, ~ resolved; ParameterError for a URL."""
    from ftcfa.files import local_path

    return None if path is None else local_path(path)


ExperimentFile = Annotated[
    Path, typer.Argument(metavar="EXPERIMENT.toml", help="File of the experiment.")
]
PAPER = "File of the experiment. Without it: the paper's double pendulum."
OptionalExperimentFile = Annotated[
    Path | None, typer.Argument(metavar="EXPERIMENT.toml", help=PAPER)
]
Duration = Annotated[
    float | None, typer.Option(help="Simulated time of every path, in s. Overrides the file.")
]
Paths = Annotated[int | None, typer.Option(help="Number of paths. Overrides the file.")]
Threads = Annotated[
    int | None,
    typer.Option(help="Number of threads. Without it: one for each core.", callback=_check_threads),
]
HARDWARE = (
    "Profile of the robot's sensors and motors, such as fr3; `ftcfa hardware` lists them. "
    "Overrides the file."
)
Hardware = Annotated[str | None, typer.Option(metavar="PROFILE", help=HARDWARE)]
FOLDER = "Folder for the figure and summary.json. Without it: nothing is written."
FigureFolder = Annotated[Path | None, typer.Option(metavar="DIR", help=FOLDER, callback=local)]
JSON = "Print one JSON object and nothing else. Without it: print a table."
AsJson = Annotated[bool, typer.Option("--json", help=JSON)]


def given(**options: Any) -> dict[str, Any]:
    """The options that the user gave, without those that are None."""
    return {name: value for name, value in options.items() if value is not None}


def experiment_of(file: Path | None, hardware: str | None = None) -> "Experiment":
    """The experiment of a file; without a file, 1000 paths of the paper's double pendulum.

    Args:
        file: The file, or None.
        hardware: Profile that replaces its hardware, or None.
    """
    from ftcfa.experiment import Experiment, load_experiment
    from ftcfa.study.reproduction import FINITE_TIME, closed_loop

    if file is not None:
        return load_experiment(file, hardware=hardware)
    loop = closed_loop(FINITE_TIME)
    loop = loop if hardware is None else replace(loop, hardware=hardware)
    return Experiment(loop, duration=10.0, paths=1000)
