"""What is wrong with a document: every fault with file, table and key."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn

from ftcfa.description.kinds import HOME, did_you_mean, one_of, shown
from ftcfa.errors import FtcfaError, ParameterError, UnknownNameError

Keys = tuple[str, ...]
"""Where something stands: the names of the tables on the way to it, then its key."""


class ExperimentError(FtcfaError):
    """All that is wrong with an experiment file or description.

    Args:
        errors: Each with file, table and key.
    """

    def __init__(self, errors: Iterable[FtcfaError]) -> None:
        self.errors = tuple(errors)
        first = self.errors[0]
        super().__init__(first.subject, first.got, first.expected, first.remedy)
        self.args = (self.errors,)

    def __str__(self) -> str:
        return "\n".join(map(str, self.errors))


class Broken(Exception):  # noqa: N818 (it never leaves the reader)
    """Something could not be made; why has been noted."""


class Faults:
    """Notes what is wrong with a document.

    Attributes:
        file: What messages call it.
        errors: What was noted.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self.errors: list[FtcfaError] = []

    def note(
        self, keys: Keys, got: str, wanted: str = "", remedy: str = "", table: bool = False
    ) -> None:
        """Note a fault at a key, or at a ``table``."""
        *tables, key = (*keys, "") if table else keys
        words = [f"[{'.'.join(tables)}]" if tables else "", key]
        place = " ".join(filter(None, words))
        subject = f"{self.file}: {place}" if place else self.file
        self.errors.append(ParameterError(subject, got, wanted, remedy))

    def fail(self, keys: Keys, got: str, wanted: str = "", remedy: str = "") -> NoReturn:
        """Note a fault, after which what stands there cannot be made."""
        self.note(keys, got, wanted, remedy)
        raise Broken

    def unknown_keys(
        self, told: Iterable[str], known: Iterable[str], keys: Keys, top: Iterable[str]
    ) -> None:
        """Note keys that are not known here, and those that stand at the top of a document."""
        for key in told:
            if key in known:
                continue
            remedy = did_you_mean(key, known)
            if keys and key in top:
                remedy = "it belongs at the top, before the first table"
            self.note((*keys, key), "unknown key", "" if remedy else one_of(known), remedy)

    def blame(
        self, error: FtcfaError, names: Sequence[str], told: Mapping[str, Any], keys: Keys
    ) -> None:
        """Note an error of a part at the one of some keys that it is about."""
        words = error.subject.replace(",", " ").split()
        named = [name for name in names if name in words]
        if isinstance(error, UnknownNameError):
            named = [name for name in names if told.get(name) == error.name] or named
        if len(names) == 1:
            named = list(names)
        if len(named) != 1:
            self.note(keys, str(error), table=True)
            return
        value = told.get(named[0])
        at, table = (*keys, named[0]), isinstance(value, dict)
        if isinstance(error, UnknownNameError) and error.name == value:
            remedy = did_you_mean(value, error.known)
            self.note(at, shown(value), one_of(error.known), remedy, table)
        elif words[-1] == named[0]:
            posture = isinstance(value, str) and error.expected == "numbers"
            wanted = f'numbers or "{HOME}"' if posture else error.expected
            self.note(at, error.got, wanted, error.remedy, table)
        else:
            self.note(at, str(error), table=table)


def refusal(call: Callable[..., Any], values: Mapping[str, Any]) -> FtcfaError | None:
    """The error of a call, if it raises one."""
    try:
        call(**values)
    except FtcfaError as error:
        return error
    return None


def guilty(
    call: Callable[..., Any],
    values: Mapping[str, Any],
    error: FtcfaError,
    names: Iterable[str],
    instead: Mapping[str, Any],
) -> str | None:
    """Of some values the one without which the error is gone, or at least another.

    Some cannot be left out but have a sound value ``instead``.
    """
    changed = None
    for name in (*names, *instead):
        others = {key: it for key, it in values.items() if key != name}
        rest = refusal(call, {**others, **({name: instead[name]} if name in instead else {})})
        if rest is None:
            return name
        if changed is None and str(rest) != str(error):
            changed = name
    return changed
