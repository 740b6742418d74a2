"""Checks of a user's numbers, and the check that each field of a part declares.

A check is a function of a subject and a value (and a unit, where the value has one) that raises a
`FtcfaError` if the value is wrong. The field of a part, a frozen dataclass, declares its check
with its type:

    c1: Annotated[float, Check(positive, "1/s")] = 7.5

A part is checked when it is made (`ftcfa.parts.Part`); a reader of files calls `check_field` for
each value before, so that it can report all that are wrong.
"""

import math
import types
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from numbers import Integral, Real
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.errors import FtcfaError, ParameterError, ShapeError, UnknownNameError


class Check(NamedTuple):
    """The check that a field declares, and the unit of its value."""

    function: Callable[..., Any]
    """Called with the subject of a message, the value and the unit, if there is one; raises a
    FtcfaError."""
    unit: str = ""
    """Unit of the value, such as ``rad/s``; empty where it has none."""
    search: tuple[float, float] | None = None
    """Smallest and largest value that a tuner tries; None for what is not to be tuned."""

    def run(self, subject: str, value: Any) -> None:
        """Raise a FtcfaError if a value is wrong."""
        self.function(subject, value, *filter(None, [self.unit]))


def check_fields(part: Any) -> None:
    """Check every field of a dataclass as it declares.

    Raises:
        FtcfaError: For the first field that is wrong; it carries the field's name.
    """
    cls: Any = type(part)
    for name in declared(cls):
        check_field(cls, name, getattr(part, name))


def check_field(part: type, name: str, value: Any, subject: str = "") -> None:
    """Check one value as the field of a dataclass declares; a field without a check takes any.

    A `Literal` is a check by itself. None is right where the type allows it.

    Args:
        part: The dataclass.
        name: Name of the field.
        value: Its value.
        subject: How messages name the value; ``Gains c1`` by default.

    Raises:
        FtcfaError: If the value is wrong; it carries the field's name.
    """
    if name not in declared(part):
        return
    check, optional = declared(part)[name]
    if value is None and optional:
        return
    with about(name):
        check.run(subject or f"{part.__name__} {name}", value)


@contextmanager
def about(field: str) -> Iterator[None]:
    """Errors inside are about a field, or about a field of the part that it holds."""
    try:
        yield
    except FtcfaError as error:
        error.field = f"{field}.{error.field}" if error.field else field
        raise


@cache
def declared(part: Any) -> dict[str, tuple[Check, bool]]:
    """The checks that the fields of a dataclass declare, by name, and whether None is right."""
    checks: dict[str, tuple[Check, bool]] = {}
    for name, hint in get_type_hints(part, include_extras=True).items():
        if get_origin(hint) is Literal:
            checks[name] = (Check(_word(get_args(hint))), False)
        elif get_origin(hint) is Annotated:
            kind, check = get_args(hint)
            checks[name] = (check, types.NoneType in get_args(kind))
    return checks


def _word(known: tuple[str, ...]) -> Callable[[str, Any], None]:
    """The check of a `Literal`."""
    return lambda subject, value: known_name(subject, value, known)


def known_name(subject: str, value: Any, known: Iterable[str], *, field: str = "") -> None:
    """Raise UnknownNameError unless a value is one of the known names."""
    names = tuple(known)
    if not (isinstance(value, str) and value in names):
        raise UnknownNameError(subject, str(value), names, field=field)


def flag(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value is True or False."""
    if not isinstance(value, bool):
        raise ParameterError(subject, repr(value), "True or False")


def having(method: str, expected: str) -> Callable[[str, Any], None]:
    """The check that a part has a method, such as ``mass_matrix`` of an arm."""

    def check(subject: str, part: Any) -> None:
        if isinstance(part, type):
            raise ParameterError(subject, f"the class {part.__name__} itself", expected)
        if not hasattr(part, method):
            raise ParameterError(subject, f"a {type(part).__name__}", expected)

    return check


def of_type(cls: type, expected: str) -> Callable[[str, Any], None]:
    """The check that a part is of a class."""

    def check(subject: str, part: Any) -> None:
        if not isinstance(part, cls):
            raise ParameterError(subject, f"a {type(part).__name__}", expected)

    return check


def is_number(value: Any) -> bool:
    """Whether a value is a finite real number; True and False are not."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond the range of floats
        return False


def is_integer(value: Any) -> bool:
    """Whether a value is an integer; True and False are not."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def number(subject: str, value: Any, unit: str = "") -> None:
    """Raise ParameterError unless a value is a finite number."""
    if not is_number(value):
        raise ParameterError(subject, repr(value), _with_unit("a finite number", unit))


def positive(subject: str, value: Any, unit: str = "", *, field: str = "") -> None:
    """Raise ParameterError unless a value is a finite number above zero."""
    if not (is_number(value) and value > 0):
        raise ParameterError(subject, repr(value), _with_unit("a number > 0", unit), field=field)


def positive_or_infinite(subject: str, value: Any, unit: str = "") -> None:
    """Raise ParameterError unless a value is a number above zero, or infinity."""
    if value != math.inf:
        positive(subject, value, unit)


def not_negative(subject: str, value: Any, unit: str = "") -> None:
    """Raise ParameterError unless a value is a finite number, zero or above."""
    if not (is_number(value) and value >= 0):
        raise ParameterError(subject, repr(value), _with_unit("a number >= 0", unit))


def probability(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value lies strictly between 0 and 1."""
    if not (is_number(value) and 0 < value < 1):
        percent = is_number(value) and 1 < value < 100
        remedy = f"give {value / 100:g} for {value:g} percent" if percent else ""
        raise ParameterError(subject, repr(value), "a number between 0 and 1", remedy)


def counting(subject: str, value: Any) -> None:
    """Raise ParameterError unless a value is an integer >= 1."""
    if not (is_integer(value) and value >= 1):
        raise ParameterError(subject, repr(value), "an integer >= 1")


def counting_to(most: int) -> Callable[[str, Any], None]:
    """The check that a value is an integer from 1 to a largest one."""

    def check(subject: str, value: Any) -> None:
        counting(subject, value)
        if value > most:
            raise ParameterError(subject, f"{value:.4g}", f"at most {most:,}")

    return check


def natural(subject: str, value: Any) -> int:
    """A seed or the number of a path as a plain integer.

    Raises:
        ParameterError: Unless it is an integer that 64 bits hold.
    """
    if not (is_integer(value) and 0 <= value < 2**64):
        raise ParameterError(subject, repr(value), "an integer from 0 to 2^64 - 1")
    return int(value)


def numbers(
    subject: str, values: npt.ArrayLike, expected: str = "numbers", *, field: str = ""
) -> Array:
    """A new float array of the values, of any shape, finite or not.

    Raises:
        ParameterError: If an entry is no number, or rows differ in length.
    """
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(subject, repr(values), expected, field=field) from error


def finite_numbers(subject: str, values: npt.ArrayLike, unit: str = "") -> None:
    """Raise a FtcfaError unless the values are a finite number or a list of them."""
    _check_each(subject, values, np.isfinite, _with_unit("finite numbers", unit))


def positive_numbers(subject: str, values: npt.ArrayLike, unit: str = "") -> None:
    """Raise a FtcfaError unless the values are a finite number > 0 or a list of them."""
    if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray):
        return positive(subject, values, unit)
    expected = _with_unit("numbers > 0", unit)
    _check_each(subject, values, lambda x: np.isfinite(x) & (x > 0), expected)
    return None


def not_negative_numbers(subject: str, values: npt.ArrayLike, unit: str = "") -> None:
    """Raise a FtcfaError unless the values are a finite number >= 0 or a list of them."""
    expected = _with_unit("numbers >= 0", unit)
    _check_each(subject, values, lambda x: np.isfinite(x) & (x >= 0), expected)


def positive_or_infinite_numbers(subject: str, values: npt.ArrayLike, unit: str = "") -> None:
    """Raise a FtcfaError unless the values are a number > 0, infinity too, or a list of them."""
    expected = _with_unit("numbers > 0, or infinity", unit)
    _check_each(subject, values, lambda x: x > 0, expected)


def _check_each(
    subject: str,
    values: npt.ArrayLike,
    admissible: Callable[[Array], npt.NDArray[np.bool_]],
    expected: str,
) -> None:
    array = numbers(subject, values, expected)
    if array.ndim > 1 or array.size == 0:
        raise ShapeError(subject, f"shape {array.shape}", "a number or a list of numbers")
    if not np.all(admissible(array)):
        raise ParameterError(subject, f"{array.tolist()}", expected)


def vector(subject: str, values: npt.ArrayLike, n: int, *, field: str = "") -> Array:
    """A finite float vector of length n; a scalar is repeated.

    Raises:
        ShapeError: If ``values`` is not numeric, not finite, or of another shape.
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(subject, repr(values), f"a number or {n} numbers", field=field) from error
    if array.shape not in ((), (n,)):
        got = f"shape {array.shape}"
        raise ShapeError(subject, got, f"a number or shape ({n},)", field=field)
    if not np.all(np.isfinite(array)):
        raise ShapeError(subject, repr(values), "finite numbers", field=field)
    return np.broadcast_to(array, (n,)).copy()


def _with_unit(expected: str, unit: str) -> str:
    return f"{expected} [{unit}]" if unit else expected
