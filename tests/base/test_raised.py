"""Exceptions of content: the line of content at which each was raised, and its description in one line."""

import json
import sys
import textwrap

import pytest

import rocs_bt
from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.python_content import load_module
from rocs_bt.base.raised import Raised, called_at, describe, owners_of, raised_at
from rocs_bt.event import ContentRaised, ListSink
from rocs_bt.knowledge import Knowledge


@pytest.fixture
def content(tmp_path):
    """Loads a text as a file of content."""

    def content(text):
        path = tmp_path / "mine.py"
        path.write_text(textwrap.dedent(text))
        return load_module(path)

    return content


def caught(function, *args):
    try:
        function(*args)
    except BaseException as error:  # noqa: BLE001 - whatever content raises
        return error
    raise AssertionError("it did not raise")


@pytest.mark.parametrize(
    ("line", "detail"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("json.loads('{')", "JSONDecodeError: Expecting property name enclosed in double quotes"),
        ("numpy.zeros(0).min()", "ValueError: zero-size array to reduction operation minimum"),
        ("Rate.dividing(0, 0.005, 'it')", "RateError: it must be positive"),
        ("raise SystemExit(7)", "SystemExit(7)"),
        ("raise KeyError", "KeyError"),
    ],
)
def test_an_exception_is_located_at_the_line_of_content(content, line, detail):
    module = content(f"""
        import json
        import numpy
        from rocs_bt.base.clock import Rate

        def act():
            {line}
        """)
    error = caught(module.act)
    raised = Raised.of("action", "Nod", error)
    assert str(raised.location) == "mine.py:7"
    assert raised.detail.startswith(detail)
    assert str(raised).startswith(f"action 'Nod' raised {detail}")
    event = ContentRaised.of(1.5, "R2", raised, "brakes")
    assert event.raised.location.line == 7
    assert (event.file, event.line, event.kind, event.content, event.effect) == (
        "mine.py",
        7,
        "action",
        "Nod",
        "brakes",
    )


def test_the_innermost_line_of_content_counts_also_below_the_engine(content):
    module = content("""
        from functools import reduce

        def add(a, b):
            return a + b

        def act():
            return reduce(add, [1, "2"])
        """)
    assert raised_at(caught(module.act)).line == 5


def test_a_cause_is_searched_where_the_engine_raised_anew(content):
    module = content("""
        def act():
            return 1 / 0
        """)

    def engine():
        try:
            module.act()
        except ZeroDivisionError as error:
            raise InputError("no") from error

    error = caught(engine).__cause__
    outer = InputError("no")
    outer.__cause__ = error
    assert str(raised_at(outer)) == "mine.py:3"


@pytest.mark.parametrize("owner", ["Nod", "Nod.act", "Nod()", "Nod().act"])
def test_what_the_engine_refuses_is_located_at_the_definition_of_the_content(content, owner):
    module = content("""
        class Nod:
            pass

            def act(self):
                pass
        """)
    error = caught(json.loads, "{")
    error.__traceback__ = error.__traceback__.tb_next  # without this test's own line
    assert raised_at(error, eval(owner, vars(module))).line == (5 if owner.endswith("act") else 2)
    assert raised_at(error, len, 3, sys).file.name == "decoder.py", "no owner is content: the innermost frame of all"
    assert raised_at(ValueError("never raised")) is None


def test_the_objects_that_an_exception_passed_through_innermost_first(content):
    module = content("""
        class Inner:
            def act(self):
                return [1 / x for x in [0]]

        class Outer:
            def act(this, inner):
                inner.act()
        """)
    outer, inner = module.Outer(), module.Inner()
    owners = [o for o in owners_of(caught(outer.act, inner)) if isinstance(o, (module.Inner, module.Outer))]
    assert owners == [inner, outer]


def test_the_line_of_content_that_calls_the_engine(content):
    module = content("""
        def build(mission):
            return mission()
        """)
    assert str(module.build(called_at)) == "mine.py:3"


def test_an_exception_whose_message_cannot_be_read_is_described_all_the_same():
    class Broken(Exception):
        def __str__(self):
            raise ValueError("no")

    assert describe(Broken()) == "Broken: (its message cannot be read)"


def test_a_description_is_one_line_of_bounded_length():
    assert describe(ValueError("a\n  b\x00" + "c" * 10_000)).startswith("ValueError: a b")
    assert len(describe(ValueError("c" * 10_000))) < 500


def test_an_error_of_the_engine_without_content_has_a_line_of_the_engine():
    error = caught(Rate.dividing, 0, 0.005, "it")
    error.__traceback__ = error.__traceback__.tb_next
    assert raised_at(error).file.name == "clock.py"


@pytest.mark.parametrize(
    ("code", "hint"),
    [
        ("robot.pose.x", "It must be called: write pose().x"),
        ("robot.pose.distance(robot)", "It must be called: write pose().distance"),
        ("robot.pose().heading", "Pose2 has: bearing, compose, distance, transform, x, y, yaw"),
        ("robot.pose().distance_to(robot)", "Pose2 has: bearing, compose, distance, transform, x, y, yaw"),
        ("robot.position", "RobotModel has: "),
        ("[].first", "'list' object has no attribute 'first'"),
        ("rocs_bt.Sensr", "Did you mean 'Sensor'? rocs_bt has: "),
    ],
)
def test_an_unknown_attribute_names_the_right_spelling(code, hint):
    robot = Knowledge("R", SimulatedClock(0.05), ListSink()).robot
    with pytest.raises(AttributeError) as found:
        eval(code, {"robot": robot, "rocs_bt": rocs_bt})
    assert hint in describe(found.value)
