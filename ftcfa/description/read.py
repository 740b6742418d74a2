"""From plain data back to the closed loop, or to everything that is wrong with the data at once."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, cast, get_args, get_origin

import numpy as np
import numpy.typing as npt

from ftcfa.description.faults import Broken, ExperimentError, Faults, Keys, guilty, refusal
from ftcfa.description.kinds import (
    HOME,
    did_you_mean,
    expected,
    fits,
    is_number,
    is_path,
    one_of,
    reads_as_number,
    shown,
)
from ftcfa.description.registry import (
    OTHERWISE,
    Parameter,
    alternatives,
    arm_loader,
    choices,
    element,
    parameters,
    spares,
    stand_ins,
)
from ftcfa.errors import FtcfaError, ShapeError
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.model.arm import Arm
from ftcfa.model.dynamics import Dynamics
from ftcfa.model.urdf.catalogue import catalogue

Made = TypeVar("Made")
Read = Callable[[Any, Keys], Any]
"""What reads something that stands at some keys, and raises `Broken` if it cannot."""


def rebuild(cls: type[Made], told: Mapping[str, Any], file: str, folder: Path) -> Made:
    """What a document tells of.

    Args:
        cls: `ClosedLoop`, or a dataclass with a field ``loop`` whose other fields stand in the
            document beside those of the loop.
        told: The document, such as `ftcfa.description.write.document` gives.
        file: What messages call it.
        folder: Where its relative paths count from.

    Raises:
        ExperimentError: If anything is wrong with it.
    """
    reader = _Reader(file, folder)
    made = reader.attempt(reader.document, cls, told)
    if reader.errors:
        raise ExperimentError(reader.errors)
    return cast(Made, made)


class _Reader(Faults):
    """Reads a document, noting what is wrong and going on.

    Attributes:
        folder: Where relative paths count from.
        arm: The true arm, once it is there.
        top: Keys that may stand at the top of the document.
    """

    def __init__(self, file: str, folder: Path) -> None:
        super().__init__(file)
        self.folder = folder
        self.arm: Any = None
        self.top: tuple[str, ...] = ()

    def document(self, cls: Callable[..., Any], told: Mapping[str, Any]) -> Any:
        """A loop, or what holds a loop and more."""
        of_loop = {
            name: it
            for name, it in parameters(ClosedLoop).items()
            if any(map(expected, alternatives(it.hint)))
        }  # what watches the paths is no part of an experiment
        own = {} if cls is ClosedLoop else parameters(cls)
        beside = [name for name in own if name != "loop"]
        self.top = (*beside, *of_loop)
        self.unknown_keys(told, self.top, (), self.top)
        given = {}
        if "arm" in told:
            self.arm = self.attempt(self.value, Dynamics, told["arm"], ("arm",))
            given = {"arm": self.arm}
        keys = {key: told[key] for key in of_loop if key in told}
        loop = self.attempt(self.part, ClosedLoop, of_loop, keys, (), given)
        if cls is ClosedLoop:
            return loop
        keys = {key: told[key] for key in beside if key in told}
        return self.part(cls, own, keys, (), {"loop": loop})

    def attempt(self, read: Callable[..., Any], *arguments: Any) -> Any:
        """What a method reads, or None if that is broken."""
        try:
            return read(*arguments)
        except Broken:
            return None

    def value(self, hint: Any, told: Any, keys: Keys) -> Any:
        """A value of a type."""
        allowed = sorted(alternatives(hint), key=is_path, reverse=True)
        fitting = [one for one in allowed if fits(one, told)]
        if not fitting:
            words = dict.fromkeys(filter(None, map(expected, allowed)))
            self.fail(keys, shown(told), " or ".join(words))
        one = fitting[0]
        if one is npt.ArrayLike:
            return self.numbers(told, keys)
        if get_origin(one) is np.ndarray:
            return self.array(told, keys)
        if get_origin(one) is Literal:
            return self.word(get_args(one), told, keys)
        if is_path(one):
            return self.path(told)
        if isinstance(told, list):
            return self.sequence(one, told, keys)
        if isinstance(told, dict):
            return self.table(hint, told, keys) if choices(hint) else self.mapping(one, told, keys)
        return float(told) if one is float else told

    def numbers(self, told: Any, keys: Keys) -> Any:
        """Numbers in lists in lists, as they stand; `HOME` is a row of them."""
        if isinstance(told, list):
            return self.each(self.numbers, told, keys)
        if told == HOME:
            if self.arm is None:
                raise Broken
            return self.arm.home.tolist()
        if isinstance(told, str) and not reads_as_number(told):
            return told  # such as a mounting's name; what takes only numbers will say so
        if not is_number(told):
            self.fail(keys, shown(told), "numbers")
        return float(told)

    def array(self, told: Any, keys: Keys) -> Any:
        """Numbers as an array."""
        rows = self.numbers(told, keys)
        try:
            return np.array(rows, dtype=float)
        except ValueError:
            self.fail(keys, shown(told), "numbers in rows of one length")

    def word(self, known: tuple[Any, ...], told: Any, keys: Keys) -> Any:
        """One of some words."""
        if told not in known:
            self.fail(keys, shown(told), one_of(known), did_you_mean(told, known))
        return told

    def path(self, told: str) -> str:
        """A path counts from the folder; a bare word that is no file there may be a name."""
        path = self.folder / Path(told).expanduser()
        named = told in catalogue() or "://" in told
        bare = len(Path(told).parts) == 1 and not Path(told).suffix and not path.exists()
        return told if named or bare else str(path)

    def sequence(self, one: Any, told: list[Any], keys: Keys) -> tuple[Any, ...]:
        """Entries of one type, or as many as the type says."""
        hints = get_args(one)
        if get_origin(one) is tuple and Ellipsis not in hints and len(told) != len(hints):
            self.fail(keys, f"{len(told)} entries", f"{len(hints)}")
        return tuple(self.each(self.of(element(one)), told, keys))

    def each(self, read: Read, told: list[Any], keys: Keys) -> list[Any]:
        """What is read of every entry."""
        *tables, key = keys
        made = [self.attempt(read, it, (*tables, f"{key}[{i}]")) for i, it in enumerate(told)]
        if any(it is None for it in made):
            raise Broken
        return made

    def mapping(self, one: Any, told: dict[str, Any], keys: Keys) -> dict[str, Any]:
        """Values of one type by names that are free."""
        read = self.of(element(one))
        made = {key: self.attempt(read, it, (*keys, key)) for key, it in told.items()}
        if any(it is None for it in made.values()):
            raise Broken
        return made

    def of(self, hint: Any) -> Read:
        """What reads values of a type."""
        return lambda told, keys: self.value(hint, told, keys)

    def table(self, hint: Any, told: dict[str, Any], keys: Keys) -> Any:
        """A part."""
        cls = self.type_of(choices(hint), told, keys)
        rest = {key: value for key, value in told.items() if key != "type"}
        if cls is Arm:
            call, known = arm_loader(rest)
            return self.part(call, known, rest, keys, {})
        key, otherwise = OTHERWISE.get(cls, ("", cls))
        call = otherwise if key in rest else cls
        return self.part(call, parameters(call), rest, keys, {})

    def type_of(self, classes: tuple[type, ...], told: dict[str, Any], keys: Keys) -> type:
        """The part that a table is of: by its type, or the one that goes without saying."""
        by_name = {cls.__name__: cls for cls in classes}
        name = told.get("type")
        if name is None and (Arm in classes or len(classes) == 1):
            return classes[0]
        if name is None:
            self.fail((*keys, "type"), "missing", one_of(by_name))
        if not isinstance(name, str) or name not in by_name:
            self.fail((*keys, "type"), shown(name), one_of(by_name), did_you_mean(name, by_name))
        return by_name[name]

    def part(
        self,
        call: Callable[..., Any],
        known: Mapping[str, Parameter],
        told: Mapping[str, Any],
        keys: Keys,
        given: Mapping[str, Any],
    ) -> Any:
        """What a class or function makes of a table; ``given`` has been read, None if broken."""
        if keys:
            self.unknown_keys(told, known, keys, self.top)
        sound, lacking = {}, False
        for name, parameter in known.items():
            asked = name in told or name in given or parameter.required
            value = self.argument(name, parameter, told, keys, given) if asked else None
            if value is not None or not (asked or parameter.default):
                sound[name] = value
            lacking |= asked and value is None
        if not lacking:
            try:
                return call(**sound)
            except FtcfaError:
                pass  # why is what the probe finds out
        self.probe(call, known, sound, told, keys, lacking)
        raise Broken

    def argument(
        self,
        name: str,
        parameter: Parameter,
        told: Mapping[str, Any],
        keys: Keys,
        given: Mapping[str, Any],
    ) -> Any:
        """What a part is given under one name, None if that is broken."""
        if name in given:
            return given[name]
        if name in told:
            return self.attempt(self.value, parameter.hint, told[name], (*keys, name))
        if parameter.hint is Dynamics and keys:
            return self.arm  # a law's nominal arm is the true one
        words = dict.fromkeys(filter(None, map(expected, alternatives(parameter.hint))))
        table = bool(choices(parameter.hint))
        self.note((*keys, name), "missing", " or ".join(words), table=table)
        return None

    def probe(
        self,
        call: Callable[..., Any],
        known: Mapping[str, Parameter],
        sound: Mapping[str, Any],
        told: Mapping[str, Any],
        keys: Keys,
        lacking: bool,
    ) -> None:
        """Note what a part refuses of the values that could be read, one after the other.

        Once something is ``lacking``, what may be refused only because of that is left aside, and
        so is what is refused only because of the value that stands in for a required one.
        """
        required = {name: it for name, it in known.items() if it.required}
        spare, away = spares(required), set[str]()
        if not sound.keys() >= required.keys():
            plain = {k: it for k, it in sound.items() if not isinstance(told.get(k, {}), dict)}
            away = spare.keys() - sound.keys()
            sound = {**plain, **stand_ins(required), **{k: spare[k][0] for k in away}}
            if not sound.keys() >= required.keys():
                return
        while (error := refusal(call, sound)) is not None:
            optional = [key for key in sound if key not in required]
            instead = {key: it for key, (it, _) in spare.items() if key not in away}
            name = guilty(call, sound, error, optional, instead)
            other = refusal(call, {**sound, **{key: spare[key][1] for key in away}})
            genuine = str(other) == str(error)
            if name is None:
                if genuine and (not lacking or isinstance(call, type)):
                    self.blame(error, list(required), told, keys)
                return
            follows = isinstance(error, ShapeError) or isinstance(told[name], dict)
            if genuine and not (lacking and follows):
                self.blame(error, list(required) if name in spare else [name], told, keys)
            lacking = True
            sound = {key: it for key, it in sound.items() if key != name}
            if name in spare:
                away = {*away, name}
                sound[name] = spare[name][0]
