"""Parameters: values against their annotated types, with numpy's numbers and lists of any kind."""

import math
from collections.abc import Callable, Sequence
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.parameter import Parameter, misfit
from rocs_bt.base.units import LENGTH, NOT_NEGATIVE, SPEED

GOOD = [
    (float, 1.0), (float, 1), (float, np.float32(1)), (float, np.int64(1)), (float, math.nan),
    (int, 3), (int, np.int32(3)), (str, ""), (bool, True),
    (Sequence[float], [1, 2.0]), (Sequence[float], (1, 2)), (Sequence[float], np.zeros(2)), (Sequence[float], []),
    (Sequence[Sequence[float]], [(1, 2), [3, 4]]), (Sequence[Sequence[float]], np.zeros((3, 2))),
    (list[int], [1, 2]), (tuple[float, float], (1, 2)), (tuple[float, ...], (1, 2, 3)), (list, [object()]),
    (float | None, None), (float | None, 1.0), (int | str, "a"), (str | None, None),
    (Callable[[float], bool] | None, len), (Callable[[float], bool], print), (object, 3), (np.ndarray, "anything"),
]  # fmt: skip  # a table

WRONG = [
    (float, "0.5 m/s", "a number"), (float, True, "a number"), (float, None, "a number"), (float, [1.0], "a number"),
    (int, 1.0, "a whole number"), (int, True, "a whole number"), (int, "3", "a whole number"),
    (str, 3, "a text"), (str, None, "a text"), (bool, 1, "true or false"), (bool, "yes", "true or false"),
    (Sequence[float], "12", "a list"), (Sequence[float], 1.0, "a list"), (Sequence[float], {1: 2}, "a list"),
    (Sequence[float], ["0.6 m/s"], "a list in which each is a number"),
    (Sequence[float], [1.0, None], "a list in which each is a number"),
    (Sequence[Sequence[float]], [1.0, 2.0], "a list in which each is a list"),
    (Sequence[Sequence[float]], [["a"]], "a list in which each is a list in which each is a number"),
    (tuple[float, float], (1.0,), "a list of 2 values"),
    (tuple[float, str], (1.0, 2.0), "a list in which each is a text"),
    (float | None, "x", "a number"), (int | str, 1.5, "a whole number or a text"),
]  # fmt: skip  # a table


@pytest.mark.parametrize(("kind", "value"), GOOD)
def test_values_of_a_type(kind, value):
    assert misfit(kind, value) is None


@pytest.mark.parametrize(("kind", "value", "words"), WRONG)
def test_values_that_are_none(kind, value, words):
    assert misfit(kind, value) == words


def test_faults_name_the_parameter_what_it_must_be_and_what_was_found():
    speeds = Parameter.annotated("speeds", Annotated[Sequence[float], SPEED], True, None)
    (fault,) = speeds.faults(["0.6 m/s"], "speeds of SetWheelSpeed")
    assert str(fault) == "speeds of SetWheelSpeed must be a list in which each is a number, found ['0.6 m/s']."
    assert speeds.faults([0.6, -0.6], "speeds") == []
    room = Parameter.annotated("room", Annotated[float, LENGTH, NOT_NEGATIVE], True, None)
    assert "must be 0 or more and finite, found -1 m" in str(room.faults(-1.0, "room")[0])
    goal = Parameter.annotated("goal", str, True, None)
    assert "goal must be a text, found 3." in str(goal.faults(3, "goal")[0])


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=2) | st.tuples(inner),
    max_leaves=8,
)


@given(st.sampled_from([kind for kind, _ in GOOD]), anything)
def test_no_value_makes_the_check_raise(kind, value):
    parameter = Parameter.annotated("x", kind, True, None)
    faults = parameter.faults(value, "x")
    assert all(fault.message.startswith("x must be ") for fault in faults)
