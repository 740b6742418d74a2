"""The exception tree: every error says what, what was got, what was expected, and the remedy."""

import difflib
import unicodedata
from collections.abc import Iterable, Mapping

LONGEST = 400
"""Characters of one part of a sentence; its middle is left out beyond."""
UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
"""Unicode's categories of control characters, bidirectional marks and line separators."""


class FtcfaError(Exception):
    """Base of all errors that a user's input can cause.

    Args:
        subject: What is wrong, such as ``arm.urdf: link 'forearm'``.
        got: What stands there.
        expected: What should stand there.
        remedy: What the user can do about it.
        field: Name of the constructor's argument that is at fault, if it is one of them; dotted if
            the fault is in a part of the argument, such as ``specification.within``.
    """

    def __init__(
        self, subject: str, got: str, expected: str = "", remedy: str = "", *, field: str = ""
    ) -> None:
        super().__init__(subject, got, expected, remedy)
        self.field = field
        self.subject = subject
        self.got = got
        self.expected = expected
        self.remedy = remedy

    def __str__(self) -> str:
        sentence = f"{shortened(self.subject)}: {shortened(self.got)}"
        if self.expected:
            sentence += f", expected {self.expected}"
        if self.remedy:
            sentence += f"; {self.remedy}"
        return plain(sentence)


class UrdfError(FtcfaError):
    """A URDF that cannot be read, or that no fixed-base arm can be made of."""


class ParameterError(FtcfaError):
    """A parameter outside its admissible range or of the wrong type."""


class ShapeError(FtcfaError):
    """An array of the wrong shape."""


class TracingError(FtcfaError):
    """Code that cannot be compiled, or that disagrees with Pinocchio when traced."""


class UnknownNameError(FtcfaError):
    """A name that is not among the known ones; the remedy is the nearest of them."""

    def __init__(self, kind: str, name: str, known: Iterable[str], *, field: str = "") -> None:
        known = tuple(known)
        remedy = did_you_mean(name, known)
        super().__init__(f"{kind} '{name}'", "unknown name", one_of(known), remedy, field=field)
        self.args = (kind, name, known)
        self.name = name
        self.known = known


class CompoundError(FtcfaError):
    """All that is wrong with a file, in the file's order.

    Args:
        errors: Each with its place in the file.
    """

    def __init__(self, errors: Iterable[FtcfaError]) -> None:
        self.errors = tuple(errors)
        first = self.errors[0]
        super().__init__(first.subject, first.got, first.expected, first.remedy, field=first.field)
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(map(str, self.errors))


class ExperimentError(CompoundError):
    """All that is wrong with an experiment file or description."""


class CompoundUrdfError(CompoundError, UrdfError):
    """All that is wrong with a URDF, where it is more than one thing."""


def plain(text: str) -> str:
    """A text in one line, as it is written: what a terminal would obey or turn is escaped."""
    return "".join(
        character.encode("unicode_escape").decode()
        if unicodedata.category(character) in UNSEEN
        else character
        for character in text
    )


def shortened(text: str) -> str:
    """A text without its middle if it is longer than LONGEST."""
    half = LONGEST // 2
    return text if len(text) <= LONGEST else f"{text[:half]}...{text[-half:]}"


def one_of(known: Iterable[object]) -> str:
    """The known names as what is expected."""
    return f"one of: {', '.join(map(str, known))}"


def did_you_mean(name: object, known: Iterable[str] | Mapping[str, str]) -> str:
    """The nearest of the known names as a remedy, with its unit where they are given with units.

    Small letters and capitals are the same; nothing if no name is near.
    """
    folded = {one.lower(): one for one in known}
    near = difflib.get_close_matches(str(name).lower(), folded, n=1)
    if not near:
        return ""
    one = folded[near[0]]
    unit = known[one] if isinstance(known, Mapping) else ""
    return f"did you mean '{one}'{unit and f' [{unit}]'}?"
