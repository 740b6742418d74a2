"""``ftcfa bounds``: the constants of Theorem 1 for a loop."""

from typing import Annotated

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, OptionalExperimentFile, experiment_of

THETA = "Bound of the squared norm of the network's ideal weights."
PI1 = "Largest error of the command filter, in rad/s."
SIGMA = (
    "Share of the decay rate Delta that goes into the bound of the first-entry time, between 0 "
    "and 1; a larger share gives an earlier time and a larger error bound."
)


def bounds(
    experiment: OptionalExperimentFile = None,
    theta: Annotated[float, typer.Option(help=THETA)] = 0.0,
    eps: Annotated[float, typer.Option(help="Largest approximation error of the network.")] = 0.0,
    pi1: Annotated[float, typer.Option(help=PI1)] = 0.0,
    sigma: Annotated[float, typer.Option(help=SIGMA)] = 0.5,
    as_json: AsJson = False,
) -> None:
    """Print what Theorem 1 promises of a loop, in numbers, beside what a few paths do.

    Example: ftcfa bounds pendulum.toml --pi1 0.01
    """
    from ftcfa.report.bounds import bounds_record, print_bounds
    from ftcfa.theory.bounds import bounds as theorem1_bounds
    from ftcfa.theory.premises import theorem_paths

    loop = experiment_of(experiment).loop
    promised = theorem1_bounds(loop, theta=theta, eps=eps, pi1=pi1, sigma=sigma)
    finish(bounds_record(promised, theorem_paths(loop, promised)), print_bounds, as_json)
