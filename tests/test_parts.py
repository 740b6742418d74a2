"""Parts: what they declare is there, and copies with other values are whole."""

from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

import ftcfa
from ftcfa import ParameterError, number_fields
from ftcfa.parts import fields_of, parameters_of, with_fields

PARTS = [part for part in (getattr(ftcfa, name) for name in ftcfa.__all__) if parameters_of(part)]


@dataclass(frozen=True)
class Square:
    side: float
    colour: str = "red"
    varies: ClassVar = number_fields("side")

    def __post_init__(self):
        if self.side < 0:
            raise ParameterError("side", repr(self.side), "a number >= 0", field="side")

    @cached_property
    def area(self):
        return self.side**2


class Pair(NamedTuple):
    a: float
    b: float
    varies = number_fields("a", "b")


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.__name__)
def test_what_a_part_declares_it_has(part):
    assert is_dataclass(part)
    names = {field.name for field in fields(part)}
    assert all(name in names or hasattr(part, name) for name in part.varies)


def test_the_laws_and_the_robots_declare_their_parameters():
    assert {ftcfa.Arm, ftcfa.ClosedLoop, ftcfa.Gains, ftcfa.Vibration} <= set(PARTS)
    assert list(ftcfa.Gains.varies) == [field.name for field in fields(ftcfa.Gains)]


def test_a_copy_computes_anew():
    square = Square(2.0)
    assert square.area == 4.0
    larger = Square.varies["side"].replace(square, 3.0)
    assert (larger, larger.area) == (Square(3.0), 9.0)
    assert square == Square(2.0)
    assert Pair.varies["b"].replace(Pair(1.0, 2.0), 5.0) == Pair(1.0, 5.0)


def test_a_copy_is_not_checked_but_varied_values_are():
    assert with_fields(Square(2.0), {"side": -1.0}).side == -1.0
    check = Square.varies["side"].check
    check(Square(2.0), np.array([3.0, 0.0, 5.0]))
    check(Square(2.0), np.array([]))
    with pytest.raises(ParameterError, match=r"side: -0.5, expected a number >= 0"):
        check(Square(2.0), np.array([3.0, -0.5, 5.0]))


def test_fields_are_those_of_dataclasses_and_named_tuples():
    assert fields_of(Square(2.0)) == {"side": 2.0, "colour": "red"}
    assert fields_of(Pair(1.0, 2.0)) == {"a": 1.0, "b": 2.0}
    for other in (Square, (1.0, 2.0), object(), 3.0, np.ones(2)):
        assert fields_of(other) == {}
