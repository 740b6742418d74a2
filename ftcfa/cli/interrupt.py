"""Ctrl-C: at once, or after the step that runs."""

from threading import Event
from typing import Any

interrupted = Event()
"""Set once Ctrl-C was pressed: libraries may swallow KeyboardInterrupt."""


def stop_at_once(*_: Any) -> None:
    """Handle the signal of Ctrl-C: stop at once."""
    interrupted.set()
    raise KeyboardInterrupt


def stop_after_step(*_: Any) -> None:
    """Handle the signal of Ctrl-C while steps are counted: stop after the step.

    The second Ctrl-C stops at once.
    """
    if interrupted.is_set():
        raise KeyboardInterrupt
    interrupted.set()
