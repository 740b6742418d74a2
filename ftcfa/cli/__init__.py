"""The command line, thin: each command imports what it needs only when it runs.

Exit status: 0 done, 1 the answer is no and nothing else, 2 bad input (one sentence for each fault
on standard error), 3 undecided within the budget, 70 a fault of ours, 130 interrupted, 141 the
reader of the output has gone. A warning is one line on standard error.
"""

import atexit
import gc
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any

import typer

from ftcfa.cli.ending import ClosedPipe
from ftcfa.cli.progress import interrupted, stop_at_once

COMMANDS = (
    "ftcfa.cli.commands.new:new",
    "ftcfa.cli.commands.inspect:inspect",
    "ftcfa.cli.commands.reproduce:reproduce",
    "ftcfa.cli.commands.vibration:vibration",
    "ftcfa.cli.commands.hardware:hardware",
    "ftcfa.cli.commands.run:run",
    "ftcfa.cli.commands.verify:verify",
    "ftcfa.cli.commands.compare:compare",
    "ftcfa.cli.commands.bounds:bounds",
    "ftcfa.cli.commands.tune:tune",
)
"""The function of every command as ``module:function``, in the order of ``ftcfa --help``."""

app = typer.Typer(
    name="ftcfa",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in COMMANDS:
    app.command()(resolve_name(command))


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line with the words after ``ftcfa``, by default the process's, and exit."""
    from ftcfa.errors import FtcfaError

    atexit.register(gc.freeze)  # Python's last search for garbage takes 0.4 s
    before = signal.signal(signal.SIGINT, stop_at_once)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            app(args=None if arguments is None else list(arguments), prog_name="ftcfa")
    except (Exception, KeyboardInterrupt) as error:
        if interrupted.is_set():
            sys.exit(130)
        if isinstance(error, ClosedPipe):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for Python's own end
            sys.exit(141)
        known = isinstance(error, FtcfaError | OSError)
        for line in (str(error) if known else _fault(error)).splitlines():
            print(f"ftcfa: {line}", file=sys.stderr)
        sys.exit(2 if known else 70)
    finally:
        signal.signal(signal.SIGINT, before)
        interrupted.clear()


def _fault(error: BaseException) -> str:
    """One sentence about an error that no input should cause."""
    from ftcfa.errors import plain, shortened

    place = traceback.extract_tb(error.__traceback__)[-1]
    what = plain(shortened(f"{type(error).__name__}: {error}"))
    where = f"{Path(place.filename).name}, line {place.lineno}"
    return f"a fault of ours, not of your input ({what}; {where}); please report this line"


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning for a reader, without the line of code that gave it."""
    print(f"ftcfa: warning: {message}", file=sys.stderr)


VERSION = "Print the version and exit."


def _print_version(required: bool) -> None:
    if required:
        print(f"ftcfa {version('ftcfa')}")
        raise typer.Exit


@app.callback()
def _common(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help=VERSION)
    ] = False,
) -> None:
    """Robust control of robot arms whose base shakes at random."""
