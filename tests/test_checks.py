"""Checks: one function a kind of number, and the declared check of a field."""

import pickle
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Literal

import numpy as np
import pytest

from ftcfa.checks import (
    Check,
    check_field,
    check_fields,
    counting,
    flag,
    is_number,
    known_name,
    natural,
    not_negative,
    number,
    numbers,
    positive,
    probability,
    vector,
)
from ftcfa.errors import FtcfaError, ParameterError, ShapeError, UnknownNameError


@dataclass(frozen=True)
class Part:
    """A part with a field of every kind."""

    rate: Annotated[float, Check(positive, "1/s")]
    kind: Literal["one", "two"] = "one"
    count: Annotated[int | None, Check(counting)] = None
    note: str = ""

    def __post_init__(self):
        check_fields(self)


@pytest.mark.parametrize(
    ("values", "field", "text"),
    [
        ({"rate": 0.0}, "rate", "Part rate: 0.0, expected a number > 0 [1/s]"),
        ({"rate": True}, "rate", "Part rate: True, expected a number > 0 [1/s]"),
        ({"kind": "three"}, "kind", "Part kind 'three': unknown name, expected one of: one, two"),
        ({"kind": 3}, "kind", "Part kind '3': unknown name, expected one of: one, two"),
        ({"count": 0}, "count", "Part count: 0, expected an integer >= 1"),
    ],
)
def test_a_part_refuses_what_a_field_does_not_allow(values, field, text):
    with pytest.raises(FtcfaError) as caught:
        Part(**{"rate": 1.0, **values})
    assert (caught.value.field, str(caught.value)) == (field, text)
    with pytest.raises(FtcfaError) as alone:
        check_field(Part, field, values[field])
    assert (alone.value.field, str(alone.value)) == (field, text)


def test_none_is_right_where_the_type_allows_it_and_undeclared_fields_take_anything():
    assert Part(1.0, count=None).count is None
    check_field(Part, "note", 3)
    check_field(Part, "no field", 3)


@pytest.mark.parametrize(
    ("check", "right", "wrong"),
    [
        (number, [0, -1.5, np.float32(2), Fraction(1, 3)], [np.inf, np.nan, True, "1", None, 1j]),
        (positive, [1e-300, 3, np.int64(1)], [0, -1, np.inf, True, "1", 10**400]),
        (not_negative, [0, 0.0, 3], [-1e-300, np.inf, False, [1]]),
        (probability, [1e-9, 0.5], [0, 1, 50, -1, np.nan, True, "x"]),
        (counting, [1, np.uint8(7)], [0, -1, 1.0, True, "1"]),
        (natural, [0, 2**64 - 1, np.int32(4)], [-1, 2**64, 1.0, False, None]),
        (flag, [True, False], [0, 1, "true", None]),
    ],
)
def test_a_check_of_a_number(check, right, wrong):
    for value in right:
        check("x", value)
    for value in wrong:
        with pytest.raises(ParameterError) as caught:
            check("x", value)
        assert (caught.value.subject, caught.value.got) == ("x", repr(value))
        assert caught.value.expected


def test_a_percentage_is_recognised():
    with pytest.raises(ParameterError, match=r"give 0\.95 for 95 percent"):
        probability("share", 95)


def test_a_number_is_finite_and_no_flag():
    assert [is_number(x) for x in (1, 1.0, True, np.nan, "1")] == [True, True, False, False, False]


def test_natural_gives_a_plain_integer():
    assert type(natural("seed", np.uint64(2**63))) is int


def test_known_name_lists_the_known_ones():
    known_name("colour", "red", ("red", "blue"))
    with pytest.raises(UnknownNameError) as caught:
        known_name("colour", "rod", ("red", "blue"), field="colour")
    assert (caught.value.known, caught.value.field) == (("red", "blue"), "colour")


def test_arrays():
    assert np.array_equal(vector("x", 2, 3), [2.0, 2.0, 2.0])
    assert numbers("x", [[1, 2], [3, np.inf]]).dtype == float
    for wrong in ([1, 2], [1, 2, np.nan], "abc", None):
        with pytest.raises(ShapeError) as caught:
            vector("x", wrong, 3, field="x")
        assert caught.value.field == "x"
    with pytest.raises(ParameterError, match="expected numbers"):
        numbers("x", [[1, 2], [3]])


@pytest.mark.parametrize(
    "error",
    [
        ParameterError("a", "b", "c", "d", field="e"),
        UnknownNameError("kind", "name", ["one"], field="e"),
    ],
)
def test_errors_travel_between_processes(error):
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.field, vars(again)) == (str(error), "e", vars(error))
