"""The exception tree: every error says what, what was got, what was expected, and the remedy."""

from collections.abc import Iterable


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
        sentence = f"{self.subject}: {self.got}"
        if self.expected:
            sentence += f", expected {self.expected}"
        if self.remedy:
            sentence += f"; {self.remedy}"
        return sentence


class UrdfError(FtcfaError):
    """A URDF that cannot be read, or that no fixed-base arm can be made of."""


class ParameterError(FtcfaError):
    """A parameter outside its admissible range or of the wrong type."""


class ShapeError(FtcfaError):
    """An array of the wrong shape."""


class TracingError(FtcfaError):
    """Code that cannot be compiled, or that disagrees with Pinocchio when traced."""


class UnknownNameError(FtcfaError):
    """A name that is not among the known ones."""

    def __init__(self, kind: str, name: str, known: Iterable[str], *, field: str = "") -> None:
        known = tuple(known)
        expected = f"one of: {', '.join(known)}"
        super().__init__(f"{kind} '{name}'", "unknown name", expected, field=field)
        self.args = (kind, name, known)
        self.name = name
        self.known = known
