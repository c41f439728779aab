"""The scripting language: BehaviorTree.CPP 4.10's, case by case.

The values were read off the C++ engine where 4.8.2 has the same rules (scripting/operators.hpp, utils/safe_any.hpp).
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.trees.board import Board
from rocs_bt.trees.script import ScriptError, compile_condition, compile_script, parse_script
from rocs_bt.trees.script.arithmetic import (
    BINARY,
    Refused,
    assigned,
    choice_truth,
    compared,
    existing_entry,
    negated,
    required_value,
    truth,
)
from rocs_bt.trees.script.parser import Assignment, Binary, Comparison, Conditional, Literal, Name, Unary


def run(text: str, **enums: int) -> dict[str, str]:
    board = Board()
    board.enums = enums
    compile_script(parse_script(text), board)()
    return board.texts()


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("5", "5"),
        ("-5", "-5.000000"),
        ("+3", "3"),
        ("0x1F", "31"),
        ("3.5", "3.500000"),
        ("3e-2", "0.030000"),
        ("1e3", "1000.000000"),
        ("9007199254740993", "9007199254740993"),
        ("true", "1"),
        ("false", "0"),
        ("true + 1", "2.000000"),
        ("'a b'", "a b"),
        ('"quoted"', "quoted"),
        ("1 + 2 * 3", "7.000000"),
        ("(1 + 2) * 3", "9.000000"),
        ("7 / 2", "3.500000"),
        ("1 / 0", "inf"),
        ("-1 / 0", "-inf"),
        ("-2 * -3", "6.000000"),
        ("10 - 2 - 3", "5.000000"),
        ("'a' + 'b'", "ab"),
        ("'a' .. 1", "a1"),
        ("1.5 .. 'a'", "1.500000a"),
        ("6 & 3", "2.000000"),
        ("4 | 1 & 1", "5.000000"),
        ("6 ^ 3", "5.000000"),
        ("~5", "-6.000000"),
        ("!0", "1.000000"),
        ("!2", "0.000000"),
        ("1 == 1", "1.000000"),
        ("1 == 1.00000001", "1.000000"),
        ("1 != 1.001", "1.000000"),
        ("1 < 2 < 3", "1.000000"),
        ("3 < 2 < 1", "0.000000"),
        ("2 < 3 < 2", "0.000000"),
        ("'a' < 'b'", "1.000000"),
        ("'5' == 5", "1.000000"),
        ("'true' == 1", "1.000000"),
        ("'RED' == 2", "1.000000"),
        ("'5' == '5.0'", "0.000000"),
        ("0 / 0 < 1", "1.000000"),
        ("true || false && false", "1.000000"),
        ("2.5 && 1", "1.000000"),
        ("1 ? 2 : 3", "2"),
        ("1 > 2 ? 2 : 3", "3"),
        ("1 ? (0 ? 1 : 4) : 3", "4"),
        ("'text' ? 1 : 2", "1"),
        ("'' ? 1 : 2", "2"),
        ("RED", "2.000000"),
        ("RED + 1", "3.000000"),
    ],
)
def test_what_an_expression_is_worth(value, text):
    assert run(f"x := {value}", RED=2)["x"] == text


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("x = 1", "the key 'x' does not exist; ':=' creates it"),
        ("x", "the board has no value at 'x'"),
        ("true || y", "the board has no value at 'y'"),  # nothing stops early
        ("x := 5; x += 0.5", "it holds a whole number, but 5.5 is none"),
        ("x := 'a'; x = 5", "'x' cannot become 5: it holds a value of type str"),
        ("x := 1; x = 'a'", "'a' is not a number"),
        ("x := 'a'; x += 1", "it holds no number"),
    ],
)
def test_a_script_that_cannot_go_on_says_why(script, message):
    with pytest.raises(ScriptError) as caught:
        run(script)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("script", "at", "message"),
    [
        ("1" + "+1" * 500, None, "more than 200 operators"),
        ("x := 1" + "0" * 5000, 5, "a number of more than 400 characters"),
        ("x" * 20_000, 0, "the maximum is 10000"),
    ],
)
def test_what_is_too_large_is_refused_with_its_place(script, at, message):
    with pytest.raises(ScriptError) as caught:
        parse_script(script)
    assert message in str(caught.value)
    assert at is None or caught.value.column == at


@given(st.text(alphabet="xy01.5 +-*/<>=!&|^~?:;()'\"@\\\n", max_size=40) | st.text(max_size=30))
def test_whatever_is_written_runs_or_is_refused(text):
    board = Board()
    try:
        compile_script(parse_script(text), board)()
        compile_condition(parse_script(text), board)()
    except InputError:
        pass


@pytest.mark.soak
@settings(max_examples=100_000, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.text(alphabet="xy01.5 +-*/<>=!&|^~?:;()'\"@\\\n", max_size=60) | st.text(max_size=60))
def test_whatever_is_written_runs_or_is_refused_for_long(text):
    board = Board()
    try:
        compile_script(parse_script(text), board)()
        compile_condition(parse_script(text), board)()
    except InputError:
        pass


def statements():
    """Random statements over the keys x, y and t, the enum RED and the private key _p."""
    leaf = st.sampled_from(["x", "y", "t", "RED", "new", "0", "1", "2", "0.5", "1e3", "true", "'1'", "'ab'"])
    operator = st.sampled_from(["+", "-", "*", "/", "..", "&", "|", "&&", "||", "<", "<=", "==", "!=", ">"])
    expression = st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(inner, operator, inner).map(lambda e: f"({e[0]} {e[1]} {e[2]})"),
            st.tuples(inner, operator, inner, operator, inner).map(lambda e: f"({' '.join(e)})"),
            st.tuples(st.sampled_from("-~!"), inner).map("".join),
            st.tuples(inner, inner, inner).map(lambda e: f"({e[0]} ? {e[1]} : {e[2]})"),
            inner.map(lambda e: f"(x := {e})"),
        ),
        max_leaves=6,
    )
    target = st.sampled_from(["x", "y", "t", "new", "_p"])
    assignment = st.tuples(target, st.sampled_from([":=", "=", "+=", "-=", "*=", "/="]), expression).map(" ".join)
    return st.lists(assignment | expression, max_size=3).map("; ".join)


values = (
    st.floats() | st.integers(-5, 5) | st.booleans() | st.sampled_from([2**53 + 1, -(2**62), 0, 1, "1", "ab", None])
)


@given(statements(), values, values, values, st.booleans())
@example("x := x + y", 2**53 + 1, 1, None, False)
@example("(x ? 1 : 2) == 1", float("nan"), 0, None, True)
@example("x", 2, 0, None, True)
@settings(max_examples=500)
def test_a_script_does_what_its_operators_do(text, x, y, t, condition):
    outcomes = []
    for plain in (False, True):
        board = Board()
        board.enums = {"RED": 2}
        for key, value in {"x": x, "y": y, "t": t}.items():
            board.declare(key).store(value)
        script = parse_script(text)
        run = (
            plainly(script, board, condition)
            if plain
            else (compile_condition if condition else compile_script)(script, board)
        )
        told: list[object] = []
        for _ in range(3):
            try:
                told.append(repr(bool(run()) if condition else run()))
            except (InputError, Refused, OverflowError) as error:
                told.append(type(error) is ScriptError or plain)
            told.append([(key, repr(entry.value), entry.sequence) for key, entry in board.entries()])
        outcomes.append(told)
    assert outcomes[0] == outcomes[1]


def plainly(script, board, condition):
    """A script, operator by operator, without short ways for numbers."""

    def run():
        value = None
        for statement in script.statements:
            value = worth(statement, board)
        return truth(value) if condition else value

    return run


def worth(expression, board):
    def of(part):
        return worth(part, board)

    match expression:
        case Literal():
            return expression.value
        case Name(name) if name in board.enums:
            return float(board.enums[name])
        case Name(name):
            entry = board.entry(name)
            return required_value(entry and entry.value, name)
        case Unary():
            return negated(expression.operator, of(expression.operand))
        case Binary("&&" | "||"):
            both = [truth(of(expression.left)), truth(of(expression.right))]
            return float(all(both) if expression.operator == "&&" else any(both))
        case Binary():
            return BINARY[expression.operator](of(expression.left), of(expression.right))
        case Comparison():
            left, *rest = expression.operands
            left = of(left)
            for operator, right in zip(expression.operators, rest, strict=True):
                before, left = left, of(right)
                if not compared(operator, before, left, board.enums):
                    return 0.0
            return 1.0
        case Conditional():
            return of(expression.then if choice_truth(of(expression.condition)) else expression.otherwise)
        case Assignment(operator, target):
            entry = board.declare(target.name) if operator == ":=" else existing_entry(board, target.name)
            value = of(expression.value)
            entry.store(assigned(board, target.name, entry, operator, value))
            return entry.value


@pytest.mark.parametrize("operator", ["+", "-", "*", "/", "&&", "||", "..", "&", "<", "=="])
@pytest.mark.parametrize("leaf", ["x", "1", "t"])
def test_the_longest_statements_run(operator, leaf):
    board = Board()
    board.update({"x": 1.0, "t": "a"})
    text = f" {operator} ".join([leaf] * 200)
    for compiled in (compile_script, compile_condition):
        try:
            compiled(parse_script(text), board)()
        except ScriptError as error:
            assert "nests" not in str(error)


@pytest.mark.parametrize(
    ("level", "levels"),
    [
        ("(---", 39),
        ("(1 == -", 39),
        ("(1 && 1 == -", 39),
        ("(1 | 1 || ", 39),
        ("(1 ? 1 : ", 39),
        ("(1 == !" + "-" * 35, 5),
    ],
)
def test_the_deepest_statements_run(level, levels):
    text = level * levels + "1" + ")" * levels
    assert compile_script(parse_script(text), Board())() in (-1.0, 0.0, 1.0)


def test_a_condition_follows_a_key_that_was_removed_and_made_anew():
    board = Board()
    board["x"] = 1.0
    holds = compile_condition(parse_script("x > 2"), board)
    assert not holds()
    board.unset("x")
    with pytest.raises(ScriptError, match="no value at 'x'"):
        holds()
    board["x"] = 3
    assert holds()
