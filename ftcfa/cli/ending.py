"""The end of every command: its files are written, then its record is printed."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


class ClosedPipe(Exception):  # noqa: N818 (no error: the reader has seen enough)
    """The reader of the standard output has gone, as ``head`` and ``grep -q`` do."""


def finish(
    record: Mapping[str, Any],
    show: Callable[[Any, "Console"], None],
    as_json: bool,
    files: Mapping[str, bytes] | None = None,
    out: Path | None = None,
) -> None:
    """Write the files of a command, then print its record for a program or for a reader.

    Args:
        record: What the command says, as plain data.
        show: Function that prints the record on a console for a reader.
        as_json: Print the record as one JSON object instead, with the paths of the files.
        files: Contents by name; None for a command that writes none.
        out: Folder of the files; None if the user gave none.
    """
    from ftcfa.files import write_whole

    written = {} if files is None or out is None else {out / name: files[name] for name in files}
    for file, content in written.items():
        write_whole(file, content)
    try:
        if as_json:
            listed = {} if files is None else {"files": [str(file) for file in written]}
            print(json.dumps({**record, **listed}, indent=2, allow_nan=False))
        else:
            _show(record, show, written, out)
        sys.stdout.flush()
    except BrokenPipeError as error:
        raise ClosedPipe from error


def _show(
    record: Mapping[str, Any],
    show: Callable[[Any, "Console"], None],
    written: Mapping[Path, bytes],
    out: Path | None,
) -> None:
    """Print a record for a reader, and the names of the files."""
    from rich.console import Console

    from ftcfa.report.terminal import print_line

    class Terminal(Console):
        def on_broken_pipe(self) -> None:
            raise ClosedPipe

    console = Terminal(highlight=False)
    show(record, console)
    if written:
        names = ", ".join(file.name for file in written)
        print_line(f"\n{len(written)} files in {out}: {names}", console)
