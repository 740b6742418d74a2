"""``ftcfa vibration``: show what a vibration standard becomes."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import finish
from ftcfa.cli.options import AsJson, FigureFolder, local
from ftcfa.cli.progress import progress_of_steps

NAMES = "Names of vibration standards. Without any: list the known ones."
TABLE = (
    "File with tables of your own; all of them are shown, or those named. "
    "Without it: the standards that come with ftcfa."
)

RECORD = "File with recorded accelerations: show its statistics and spectrum instead."
TO_TABLE = "File to write with the record's break points, as --table takes it."
CONFIDENCE = "Confidence of the limit that the break points follow."
UNIT = "Unit of the record's axes, where the file states none."
TIME_UNIT = "Unit of the record's times, where the file states none."


def vibration(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help=NAMES, show_default=False)
    ] = None,
    table: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help=TABLE, callback=local)
    ] = None,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE", help=RECORD, callback=local)
    ] = None,
    to_table: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help=TO_TABLE, callback=local)
    ] = None,
    confidence: Annotated[float, typer.Option(help=CONFIDENCE)] = 0.95,
    unit: Annotated[str | None, typer.Option(help=UNIT)] = None,
    time_unit: Annotated[str | None, typer.Option(help=TIME_UNIT)] = None,
    rate: Annotated[float | None, typer.Option(help="The record's sampling rate, in Hz.")] = None,
    skip: Annotated[int, typer.Option(help="Lines above the record's table.")] = 0,
    out: FigureFolder = None,
    as_json: AsJson = False,
) -> None:
    """Show what a vibration standard becomes: the fit, the level, the step, the spectrum.

    With --record: show what was measured, and make a table of it.

    Example: ftcfa vibration mil_std_810g_highway_truck_vertical --out out

    Example: ftcfa vibration --record floor.csv --to-table floor.toml
    """
    if record is not None:
        _show_record(record, to_table, confidence, unit, time_unit, rate, skip, out, as_json)
        return
    from ftcfa.files import make_folder
    from ftcfa.report import vibration as report
    from ftcfa.study.realised_spectrum import realise_standard
    from ftcfa.vibration.spectra import standards

    if not names and table is None:
        finish(report.catalogue_record(standards.standards()), report.print_catalogue, as_json)
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
    found, files = report.realised_record(realised), {}
    if out is not None:
        from ftcfa.report.figures import figure_files
        from ftcfa.report.vibration_figure import vibration_figure

        files = figure_files("spectrum", vibration_figure(realised), found)
    finish(found, report.print_realised, as_json, files, out)


def _show_record(
    file: Path,
    to_table: Path | None,
    confidence: float,
    unit: Any,
    time_unit: Any,
    rate: float | None,
    skip: int,
    out: Path | None,
    as_json: bool,
) -> None:
    """Show a record, write its figure, and its table beside it or where the user wants it."""
    from ftcfa.files import make_folder, write_whole
    from ftcfa.report.measured import measured_record, measured_table, print_measured
    from ftcfa.study.measured_spectrum import measured_vibration
    from ftcfa.vibration.records.record import read_record

    if out is not None:
        make_folder(out)
    recorded = read_record(file, unit, rate=rate, time_unit=time_unit, skip=skip)
    measured = measured_vibration(recorded, confidence)
    shown, files = measured_record(measured, to_table), {}
    if out is not None:
        from ftcfa.report.figures import figure_files
        from ftcfa.report.measured_figure import measured_figure

        files = figure_files("spectrum", measured_figure(measured), shown)
    if to_table is not None:
        write_whole(to_table, measured_table(shown))
    finish(shown, print_measured, as_json, files, out)
