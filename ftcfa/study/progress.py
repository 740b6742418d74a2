"""Progress of a study, and its interruption: the exception that carries what is done."""

from collections.abc import Callable
from typing import Any, TypeAlias

Progress: TypeAlias = Callable[[int, int], None]
"""Called with the number of paths that are done and the number of all."""


class Interrupted(KeyboardInterrupt):
    """A study was interrupted, such as by Ctrl-C, before all its paths were run.

    As a KeyboardInterrupt it passes ``except Exception`` and ends a script that does not handle it.

    Args:
        study: What was interrupted, such as ``"ensemble"``.
        partial: What the study would have returned for the paths that are done, or None if that
            is nothing yet.
    """

    def __init__(self, study: str, partial: Any = None) -> None:
        left = "nothing is done" if partial is None else "what is done is in its attribute partial"
        super().__init__(f"{study} interrupted; {left}")
        self.partial = partial
