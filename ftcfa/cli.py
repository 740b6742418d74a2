"""The command line, thin: each command imports what it needs only when it runs.

Exit status: 0 done, 1 the answer is no, 2 bad input (one sentence a fault on standard error),
3 undecided within the budget, 130 interrupted.
"""

import json
import re
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from threading import Event
from typing import Annotated, Any, Literal, cast

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

ADDRESS = r"(tcp|tls|ucx|wss?)://.+:\d+"
"""Of a scheduler."""
SECONDS_TO_ANSWER = 5
"""How long a scheduler is waited for."""
RECENT = 16
"""Reports over which the rate of a progress bar is taken."""
STORE = "ensemble.zarr"
"""Where `ftcfa run` keeps what is done, below its folder."""
EXIT_STATUS = {"yes": 0, "no": 1, "undecided": 3}

File = Annotated[Path, typer.Argument(metavar="EXPERIMENT.toml", help="The experiment's file.")]
OptionalFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="EXPERIMENT.toml", help="The experiment's file. Without it: the paper's study."
    ),
]
Against = Literal["rivals", "ablations", "conditions"]
Threads = Annotated[int | None, typer.Option(help="Threads; all by default.")]
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
        for line in str(error).splitlines():
            print(f"ftcfa: {line}", file=sys.stderr)
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

    from ftcfa.model.urdf.catalogue import catalogue
    from ftcfa.report.arm import arm_record, print_arm, print_catalogue

    described = {name: entry.description for name, entry in catalogue().items()}
    if robot is None:
        _print_json(described) if as_json else print_catalogue(described, Console())
        return
    from ftcfa.model.urdf.load import load_arm

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

    from ftcfa.files import make_folder, write_whole
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

    from ftcfa.files import make_folder, write_whole
    from ftcfa.report.vibration import (
        catalogue_record,
        print_catalogue,
        print_realised,
        realised_record,
    )
    from ftcfa.study.realised_spectrum import realise_specification
    from ftcfa.vibration.spectra.standards import standards

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


@app.command()
def run(
    experiment: File,
    out: Annotated[
        Path, typer.Option(help="Folder for what is done, the Dataset, summary.json and figures.")
    ] = Path("out"),
    paths: Annotated[int | None, typer.Option(help="How many, for the file's.")] = None,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time in s, for the file's.")
    ] = None,
    threads: Threads = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="tcp://HOST:PORT", help="A Dask scheduler whose workers run the paths."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run an ensemble: statistics with confidence intervals, a netCDF file and figures.

    Run again, it goes on where it was; so after Ctrl-C, which gives the statistics of what is done.
    """
    from rich.console import Console

    from ftcfa.experiment import load_experiment
    from ftcfa.files import make_folder, write_whole
    from ftcfa.report.ensemble import ensemble_files, ensemble_record, print_ensemble

    asked = _given(paths=paths, duration=duration)
    told = replace(load_experiment(experiment), specification=None, **asked)
    _check_threads(threads)
    make_folder(out)
    with _cluster(scheduler) as client, _progress_of_paths() as report:
        dataset = told.run(threads=threads, client=client, store=out / STORE, progress=report)
    record = ensemble_record(dataset, told.paths)
    files = ensemble_files(dataset, record, told.loop.arm.effort_limit, experiment.name)
    for name, content in files.items():
        write_whole(out / name, content)
    if as_json:
        _print_json({**record, "files": [str(out / name) for name in files]})
    else:
        console = Console(highlight=False)
        print_ensemble(record, console)
        names = ", ".join([*files, STORE])
        console.print(f"\nin {out}: {names}", markup=False)
    if _interrupted.is_set():
        raise KeyboardInterrupt


@app.command()
def verify(
    experiment: File,
    error: Annotated[
        float | None, typer.Option(help="Largest tracking error after settling, rad or m.")
    ] = None,
    within: Annotated[float | None, typer.Option(help="Time to settle in s.")] = None,
    effort: Annotated[
        float | None, typer.Option(help="Largest torque of every joint in N m or N.")
    ] = None,
    torque_rate: Annotated[
        float | None, typer.Option(help="Largest torque rate of every joint in N m/s or N/s.")
    ] = None,
    share: Annotated[
        float | None, typer.Option(help="Share of the runs that shall keep it [0.95].")
    ] = None,
    confidence: Annotated[float | None, typer.Option(help="Of yes and of no [0.95].")] = None,
    budget: Annotated[int | None, typer.Option(help="Largest number of paths [10000].")] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Ask whether a share of all runs keeps the specification of the file or of the options.

    Exit status 0: yes, 1: no, 3: undecided within the budget of paths.
    """
    from rich.console import Console

    from ftcfa.experiment import load_experiment
    from ftcfa.report.verification import print_verification, verification_record

    told = load_experiment(experiment)
    options = _given(
        error=error, within=within, effort=effort, torque_rate=torque_rate, share=share,
        confidence=confidence, budget=budget,
    )  # fmt: skip
    told = replace(told, specification=_specification(told.specification, options))
    _check_threads(threads)
    with _progress_of_paths() as report:
        found = told.verify(threads=threads, progress=report)
    record = verification_record(found, str(experiment), told.duration)
    if as_json:
        _print_json(record)
    else:
        print_verification(record, Console(highlight=False))
    raise typer.Exit(EXIT_STATUS[found.answer])


@app.command()
def compare(
    experiment: OptionalFile = None,
    against: Annotated[
        Against, typer.Option(help="Other laws, ingredients left out, or harder conditions.")
    ] = "rivals",
    controller: Annotated[
        list[str] | None,
        typer.Option(help="A law to compare with the file's; repeatable. All by default."),
    ] = None,
    paths: Annotated[int | None, typer.Option(help="How many, for the file's.")] = None,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time in s, for the file's.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the figure and summary.json.")
    ] = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Compare a loop with others under the same noise: means, and paired differences."""
    from rich.console import Console

    from ftcfa.errors import ParameterError
    from ftcfa.experiment import Experiment, load_experiment
    from ftcfa.files import make_folder, write_whole
    from ftcfa.report.comparison import comparison_files, comparison_record, print_comparison
    from ftcfa.study import comparison, variants
    from ftcfa.study.reproduction import FINITE_TIME, closed_loop

    if experiment is None:
        told = Experiment(closed_loop(FINITE_TIME), duration=10.0, paths=1000)
    else:
        told = load_experiment(experiment)
    told = replace(told, specification=None, **_given(paths=paths, duration=duration))
    _check_threads(threads)
    if out is not None:
        make_folder(out)
    if controller and against != "rivals":
        raise ParameterError("--controller", ", ".join(controller), "it with --against rivals")
    if against == "rivals":
        loops = variants.rivals(told.loop, controller)
    else:
        loops = getattr(variants, against)(told.loop)
    with _progress_of_paths() as report:
        dataset = comparison.compare(
            loops, told.paths, told.duration, seed=told.seed, tolerance=told.tolerance,
            after=told.after, threads=threads, progress=report,
        )  # fmt: skip
    name = getattr(told.loop.arm, "name", type(told.loop.arm).__name__)
    title = f"{name}: {against}"
    files = {} if out is None else comparison_files(dataset, title)
    for name, content in files.items():
        write_whole(cast(Path, out) / name, content)
    if as_json:
        _print_json(comparison_record(dataset))
    else:
        print_comparison(dataset, Console(highlight=False))


@app.command()
def bounds(
    experiment: OptionalFile = None,
    theta: Annotated[
        float, typer.Option(help="Bound of the squared norm of the network's weights.")
    ] = 0.0,
    eps: Annotated[float, typer.Option(help="Largest error of the network.")] = 0.0,
    pi1: Annotated[float, typer.Option(help="Largest filter error in rad/s.")] = 0.0,
    sigma: Annotated[
        float, typer.Option(help="Share of the decay that buys the first-entry time.")
    ] = 0.5,
    as_json: AsJson = False,
) -> None:
    """Say what Theorem 1 promises of a loop, in numbers, beside what a few paths do."""
    from rich.console import Console

    from ftcfa.experiment import load_experiment
    from ftcfa.report.bounds import bounds_record, print_bounds
    from ftcfa.study.reproduction import FINITE_TIME, closed_loop
    from ftcfa.theory.bounds import bounds as theorem1_bounds
    from ftcfa.theory.premises import theorem_paths

    loop = closed_loop(FINITE_TIME) if experiment is None else load_experiment(experiment).loop
    found = theorem1_bounds(loop, theta=theta, eps=eps, pi1=pi1, sigma=sigma)
    record = bounds_record(found, theorem_paths(loop, found))
    _print_json(record) if as_json else print_bounds(record, Console(highlight=False))


def _given(**options: Any) -> dict[str, Any]:
    """The options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def _specification(found: Any, options: dict[str, Any]) -> Any:
    """The file's specification with options in place of its values."""
    from ftcfa.errors import ParameterError
    from ftcfa.study.verification import Specification

    if found is not None:
        return replace(found, **options)
    if not options.keys() >= {"error", "within"}:
        raise ParameterError(
            "specification",
            "missing",
            "a table [specification] in the file with error and within",
            "or give --error and --within",
        )
    return Specification(**options)


def _check_threads(threads: int | None) -> None:
    from ftcfa.checks import counting

    if threads is not None:
        counting("--threads", threads)


@contextmanager
def _cluster(scheduler: str | None) -> Iterator[Any]:
    """A client of a Dask cluster, or None without an address."""
    from ftcfa.errors import FtcfaError, ParameterError

    if scheduler is None:
        yield None
        return
    try:
        import distributed
    except ImportError as error:
        raise FtcfaError(
            "--scheduler",
            "the package 'distributed' is not installed",
            "",
            "install it: pip install 'ftcfa[cluster]'",
        ) from error
    if not re.fullmatch(ADDRESS, scheduler):
        raise ParameterError("--scheduler", scheduler, "such as tcp://127.0.0.1:8786")
    try:
        client = distributed.Client(scheduler, timeout=SECONDS_TO_ANSWER)
    except OSError as error:
        raise ParameterError(
            "--scheduler",
            f"no answer from {scheduler} within {SECONDS_TO_ANSWER} s",
            "the address of a Dask scheduler that runs",
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=SECONDS_TO_ANSWER)
        except TimeoutError as error:
            raise ParameterError(
                "--scheduler", f"{scheduler} has no workers", "one or more", "start a dask worker"
            ) from error
        yield client


@contextmanager
def _progress_of_paths() -> Iterator[Callable[[int, int], None]]:
    """A bar with rate and time left on standard error, if that is a terminal.

    Yields what takes the paths done and the paths asked for; Ctrl-C waits for the end of a chunk.
    """
    from rich.progress import BarColumn, TextColumn

    with _bar(BarColumn(), TextColumn("{task.description}")) as progress:
        task = progress.add_task("paths", total=None)
        seen = deque([(time.monotonic(), 0)], maxlen=RECENT)

        def report(done: int, total: int) -> None:
            seen.append((time.monotonic(), done))
            told = _pace(done, total, seen[-1][0] - seen[0][0], done - seen[0][1])
            progress.update(task, completed=done, total=total, description=told)
            if _interrupted.is_set():
                raise KeyboardInterrupt

        yield report


def _pace(done: int, total: int, seconds: float, paths: int) -> str:
    """Paths done, rate and time left, from the paths of some seconds."""
    text = f"{done:,} of {total:,} paths"
    if not (seconds > 0 and paths > 0):
        return text
    minutes, rest = divmod(round((total - done) * seconds / paths), 60)
    hours, minutes = divmod(minutes, 60)
    rate = paths / seconds
    told = f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"
    return f"{text}, {told} paths/s, {hours}:{minutes:02}:{rest:02} left"


@contextmanager
def _progress(label: str, total: int) -> Iterator[Callable[[], None]]:
    """A bar on standard error, if that is a terminal; yields what advances it by one."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with _bar(*columns) as progress:
        task = progress.add_task(label, total=total)

        def advance(steps: int = 1) -> None:
            progress.advance(task, steps)
            if _interrupted.is_set():
                raise KeyboardInterrupt

        advance(0)
        yield advance


@contextmanager
def _bar(*columns: Any) -> Iterator[Any]:
    """A progress bar with the time elapsed, on standard error if that is a terminal.

    Within the block Ctrl-C waits for the end of the step, because CasADi would take the exception
    for a failure of its own; what reports a step raises it.
    """
    from rich.console import Console
    from rich.progress import Progress, TimeElapsedColumn

    console = Console(stderr=True)
    before = signal.signal(signal.SIGINT, _interrupt_after_step)
    try:
        with Progress(
            *columns, TimeElapsedColumn(), console=console, transient=True,
            disable=not console.is_terminal,
        ) as progress:  # fmt: skip
            yield progress
    finally:
        signal.signal(signal.SIGINT, before)


def _specifications(names: Sequence[str], table: Path | None) -> list[Any]:
    """Specifications by name, of those that come along or of a file; without names, all of it."""
    from ftcfa.errors import UnknownNameError
    from ftcfa.vibration.spectra.standards import read_table, standards

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
