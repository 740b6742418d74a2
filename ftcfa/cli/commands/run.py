"""``ftcfa run``: run an ensemble."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from ftcfa.cli.cluster import cluster
from ftcfa.cli.ending import finish
from ftcfa.cli.options import (
    AsJson,
    Duration,
    ExperimentFile,
    Hardware,
    Paths,
    Threads,
    given,
    local,
)
from ftcfa.cli.progress import progress_of_paths

STORE = "ensemble.zarr"
"""Name of the store of finished paths, below the folder of ``--out``."""
OUT = "Folder for the Dataset, summary.json, figures and the store of finished paths."
FRESH = "Discard the finished paths in the folder, also those of another experiment."
SCHEDULER = (
    "Address of a Dask scheduler whose workers run the paths. Without it: this machine runs them."
)


def run(
    experiment: ExperimentFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help=OUT, callback=local)] = Path("out"),
    paths: Paths = None,
    duration: Duration = None,
    threads: Threads = None,
    hardware: Hardware = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help=SCHEDULER)
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help=FRESH)] = False,
    as_json: AsJson = False,
) -> None:
    """Run an ensemble: statistics with confidence intervals, a netCDF file and figures.

    After Ctrl-C it prints the statistics of the finished paths and writes summary.json; the same
    command continues there.

    Example: ftcfa run truck.toml --paths 1000 --out out
    """
    from ftcfa.experiment import load_experiment
    from ftcfa.files import make_folder
    from ftcfa.report.ensemble import ensemble_files, ensemble_record
    from ftcfa.report.ensemble_text import print_ensemble
    from ftcfa.report.records import summary_file
    from ftcfa.study.progress import Interrupted
    from ftcfa.study.store import discard

    options = given(paths=paths, duration=duration)
    loaded = load_experiment(experiment, hardware=hardware)
    chosen = replace(loaded, specification=None, **options)
    make_folder(out)
    if fresh:
        discard(out / STORE)
    interruption = None
    with cluster(scheduler) as client, progress_of_paths() as report:
        try:
            dataset = chosen.run(threads=threads, client=client, store=out / STORE, progress=report)
        except Interrupted as error:
            if error.partial is None:
                raise
            dataset, interruption = error.partial, error
    record = ensemble_record(dataset, chosen.paths)
    if interruption is None:
        files = ensemble_files(dataset, record, chosen.loop.arm.effort_limit, experiment.name)
    else:
        files = {"summary.json": summary_file(record)}  # the Dataset is in the store
    finish(record, print_ensemble, as_json, files, out)
    if interruption is not None:
        raise interruption
