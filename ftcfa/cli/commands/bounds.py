"""``ftcfa bounds``: the constants of Theorem 1 for a loop."""

from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, OptionalExperimentFile


def bounds(
    experiment: OptionalExperimentFile = None,
    theta: Annotated[
        float, typer.Option(help="Bound of the squared norm of the network's ideal weights.")
    ] = 0.0,
    eps: Annotated[float, typer.Option(help="Largest approximation error of the network.")] = 0.0,
    pi1: Annotated[
        float, typer.Option(help="Largest error of the command filter, in rad/s.")
    ] = 0.0,
    sigma: Annotated[
        float,
        typer.Option(
            help="Share of the decay rate Delta that goes into the bound of the first-entry time, "
            "between 0 and 1; a larger share gives an earlier time and a larger error bound."
        ),
    ] = 0.5,
    as_json: AsJson = False,
) -> None:
    """Print what Theorem 1 promises of a loop, in numbers, beside what a few paths do.

    Example: ftcfa bounds pendulum.toml --pi1 0.01
    """
    from ftcfa.experiment import load_experiment
    from ftcfa.report.bounds import bounds_record
    from ftcfa.report.bounds_table import print_bounds
    from ftcfa.study.reproduction import FINITE_TIME, closed_loop
    from ftcfa.theory.bounds import bounds as theorem1_bounds
    from ftcfa.theory.premises import theorem_paths

    loop = closed_loop(FINITE_TIME) if experiment is None else load_experiment(experiment).loop
    promised = theorem1_bounds(loop, theta=theta, eps=eps, pi1=pi1, sigma=sigma)
    finish(bounds_record(promised, theorem_paths(loop, promised)), print_bounds, as_json)
