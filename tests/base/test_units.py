"""Quantities: what files may write, and what they are told when they write it wrong."""

import math
import typing
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import UnitError
from rocs_bt.base.units import (
    ANGLE,
    FINITE,
    LENGTH,
    NONE,
    NOT_NEGATIVE,
    POSITIVE,
    SPEED,
    Bounds,
    PositiveMetres,
    convert,
    parse_quantity,
    parse_unit,
    unit_names,
)
from rocs_bt.declare import Field


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("0.5 m", 0.5, "m"),
        ("50cm", 0.5, "m"),
        ("-60 deg", -math.pi / 3, "rad"),
        ("1.5 m/s2", 1.5, "m/s2"),
        ("1.5 m/s^2", 1.5, "m/s2"),
        ("20 Hz", 20.0, "1/s"),
        ("3.6 km/h", 1.0, "m/s"),
        ("+inf m", math.inf, "m"),
        ("7", 7.0, "1"),
        ("1e-3 s", 1e-3, "s"),
        ("2 kg*m2/s2", 2.0, "m2*kg/s2"),
    ],
)
def test_a_quantity_is_read_in_si(text, value, dimension):
    quantity = parse_quantity(text)
    assert quantity.value == pytest.approx(value)
    assert str(quantity.dimension) == dimension


@pytest.mark.parametrize("text", ["", "m", "0.5 mtr", "0.5 m m", "0,5 m", "0.5 /m", "5 m//s", "five m", "nan m"])
def test_what_is_no_quantity_is_refused(text):
    with pytest.raises(UnitError, match="is not a"):
        parse_quantity(text)


@given(st.floats(-1e6, 1e6), st.sampled_from(unit_names()), st.sampled_from(unit_names()), st.booleans())
def test_writing_and_reading_a_quantity_agree(value, first, second, over):
    unit = f"{first}/{second}" if over else f"{first}*{second}"
    quantity = parse_quantity(f"{value!r} {unit}")
    a, b = parse_unit(first), parse_unit(second)
    assert quantity.value == pytest.approx(value * (a.value / b.value if over else a.value * b.value))
    assert quantity.dimension == (a.dimension / b.dimension if over else a.dimension * b.dimension)


def test_dimensions_multiply_and_cancel():
    assert (SPEED / SPEED) == NONE
    assert SPEED * parse_unit("s").dimension == LENGTH
    assert ANGLE != NONE  # an angle cannot stand where a plain number is meant


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("3 s", "turn must be in rad, found '3 s' which is in s"),
        (3, "turn needs a unit, found the bare number 3"),
        ("3 degs", "'degs' is not a unit. Did you mean 'deg'?"),
        (True, "turn must be a quantity in rad, found True"),
        (["3 deg"], "turn must be a quantity in rad"),
    ],
)
def test_a_wrong_unit_is_said_clearly(value, message):
    with pytest.raises(UnitError) as error:
        convert(value, ANGLE, what="turn")
    assert message in str(error.value)


def test_a_unit_where_none_belongs_is_refused():
    with pytest.raises(UnitError, match=r"^full has no unit, found '12\.6 V'\. Write a number without a unit\.$"):
        convert("12.6 V", NONE, what="full")


def test_a_bare_number_passes_where_no_unit_is_wanted():
    assert convert(3, NONE) == 3.0


@given(st.floats())
def test_bounds_admit_what_their_words_say(value):
    finite = math.isfinite(value)
    assert FINITE.admit(value) is finite
    assert POSITIVE.admit(value) is (finite and value > 0.0)
    assert NOT_NEGATIVE.admit(value) is (finite and value >= 0.0)
    assert Bounds(0.0, infinite=True).admit(value) is (value >= 0.0)


def test_bounds_have_words():
    bounds = (FINITE, POSITIVE, NOT_NEGATIVE, Bounds(0.5, infinite=True), Bounds(infinite=True))
    words = ["finite", "positive and finite", "0 or more and finite", "0.5 or more", "a number"]
    assert [str(b) for b in bounds] == words


def test_annotations_nest_and_the_outer_bounds_count():
    assert typing.get_args(PositiveMetres) == (float, LENGTH, POSITIVE)
    assert Field.annotated("p", Annotated[PositiveMetres, NOT_NEGATIVE], 0.0, object).bounds is NOT_NEGATIVE
