"""``ftcfa vibration``: show what a vibration standard becomes."""

from pathlib import Path
from typing import Annotated

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
    from ftcfa.vibration.spectra import standards

    if not names and table is None:
        record = report.catalogue_record(standards.standards())
        finish(record, report.print_catalogue, as_json)
        return
    if table is None:
        chosen = [standards.standard(name) for name in names or []]
    elif names:
        chosen = [standards.read_standard(table, name) for name in names]
    else:
        chosen = list(standards.read_table(table).values())
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
