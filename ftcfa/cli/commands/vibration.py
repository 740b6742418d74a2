"""``ftcfa vibration``: show what a vibration standard becomes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, FigureFolder
from ftcfa.cli.progress import progress_of_steps

NAMES = "Names of vibration standards. Without any: list the known ones."
TABLE = (
    "File with tables of your own; all of them are shown, or those named. "
    "Without it: the standards that come with ftcfa."
)


def vibration(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help=NAMES, show_default=False)
    ] = None,
    table: Annotated[Path | None, typer.Option(metavar="FILE.toml", help=TABLE)] = None,
    out: FigureFolder = None,
    as_json: AsJson = False,
) -> None:
    """Show what a vibration standard becomes: the fit, the level, the step, the spectrum.

    Example: ftcfa vibration mil_std_810g_highway_truck_vertical --out out
    """
    from ftcfa.files import make_folder
    from ftcfa.report import vibration as report
    from ftcfa.study.realised_spectrum import realise_standard
    from ftcfa.vibration.spectra.standards import standards

    if not names and table is None:
        finish(report.catalogue_record(standards()), report.print_catalogue, as_json)
        return
    chosen = _chosen(names or [], table)
    if out is not None:
        make_folder(out)
    realised = []
    with progress_of_steps("standards", len(chosen)) as advance:
        for standard in chosen:
            realised.append(realise_standard(standard))
            advance()
    record, files = report.realised_record(realised), {}
    if out is not None:
        from ftcfa.report.figures import figure_files
        from ftcfa.report.vibration_figure import vibration_figure

        files = figure_files("spectrum", vibration_figure(realised), record)
    finish(record, report.print_realised, as_json, files, out)


def _chosen(names: Sequence[str], table: Path | None) -> list[Any]:
    """Standards by name, or all, of a file; without a file of those that come with ftcfa."""
    from ftcfa.errors import UnknownNameError
    from ftcfa.vibration.spectra.standards import read_table, standards

    known = standards() if table is None else read_table(table)
    for name in names:
        if name not in known:
            kind = "vibration standard" if table is None else f"{table}: table"
            raise UnknownNameError(kind, name, tuple(known))
    return [known[name] for name in names or known]
