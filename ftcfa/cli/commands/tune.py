"""``ftcfa tune``: gains for an arm, its base and its hardware."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, Duration, ExperimentFile, Hardware, Threads, given, local
from ftcfa.cli.progress import progress_of_paths, progress_of_steps

EXIT_STATUS = {"yes": 0, "no": 1}
OUT = "File of the experiment with the tuned gains. Without it: nothing is written."
STORE = "File from which the same search goes on, whenever it was stopped."
GENERATIONS = "Number of generations of candidates."
CANDIDATES = "Number of candidates of a generation."
PATHS = "Paths of each candidate that stays to the end of a generation."
LAW = "Name of the control law to tune instead of that of the file."
JOINTS = "Tune a number for each joint, where the law may have one."
THEOREM = "Only gains that meet Theorem 1's conditions; for the law FTCF."
VALIDATE = "Paths of the validation, which no search has used; 0 for none."


def tune(
    experiment: ExperimentFile,
    out: Annotated[
        Path | None, typer.Option(metavar="TUNED.toml", help=OUT, callback=local)
    ] = None,
    controller: Annotated[str | None, typer.Option(metavar="LAW", help=LAW)] = None,
    per_joint: Annotated[bool, typer.Option("--per-joint", help=JOINTS)] = False,
    theorem: Annotated[bool, typer.Option("--theorem", help=THEOREM)] = False,
    generations: Annotated[int, typer.Option(help=GENERATIONS)] = 30,
    candidates: Annotated[int, typer.Option(help=CANDIDATES)] = 24,
    paths: Annotated[int, typer.Option(help=PATHS)] = 64,
    validate: Annotated[int, typer.Option(help=VALIDATE)] = 1000,
    seed: Annotated[int | None, typer.Option(help="Seed. Overrides the file.")] = None,
    duration: Duration = None,
    hardware: Hardware = None,
    store: Annotated[Path | None, typer.Option(metavar="FILE", help=STORE, callback=local)] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Search the gains of the file's law, and compare them with those of the file on fresh paths.

    What is to be small, and what must not be exceeded, stands in the file's table "objective"; the
    ranges of the search in its table "space". Exit status 0: the gains keep the limits, 1: none
    found does. After Ctrl-C the best so far counts.

    Example: ftcfa tune truck.toml --hardware fr3 --out tuned.toml
    """
    from ftcfa.checks import natural
    from ftcfa.experiment import load_experiment
    from ftcfa.files import make_folder
    from ftcfa.report.comparison import comparison_record
    from ftcfa.report.tuning import print_tuning, tuning_record
    from ftcfa.theory.gain_conditions import gain_shortfall

    natural("--validate", validate)
    if out is not None:
        make_folder(out.parent)  # before the search, which would be lost
    loaded = load_experiment(experiment, hardware=hardware)
    loaded = replace(loaded, specification=None, **given(duration=duration, seed=seed))
    chosen = replace(loaded, loop=_loop(loaded.loop, controller, per_joint))
    budget = {"generations": generations, "candidates": candidates, "paths": paths}
    condition = gain_shortfall if theorem else None
    options = {"store": store, "threads": threads, "condition": condition, **budget}
    tuning, interruption = _search(chosen, options)
    shown = None
    if validate and interruption is None:
        with progress_of_paths() as report:
            shown = comparison_record(tuning.validate(validate, threads=threads, progress=report))
    if out is not None:
        replace(chosen, loop=tuning.loop).save(out)
    record = tuning_record(tuning, shown) | {"file": None if out is None else str(out)}
    finish(record, print_tuning, as_json)
    if interruption is not None:
        raise interruption
    raise typer.Exit(EXIT_STATUS[tuning.answer])


def _loop(loop: Any, controller: str | None, per_joint: bool) -> Any:
    """The loop that is tuned: under a law of a name if one is given, perhaps joint by joint."""
    from ftcfa.study.tuning.space import joint_by_joint
    from ftcfa.study.variants import rivals

    chosen = loop if controller is None else rivals(loop, controller)[controller]
    return joint_by_joint(chosen) if per_joint else chosen


def _search(chosen: Any, options: Mapping[str, Any]) -> tuple[Any, KeyboardInterrupt | None]:
    """Search with a progress bar: what was found, and the interruption if there was one."""
    from ftcfa.study.progress import Interrupted

    with progress_of_steps("generations", options["generations"]) as advance:
        try:
            found = chosen.tune(**options, progress=lambda _, cost: advance(f"best {cost:.4g}"))
        except Interrupted as error:
            if error.partial is None:
                raise
            return error.partial, error
    return found, None
