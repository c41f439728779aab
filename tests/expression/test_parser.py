"""What the language accepts, what it refuses, and how it says so."""

import re
import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, NONE, SPEED
from rocs_bt.expression import FUNCTIONS, Environment, compile_expression, evaluate, parse

ENVIRONMENT = Environment.packed(
    [
        Signal("front", 3, (LENGTH,)),
        Signal("rear", 1, (LENGTH,)),
        Signal("pose", 3, (LENGTH, LENGTH, ANGLE)),
        Signal("speed", 1, (SPEED,)),
        Signal("flag", 1, (NONE,)),
    ]
)
X = [0.5, 0.6, 0.7, 0.2, 3.0, 4.0, 0.5, 0.4, 1.0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.5 m", 0.5),
        ("50cm", 0.5),
        ("180 deg", 3.141592653589793),
        ("-3.6 km/h", -1.0),
        ("2 m/s2", 2.0),
        ("1e-3 m", 0.001),
        ("inf m", float("inf")),
        ("1 m-2 m", -1.0),
        ("2 m^2", 2.0),
        ("4 m^-1", 4.0),
        ("1 m/min(front)", 2.0),
        ("1 m/2", 0.5),
        ("1 km/h/s * 3.6 s", 1.0),
        (" 1 + 2 * 3 ", 7.0),
        ("0.5 m / speed", 1.25),
        ("0.5 m/s * 2", 1.0),
        ("hypot(pose[0], pose[1])", 5.0),
        ("pose[-1]", 0.5),
        ("min(front[1:])", 0.6),
        ("min(front, rear)", 0.2),
        ("min(rear)", 0.2),
        ("rear[0]", 0.2),
        ("max(1, 2, 3)", 3.0),
        ("mean(front)", (0.5 + 0.6 + 0.7) / 3),
        ("sum(front - 0.1 m)", (0.5 - 0.1) + (0.6 - 0.1) + (0.7 - 0.1)),
        ("sum(front * front)", 0.25 + 0.36 + 0.7 * 0.7),
        ("count(front < 0.65 m)", 2.0),
        ("sqrt(pose[0] * pose[0])", 3.0),
        ("abs(-2)", 2.0),
        ("clip(5, 1, 3)", 3.0),
        ("side(0)", 1.0),
        ("sign(0)", 0.0),
        ("wrap_angle(370 deg) / 1 deg", 10.0),
        ("min_valid(front, 2)", 0.5),
        ("1 if speed > 0.1 m/s else 2", 1.0),
        ("speed > 0.1 m/s and not speed > 1 m/s", True),
        ("0.1 m/s < speed < 0.3 m/s", False),
        ("any(front > 0.65 m) or False", True),
        ("all(0.1 m < front < 0.65 m)", False),
        ("min(front) <\n 0.6 m", True),
        ("20 % + 5%", 0.25),
        ("0.3 > 20 %", True),
    ],
)
def test_values(text, expected):
    value = compile_expression(text, ENVIRONMENT)(X)
    assert value == pytest.approx(expected)
    assert value == evaluate(parse(text, ENVIRONMENT), X)


def test_aliases_stand_for_their_trees_and_keep_their_names():
    environment = ENVIRONMENT.with_alias("gap", parse("min(front[0:2]) - 0.1 m", ENVIRONMENT))
    node = parse("gap < 0.5 m", environment)
    assert evaluate(node, X) is True
    assert node.args[0].text == "gap"
    assert node == parse("min(front[0:2]) - 0.1 m < 0.5 m", ENVIRONMENT)


WORDS = [
    *"+-*/<>()[]:,.=!'\"%@{}^\\~;",
    *FUNCTIONS,
    "front",
    "rear",
    "pose",
    "speed",
    "0.5 m",
    "1",
    "60 deg",
    "inf",
    "and",
    "or",
    "not",
    "if",
    "else",
]
WORDS += [" ", "lambda", "__import__", "__class__", "True", "None", "await", "in"]


@settings(max_examples=400, deadline=None)
@given(st.one_of(st.lists(st.sampled_from(WORDS), max_size=25).map(" ".join), st.text(string.printable, max_size=60)))
def test_any_text_is_parsed_or_refused_and_never_more(text):
    try:
        node = parse(text, ENVIRONMENT)
    except InputError as error:
        assert all(fault.message for fault in error.faults)
        return
    allowed = {"number", "truth", "read", "neg", "+", "-", "*", "/", "compare", "and", "or", "not", "if", *FUNCTIONS}
    assert {n.op for n in node.walk()} <= allowed
    if not node.kind.size:
        compile_expression(text, ENVIRONMENT)(X)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("2 if 1 else 3", "'if' needs true or false, but 1 is in 1."),
        ("2 if front else 3", "'if' needs true or false, but front is 3 values in m."),
        ("2 if speed > 1 m/s else True", "2 is in 1, but True is true or false."),
        ("not speed", "'not' needs true or false, but speed is in m/s."),
        ("speed and speed > 1 m/s", "'and' needs true or false, but speed is in m/s."),
        ("held(speed, 1 s)", "but speed is in m/s. Write held(test, 0.2 s)."),
        ("any(front)", "it needs comparisons, such as front < 0.3 m, but front is a number."),
        ("any(speed < 1 m/s, speed > 2 m/s)", "it takes 1 value, found 2."),
        ("1 < min(front)", "'<' needs one unit, but 1 is in 1 and min(front) is in m."),
        ("pose < 1", "pose has 3 values of different units; use an index."),
        ("front[9]", "front has 3 values, so there is no front[9]."),
        ("[1, speed]", "a list holds numbers, at least one, found [1, speed]."),
    ],
)
def test_a_wrong_use_is_refused_with_what_is_needed_and_what_was_found(text, problem):
    with pytest.raises(InputError, match=re.escape(problem)):
        parse(text, ENVIRONMENT)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_no_shape_of_python_beyond_the_language_is_accepted(data):
    """Wraps what is legal in every other kind of Python expression."""
    wrapped = data.draw(
        st.sampled_from(
            [
                "{}.real",
                "({},)",
                "[{}]",
                "{{{}}}",
                "(lambda: {})",
                "({})()",
                "f'{{{}}}'",
                "{} if 1 else 2",
                "(x:={})",
                "[{} for i in front]",
                "{} | 1",
                "{} // 1",
                "{} ** 2",
                "~{}",
                "{} is 1",
                "{} in front",
                "await {}",
                "getattr({})",
                "min(*{})",
                "{}[0]",
                "{}@1",
                "({} for i in front)",
                "{}\n;1",
                "...",
                "yield {}",
            ]
        )
    )
    text = wrapped.format(data.draw(st.sampled_from(["speed", "0.5 m", "min(front)", "True"])))
    if text in ("speed[0]", "[0.5 m]"):
        return
    with pytest.raises(InputError):
        parse(text, ENVIRONMENT)
