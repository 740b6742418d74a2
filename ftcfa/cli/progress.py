"""Progress bars on standard error, shown if that is a terminal, and Ctrl-C.

Ctrl-C stops at once. A library may swallow the exception; then the next report of a step raises it
again.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event
from typing import Any

RECENT = 16
"""Number of reports from which the rate is computed."""
interrupted = Event()
"""Set once Ctrl-C was pressed: libraries may swallow KeyboardInterrupt."""


def stop_at_once(*_: Any) -> None:
    """Handle the signal of Ctrl-C: stop at once."""
    interrupted.set()
    raise KeyboardInterrupt


def obey() -> None:
    """Raise KeyboardInterrupt if Ctrl-C was pressed, but a library swallowed the exception."""
    if interrupted.is_set():
        raise KeyboardInterrupt


@contextmanager
def progress_of_steps(label: str, total: int) -> Iterator[Callable[..., None]]:
    """Show a bar with the number of steps done.

    Yields a function that advances it by one, and shows the text that it is given beside the label.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with _bar(*columns) as bar:
        task = bar.add_task(label, total=total)

        def advance(text: str = "") -> None:
            bar.update(task, advance=1, description=f"{label}, {text}" if text else label)
            obey()

        obey()
        yield advance


@contextmanager
def progress_of_paths() -> Iterator[Callable[[int, int], None]]:
    """Show a bar with rate and time left; yields a function of the paths done and the total."""
    from rich.progress import BarColumn, TextColumn

    with _bar(BarColumn(), TextColumn("{task.description}")) as bar:
        task = bar.add_task("paths", total=None)
        seen = deque([(time.monotonic(), 0)], maxlen=RECENT)

        def report(done: int, total: int) -> None:
            seen.append((time.monotonic(), done))
            text = pace(done, total, seen[-1][0] - seen[0][0], done - seen[0][1])
            bar.update(task, completed=done, total=total, description=text)
            obey()

        yield report


def pace(done: int, total: int, seconds: float, paths: int) -> str:
    """Text with the paths done, their rate and the time left.

    Args:
        done: Number of paths done.
        total: Number of paths requested.
        seconds: Time over which the rate is taken [s].
        paths: Number of paths done in that time.
    """
    text = f"{done:,} of {total:,} paths"
    if not (seconds > 0 and paths > 0):
        return text
    minutes, rest = divmod(round((total - done) * seconds / paths), 60)
    hours, minutes = divmod(minutes, 60)
    rate = paths / seconds
    shown = f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"
    return f"{text}, {shown} paths/s, {hours}:{minutes:02}:{rest:02} left"


@contextmanager
def _bar(*columns: Any) -> Iterator[Any]:
    """Show a progress bar with the time elapsed."""
    from rich.console import Console
    from rich.progress import Progress, TimeElapsedColumn

    console = Console(stderr=True)
    with Progress(
        *columns, TimeElapsedColumn(), console=console, transient=True,
        disable=not console.is_terminal,
    ) as progress:  # fmt: skip
        yield progress
