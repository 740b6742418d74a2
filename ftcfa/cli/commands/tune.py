"""``ftcfa tune``: gains for an arm, its base and its hardware."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

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
    from ftcfa.study.progress import Interrupted
    from ftcfa.study.tuning.space import joint_by_joint
    from ftcfa.study.variants import rivals
    from ftcfa.theory.gain_conditions import gain_shortfall

    natural("--validate", validate)
    if out is not None:
        make_folder(out.parent)  # before the search, which would be lost
    chosen = load_experiment(experiment, hardware=hardware)
    chosen = replace(chosen, specification=None, **given(duration=duration, seed=seed))
    if controller is not None:
        chosen = replace(chosen, loop=rivals(chosen.loop, controller)[controller])
    if per_joint:
        chosen = replace(chosen, loop=joint_by_joint(chosen.loop))
    interruption, shown = None, None

    def show(_: int, cost: float) -> None:
        advance(f"best {cost:.4g}")

    with progress_of_steps("generations", generations) as advance:
        try:
            tuning = chosen.tune(
                generations=generations, candidates=candidates, paths=paths, threads=threads,
                store=store, progress=show, condition=gain_shortfall if theorem else None,
            )  # fmt: skip
        except Interrupted as error:
            if error.partial is None:
                raise
            tuning, interruption = error.partial, error
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
