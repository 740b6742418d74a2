"""The command line, thin: each command imports what it needs only when it runs.

Exit status: 0 done, 2 bad input (one sentence on standard error), 130 interrupted.
"""

import json
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from threading import Event
from typing import Annotated, Any

import typer

app = typer.Typer(
    name="ftcfa",
    help="Robust control of robot arms whose base shakes at random.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

_interrupted = Event()
"""Whether Ctrl-C was pressed: libraries may swallow KeyboardInterrupt."""

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit.

    Args:
        arguments: Words after ``ftcfa``; those of the process by default.
    """
    from ftcfa.errors import FtcfaError

    before = signal.signal(signal.SIGINT, _interrupt)
    try:
        app(args=None if arguments is None else list(arguments), prog_name="ftcfa")
    except (Exception, KeyboardInterrupt) as error:
        if _interrupted.is_set():
            sys.exit(130)
        if not isinstance(error, FtcfaError | OSError):
            raise
        print(f"ftcfa: {error}", file=sys.stderr)
        sys.exit(2)
    finally:
        signal.signal(signal.SIGINT, before)
        _interrupted.clear()


def _interrupt(*_: Any) -> None:
    """Answer to Ctrl-C: stop at once."""
    _interrupted.set()
    raise KeyboardInterrupt


def _interrupt_after_step(*_: Any) -> None:
    """Answer to Ctrl-C in a step of a progress bar: stop after it; the second time, at once."""
    if _interrupted.is_set():
        raise KeyboardInterrupt
    _interrupted.set()


def _print_version(asked: bool) -> None:
    if asked:
        print(f"ftcfa {version('ftcfa')}")
        raise typer.Exit


@app.callback()
def _common(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Robust control of robot arms whose base shakes at random."""


@app.command()
def inspect(
    robot: Annotated[
        str | None,
        typer.Argument(
            metavar="ROBOT", help="Name of an arm, or path of a URDF. Without it: list the names."
        ),
    ] = None,
    lock: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Hold a joint at a value in rad or m; repeatable."),
    ] = None,
    effort_limit: Annotated[
        float | None,
        typer.Option(help="Torque limit of every joint in N m or N, for the URDF's."),
    ] = None,
    gravity: Annotated[float, typer.Option(help="Downward acceleration in m/s^2.")] = 9.81,
    package_dir: Annotated[
        list[str] | None,
        typer.Option(
            metavar="DIR", help="Folder that holds ROS packages, for package:// paths; repeatable."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show an arm: joints, limits, friction, mass, bounds of its mass matrix, warnings.

    `ftcfa inspect` alone lists the arms known by name; any other URDF goes by its path.
    """
    from rich.console import Console

    from ftcfa.model.catalogue import catalogue
    from ftcfa.report.arm import arm_record, print_arm, print_catalogue

    described = {name: entry.description for name, entry in catalogue().items()}
    if robot is None:
        _print_json(described) if as_json else print_catalogue(described, Console())
        return
    from ftcfa.model.load import load_arm

    arm = load_arm(
        robot,
        lock=_locks(lock or []),
        effort_limit=effort_limit,
        gravity=gravity,
        package_dirs=package_dir or (),
    )
    record = arm_record(arm)
    if as_json:
        _print_json(record)
    else:
        print_arm(record, described.get(robot, ""), Console())


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the figures and summary.json.")] = Path(
        "out"
    ),
    quick: Annotated[
        bool, typer.Option("--quick", help="A look in seconds: fewer cases, shorter paths.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Run the paper's study: its figures, one that it lacks, and a table of all cases."""
    from rich.console import Console

    from ftcfa.report.files import make_folder, write_whole
    from ftcfa.report.reproduction import (
        FIGURES,
        print_summary,
        reproduction_files,
        summary_record,
    )
    from ftcfa.study.reproduction import (
        CASES,
        DURATION,
        QUICK_CASES,
        QUICK_DURATION,
        run_case,
    )

    make_folder(out)
    cases, duration = (QUICK_CASES, QUICK_DURATION) if quick else (CASES, DURATION)
    paths = {}
    with _progress("cases", len(cases)) as advance:
        for case in cases:
            paths[case] = run_case(case, duration)
            advance()
    record = summary_record(paths, duration, quick)
    with _progress("figures", FIGURES) as advance:
        files = reproduction_files(paths, record, advance)
    for name, content in files.items():
        write_whole(out / name, content)
    if as_json:
        _print_json({**record, "files": [str(out / name) for name in files]})
        return
    console = Console(highlight=False)
    if quick:
        console.print(
            f"quick look: {len(cases)} of {len(CASES)} cases, {duration:g} s of {DURATION:g} s; "
            "the paper's numbers need the whole study\n"
        )
    print_summary(record, console)
    console.print(f"\n{len(files)} files in {out}: {', '.join(files)}", markup=False)


@app.command()
def vibration(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Vibration specifications. Without any: list those known by name.",
            show_default=False,
        ),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml",
            help="A file of specifications of your own; all of them, or those named.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the figure and summary.json.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show what a vibration specification becomes: the fit, the level, the step, the spectrum.

    `ftcfa vibration` alone lists the specifications that come along and their sources.
    """
    from rich.console import Console

    from ftcfa.report.files import make_folder, write_whole
    from ftcfa.report.vibration import (
        catalogue_record,
        print_catalogue,
        print_realised,
        realised_record,
    )
    from ftcfa.vibration.realised_spectrum import realise_specification
    from ftcfa.vibration.standards import standards

    console = Console(highlight=False)
    if not names and table is None:
        listed = catalogue_record(standards())
        _print_json(listed) if as_json else print_catalogue(listed, console)
        return
    specifications = _specifications(names or [], table)
    if out is not None:
        make_folder(out)
    realised = []
    with _progress("specifications", len(specifications)) as advance:
        for specification in specifications:
            realised.append(realise_specification(specification))
            advance()
    record = realised_record(realised)
    files = {}
    if out is not None:
        from ftcfa.report.spectra import spectra_files

        files = {out / name: it for name, it in spectra_files(realised, record).items()}
    for file, content in files.items():
        write_whole(file, content)
    if as_json:
        _print_json({**record, "files": [str(file) for file in files]})
        return
    print_realised(record, console)
    if files:
        names_of_files = ", ".join(file.name for file in files)
        console.print(f"{len(files)} files in {out}: {names_of_files}", markup=False)


@contextmanager
def _progress(label: str, total: int) -> Iterator[Callable[[], None]]:
    """A bar on standard error, if that is a terminal; yields what advances it by one.

    Within the block Ctrl-C waits for the end of the step, because CasADi would take the exception
    for a failure of its own; advancing raises it.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    before = signal.signal(signal.SIGINT, _interrupt_after_step)
    try:
        with Progress(
            *columns, TimeElapsedColumn(), console=console, transient=True,
            disable=not console.is_terminal,
        ) as progress:  # fmt: skip
            task = progress.add_task(label, total=total)

            def advance(steps: int = 1) -> None:
                progress.advance(task, steps)
                if _interrupted.is_set():
                    raise KeyboardInterrupt

            advance(0)
            yield advance
    finally:
        signal.signal(signal.SIGINT, before)


def _specifications(names: Sequence[str], table: Path | None) -> list[Any]:
    """Specifications by name, of those that come along or of a file; without names, all of it."""
    from ftcfa.errors import UnknownNameError
    from ftcfa.vibration.standards import read_table, standards

    known = standards() if table is None else read_table(table)
    for name in names:
        if name not in known:
            kind = "vibration standard" if table is None else f"{table}: table"
            raise UnknownNameError(kind, name, tuple(known))
    return [known[name] for name in names or known]


def _locks(words: Sequence[str]) -> dict[str, float]:
    """NAME=VALUE words as joint values."""
    from ftcfa.errors import ParameterError

    locks = {}
    for word in words:
        name, _, value = word.rpartition("=")
        try:
            locks[name] = float(value)
        except ValueError as error:
            raise ParameterError("--lock", word, "NAME=VALUE with a number [rad or m]") from error
        if not name:
            raise ParameterError("--lock", word, "NAME=VALUE with a number [rad or m]")
    return locks


def _print_json(record: Any) -> None:
    print(json.dumps(record, indent=2, allow_nan=False), flush=True)
