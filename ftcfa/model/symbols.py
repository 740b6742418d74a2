"""Symbols in place of numbers: CasADi expressions that follow NumPy's semantics and have no value.

Laws written for numbers run on them unchanged, once, and leave their arithmetic as expressions.
"""

from collections.abc import Iterator
from typing import Any, cast

import casadi as ca
import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

from ftcfa.arrays import Traceable


class SymbolArray(NDArrayOperatorsMixin):
    """A `casadi.ArrayInterface` whose entries cannot be converted to floats.

    CasADi's own symbols convert to NaN, so that ``math.sin(q[0])`` would go unnoticed in a law
    that is being traced. Operators, NumPy's functions and all methods act on the expression
    inside; their results are wrapped again.

    Args:
        expression: The array of symbols, expressions or numbers.
    """

    def __init__(self, expression: ca.ArrayInterface) -> None:
        self._expression = expression

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if kwargs.get("out") and isinstance(kwargs["out"][0], SymbolArray):
            del kwargs["out"]  # x += y makes a new x
        return _wrapped(getattr(ufunc, method)(*_unwrapped(inputs), **_unwrapped(kwargs)))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return _wrapped(function(*_unwrapped(args), **_unwrapped(kwargs)))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        attribute = getattr(self._expression, name)
        if not callable(attribute):
            return _wrapped(attribute)
        return lambda *args, **kwargs: _wrapped(attribute(*args, **kwargs))

    def __getitem__(self, index: Any) -> "SymbolArray":
        return SymbolArray(self._expression[index])

    def __setitem__(self, index: Any, value: Any) -> None:
        self._expression[index] = _unwrapped(value)

    def __len__(self) -> int:
        return len(self._expression)

    def __iter__(self) -> Iterator["SymbolArray"]:
        return map(SymbolArray, self._expression)

    def __array__(self, dtype: Any = None, copy: Any = None) -> npt.NDArray[Any]:
        matrix = self._expression.to_casadi()
        if not matrix.is_constant():
            raise TypeError("a symbol has no value; np.stack makes arrays of symbols")
        return np.asarray(ca.DM(matrix), dtype=dtype).reshape(self._expression.shape)

    def __bool__(self) -> bool:
        return bool(self._expression)

    def __float__(self) -> float:
        if not self._expression.to_casadi().is_constant():
            raise TypeError("a symbol has no value; functions of the math module need one")
        return float(self._expression)

    def __int__(self) -> int:
        return int(float(self))

    def __repr__(self) -> str:
        return repr(self._expression)


def _unwrapped(value: Any) -> Any:
    """A value, or values in lists, tuples and dictionaries, with CasADi's own arrays inside."""
    if isinstance(value, SymbolArray):
        return value._expression
    if type(value) in (list, tuple):
        return type(value)(map(_unwrapped, value))
    if type(value) is dict:
        return {key: _unwrapped(each) for key, each in value.items()}
    return value


def _wrapped(value: Any) -> Any:
    """The reverse of `_unwrapped` for a result."""
    if isinstance(value, ca.ArrayInterface):
        return SymbolArray(value)
    if type(value) in (list, tuple):
        return type(value)(map(_wrapped, value))
    return value


def symbols(name: str, *shape: int) -> Traceable:
    """A new array of symbols, of one dimension or two."""
    return array(ca.SX.sym(name, *shape), len(shape))


def column(x: Traceable) -> ca.SX:
    """An array of one dimension, of symbols or numbers, as a CasADi column."""
    return ca.vec(x.to_casadi()) if isinstance(x, SymbolArray) else ca.SX(ca.DM(np.asarray(x)))


def array(x: ca.SX, ndim: int) -> Traceable:
    """A CasADi column (ndim 1) or matrix (ndim 2) as an array that behaves like NumPy's."""
    entries = ca.densify(x.T if ndim == 1 else x)
    return cast(Traceable, SymbolArray(ca.ArrayInterface(entries, ndim=ndim)))
