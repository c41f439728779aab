"""The generated code against the plain interpreter, on random expressions and snapshots."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.errors import InputError
from rocs_bt.expression import Environment, compile_expression, compile_node, evaluate, joint_function, parse, reading
from rocs_bt.signal import Signal
from rocs_bt.units import LENGTH, NONE, SPEED

ENVIRONMENT = Environment.packed([Signal("a", 4), Signal("b", 4), Signal("c"), Signal("d"), Signal("e", 2)])
SIZE = 12

numbers = st.sampled_from(["0", "1", "-2", "0.5", "3", "inf", "1e300"])


def singles(groups, singles, truths):
    return st.one_of(
        st.tuples(st.sampled_from(["+", "-", "*", "/"]), singles, singles).map(lambda t: f"({t[1]} {t[0]} {t[2]})"),
        st.tuples(st.sampled_from(["min", "max", "sum", "mean"]), groups).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(st.sampled_from(["min", "max"]), groups, singles).map(lambda t: f"{t[0]}({t[2]}, {t[1]})"),
        st.tuples(st.sampled_from(["abs", "sign", "side", "sqrt", "-"]), singles).map(lambda t: f"{t[0]}({t[1]})"),
        st.tuples(singles, singles, singles).map(lambda t: f"clip({', '.join(t)})"),
        st.tuples(singles, singles).map(lambda t: f"hypot({', '.join(t)})"),
        st.tuples(groups, st.sampled_from("<>"), singles).map(lambda t: f"count({' '.join(t)})"),
        st.tuples(singles, truths, singles).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})"),
        singles.map(lambda s: f"(wrap_angle({s} * 1 rad) / 1 rad)"),
    )


def truths(groups, singles, truths):
    signs = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
    return st.one_of(
        st.tuples(singles, signs, singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(singles, signs, singles, signs, singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(truths, st.sampled_from(["and", "or"]), truths).map(lambda t: f"({' '.join(t)})"),
        truths.map(lambda t: f"(not {t})"),
        st.tuples(st.sampled_from(["any", "all"]), groups, signs, singles, signs, groups).map(
            lambda t: f"{t[0]}({' '.join(t[1:])})"
        ),
    )


def groups(groups, singles, truths):
    return st.one_of(
        st.tuples(groups, truths, groups).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})"),
        st.tuples(groups, st.sampled_from("+-*/"), singles).map(lambda t: f"({' '.join(t)})"),
        st.tuples(groups, st.sampled_from("+-*/"), groups).map(lambda t: f"({' '.join(t)})"),
        st.tuples(groups, singles, singles).map(lambda t: f"clip({', '.join(t)})"),
        groups.map(lambda g: f"abs(-{g})"),
    )


def expressions(depth):
    """Groups of four, singles and truths, up to a depth."""
    vector = st.sampled_from(["a", "b", "a[0:4]"])
    single = st.one_of(numbers, st.sampled_from(["c", "d", "a[1]", "e[0]", "min_valid(a, 2)", "min_valid(e, 1)"]))
    truth = st.sampled_from(["(c < 1)", "True", "any(b > 0)"])
    for _ in range(depth):
        vector, single, truth = (
            st.one_of(vector, groups(vector, single, truth)),
            st.one_of(single, singles(vector, single, truth)),
            st.one_of(truth, truths(vector, single, truth)),
        )
    return st.one_of(single, truth)


values = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, math.inf, -math.inf, math.nan]),
    st.floats(-10.0, 10.0),
    st.floats(allow_nan=False),
)
snapshots = st.one_of(
    st.lists(values, min_size=SIZE, max_size=SIZE), st.lists(st.floats(-2.0, 2.0), min_size=SIZE, max_size=SIZE)
)


def same(left, right):
    return left == right and isinstance(left, bool) == isinstance(right, bool)


def accepted(text):
    try:
        return parse(text, ENVIRONMENT)
    except InputError as error:
        assert "deep" in str(error) or "operations" in str(error) or "characters" in str(error), text
        return None


@settings(max_examples=300, deadline=None)
@given(expressions(3), st.lists(snapshots, min_size=1, max_size=4))
def test_generated_code_gives_what_the_interpreter_gives(text, rows):
    node = accepted(text)
    if node is None:
        return
    function = compile_node(node)
    for x in rows:
        expected = evaluate(node, x)
        assert same(function(x), expected)
        assert same(function(np.array(x)), expected)
        assert expected is None or not math.isnan(expected)


@settings(max_examples=100, deadline=None)
@given(st.lists(expressions(2), min_size=1, max_size=6), snapshots)
def test_the_joint_function_gives_what_each_alone_gives(texts, x):
    nodes = [node for text in texts if (node := accepted(text)) is not None]
    if not nodes:
        return
    got = joint_function(nodes)(x)
    expected = [evaluate(node, x) for node in nodes]
    assert all(same(g, e) for g, e in zip(got, expected, strict=True))


@settings(max_examples=100, deadline=None)
@given(expressions(2), snapshots, st.integers(0, SIZE - 1))
def test_a_nan_among_the_values_read_is_never_true_nor_false(text, x, broken):
    node = accepted(text)
    if node is None or broken not in node.reads():
        return
    x[broken] = math.nan
    assert compile_node(node)(x) is None


@pytest.mark.parametrize(
    "text", ["c / 0", "inf - inf", "0 * c * inf", "inf / inf", "sqrt(-1)", "c / (d - d)", "sum(a - inf) + sum(a + inf)"]
)
def test_what_has_no_value_is_invalid(text):
    assert compile_expression(text, ENVIRONMENT)([math.inf] * SIZE) is None


def test_a_guarded_division_is_never_computed():
    guarded = compile_expression("c > 0 and 1 / c > 0.5", ENVIRONMENT)
    x = [0.0] * SIZE
    assert guarded(x) is False
    x[8] = 1.0
    assert guarded(x) is True


def test_no_echo_is_farther_than_every_threshold():
    assert compile_expression("min(a) > 1e300", ENVIRONMENT)([math.inf] * SIZE) is True


def test_min_valid_tolerates_broken_values_up_to_its_bound():
    tolerant = compile_expression("min_valid(a, 2)", ENVIRONMENT)
    x = [math.nan, 3.0, math.nan, 2.0] + [0.0] * (SIZE - 4)
    assert tolerant(x) == 2.0
    x[1] = math.nan
    assert tolerant(x) is None


def test_reading_tells_what_was_compared():
    environment = Environment.packed(
        [Signal("front", 3, (LENGTH,)), Signal("speed", 1, (SPEED,)), Signal("n", 1, (NONE,))]
    )
    node = parse("min(front) < 0.3 m and (speed > 0.1 m/s or n == 2) and min(front) > 0 m", environment)
    assert reading(node, [0.21234, 1.0, math.inf, math.nan, 2.0]) == "min(front) = 0.212 m, speed = invalid, n = 2"


def test_environment_of_a_signal_table():
    class Layout:
        names = ("speed", "front")

        def spec(self, name):
            return Signal(name, 3 if name == "front" else 1, (LENGTH,))

        def slice_of(self, name):
            return slice(5, 8) if name == "front" else slice(2, 3)

    environment = Environment.of(Layout())
    assert compile_expression("max(front) - speed", environment)([0, 0, 1, 0, 0, 2, 3, 4]) == 3
