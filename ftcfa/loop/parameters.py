"""Parameters of a loop by dotted name, such as ``controller.gains.c1`` or ``arm.inertias``.

A name leads from the loop through the fields of its parts to a parameter that the last part
declares in its ``varies``. Beside its fields the loop has the part ``process``, the excitation
over its integration steps.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ftcfa.arrays import Array
from ftcfa.checks import numbers
from ftcfa.errors import ParameterError, ShapeError, TracingError, UnknownNameError
from ftcfa.hardware.delay import whole_steps
from ftcfa.loop.closed_loop import ClosedLoop
from ftcfa.parts import cached, fields_of, parameters_of, with_fields

SHARED = ("reference", "period", "substeps", "integrator", "uncertainty", "spread")
"""Fields of a loop that all paths of a run have in common."""


def parameter(loop: ClosedLoop, name: str) -> Array:
    """Value of a parameter as a float array.

    Raises:
        UnknownNameError: If the loop has no such parameter; it lists those it has.
        ParameterError: If the name stands for something else than numbers that may vary.
    """
    holder, word = _holder(loop, name)
    value = getattr(holder, word)
    subject = f"parameter {name}"
    if value is None:
        raise ParameterError(subject, "not given", "numbers that can be replaced")
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ParameterError(subject, f"a {type(value).__name__}", "numbers") from error


def checked_values(
    loop: ClosedLoop, vary: Mapping[str, npt.ArrayLike], paths: int
) -> dict[str, Array]:
    """Values of varied parameters, each of shape (paths, ...), checked as their parts declare.

    Raises:
        UnknownNameError, ParameterError, ShapeError: If a name, value or shape is wrong.
    """
    return {name: _checked(loop, name, given, paths) for name, given in vary.items()}


def with_parameters(loop: ClosedLoop, values: Mapping[str, Any]) -> ClosedLoop:
    """A copy of a loop with other values of some parameters, unchecked: they may be symbols."""
    own = {name: value for name, value in values.items() if not name.startswith("process.")}
    changed: ClosedLoop = _replaced(loop, own)
    rest = {name.removeprefix("process."): v for name, v in values.items() if name not in own}
    return changed.with_process(_replaced(changed.process, rest)) if rest else changed


def preparation(twin: ClosedLoop, name: str) -> Callable[[Array], Array]:
    """Function that turns values of a parameter, shape (paths, ...), into inputs of compiled code.

    Args:
        twin: The loop's twin for tracing.
        name: The parameter.

    Raises:
        TracingError: If the parameter is a constant of compiled code.
    """
    *words, last = name.split(".")
    holder: Any = twin
    for word in words:
        holder = getattr(holder, word)
    if last not in parameters_of(holder):
        got, remedy = "a constant of compiled code", 'use engine="interpreted"'
        raise TracingError(f"parameter {name}", got, "", remedy)
    prepare = parameters_of(holder)[last].prepare
    return (lambda values: values) if prepare is None else partial(prepare, holder)


def _holder(loop: ClosedLoop, name: str) -> tuple[Any, str]:
    """Part that declares a parameter, and the parameter's name in that part."""
    *words, last = name.split(".")
    part: Any = loop
    above = "loop"
    for word in words:
        if word not in _parts(part) or _parts(part)[word] is None:
            raise _no_parameter(part, above, name, word)
        part, above = getattr(part, word), word
    if last not in parameters_of(part):
        raise _no_parameter(part, above, name, last)
    return part, last


def _parts(part: Any) -> dict[str, Any]:
    """Parts of a part that the name of a parameter can lead through, by name."""
    inside = fields_of(part)
    if isinstance(part, ClosedLoop):
        inside = {name: inside[name] for name in inside if name not in SHARED}
        inside["process"] = part.process
    return inside


def _known(part: Any) -> list[str]:
    """Names of the parameters of a part, and of the parts in it that have parameters."""
    inside = [name for name, value in _parts(part).items() if _known(value)]
    return sorted({*parameters_of(part), *inside})


def _no_parameter(part: Any, above: str, name: str, word: str) -> Exception:
    """Error that says why a word of a name leads to no parameter."""
    subject, kind, known = f"parameter {name}", type(part).__name__, _known(part)
    if isinstance(part, ClosedLoop) and word in SHARED:
        expected, remedy = "another parameter", "make a loop for each"
        return ParameterError(f"varied {name}", "common to all paths", expected, remedy)
    if word in known:
        inside = ", ".join(f"{name}.{inner}" for inner in _known(getattr(part, word)))
        got = f"a {type(getattr(part, word)).__name__}"
        return ParameterError(subject, got, "numbers", f"try {inside}")
    if not known:
        got, expected = "declares no parameters", f"a frozen dataclass that declares {word}"
        remedy = f'write varies = number_fields("{word}") into it'
        return ParameterError(subject, f"{kind} {got}", expected, remedy)
    if word.startswith("_") or not hasattr(part, word):
        return UnknownNameError(f"{subject}: {above}", word, known)
    if getattr(part, word) is None:
        return ParameterError(subject, "not given", "numbers that can be replaced")
    got, expected = "fixed, or computed from others", f"one of: {', '.join(known)}"
    remedy = f"{kind}.varies declares what may differ from path to path"
    return ParameterError(subject, got, expected, remedy)


def _checked(loop: ClosedLoop, name: str, given: npt.ArrayLike, paths: int) -> Array:
    """Values of one varied parameter, checked."""
    subject, shape = f"varied {name}", (paths, *parameter(loop, name).shape)
    values = numbers(subject, given)
    if values.shape != shape:
        raise ShapeError(subject, f"shape {values.shape}", f"shape {shape}")
    if not np.all(np.isfinite(values)):
        raise ParameterError(subject, "values that are not finite", "finite numbers")
    part: Any = loop
    *words, last = name.split(".")
    for word in words:
        part = getattr(part, word)
        _check_can_vary(name, part)
    declared = parameters_of(part)[last]
    declared.check(part, values)
    if declared.whole_steps:
        whole_steps(subject, np.unique(values), loop.step_length)
    return values


def _check_can_vary(name: str, part: Any) -> None:
    """Raise ParameterError if no copy of a part can be made with another value.

    That is so if it is no dataclass or NamedTuple, or has attributes that it may have computed
    from its fields when it was made.
    """
    subject, kind = f"varied {name}", type(part).__name__
    if not fields_of(part):
        got, remedy = f"{kind} has no fields", "write @dataclass(frozen=True) above it"
        raise ParameterError(subject, got, "a frozen dataclass", remedy)
    derived = getattr(part, "__dict__", {}).keys() - fields_of(part).keys() - cached(part)
    if derived:
        got = f"{kind} computed {', '.join(sorted(derived))} when it was made"
        remedy = "make it a cached_property, or make a loop for each value"
        raise ParameterError(subject, got, "a part that computes it when it is needed", remedy)


def _replaced(part: Any, values: Mapping[str, Any]) -> Any:
    """A copy of a part with other values of parameters, its own and those of the parts in it."""
    inside: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        word, _, rest = name.partition(".")
        if rest:
            inside.setdefault(word, {})[rest] = value
        else:
            part = parameters_of(part)[word].replace(part, value)
    changes = {word: _replaced(getattr(part, word), inner) for word, inner in inside.items()}
    return with_fields(part, changes) if changes else part
