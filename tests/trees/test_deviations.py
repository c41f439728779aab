"""Differences from BehaviorTree.CPP 4.8.2 that docs/bring-a-mission.md lists, shown on both engines."""

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.trees.nodes import BUILTIN, Tree
from rocs_bt.trees.status import outcome_name
from rocs_bt.trees.xml import load_xml

from .. import needs

engine = needs.package("behaviortreepy")

ERROR = "an error"
GIVEN = '<SubTree ID="T" p="{}" v="{{v}}"/>'
ALL = '<Script code="n := 0"/><{0} queue="{1}" value="{{x}}"><Script code="n += 1"/></{0}>'
SWITCH = '<Switch2 variable="{}" case_1="1" case_2="b"><AlwaysSuccess/><AlwaysSuccess/><AlwaysFailure/></Switch2>'
ROWS = [  # body, script of the subtree, outcome and the key v or n in the C++ engine, and here
    # a literal given to a subtree: text in 4.8.2; a number here, as in 4.10
    (GIVEN.format("1"), "v := p + 1", ERROR, ("SUCCESS", "2.000000")),
    (GIVEN.format("1"), "v := p + 'x'", ("SUCCESS", "1x"), ERROR),
    (GIVEN.format("1"), "v := -p", ERROR, ("SUCCESS", "-1.000000")),
    (GIVEN.format("1"), "p := 5; v := p", ERROR, ("SUCCESS", "5")),
    (GIVEN.format("01"), "v := p", ("SUCCESS", "01"), ("SUCCESS", "1")),
    (GIVEN.format("1.50"), "v := p", ("SUCCESS", "1.50"), ("SUCCESS", "1.500000")),
    (GIVEN.format("1.0"), "v := p == '1'", ("SUCCESS", "0.000000"), ("SUCCESS", "1.000000")),
    (GIVEN.format("1"), "v := p", ("SUCCESS", "1"), ("SUCCESS", "1")),  # the same
    (GIVEN.format("1 "), "v := p", ("SUCCESS", "1 "), ("SUCCESS", "1 ")),
    # texts as truth values
    (GIVEN.format("abc"), "v := p ? 1 : 2", ERROR, ("SUCCESS", "1")),
    (GIVEN.format("true"), "v := !p", ERROR, ("SUCCESS", "0.000000")),
    # conditions on negative numbers and texts
    ('<AlwaysFailure _successIf="-1"/>', "", ERROR, ("SUCCESS", None)),
    ("<AlwaysFailure _successIf=\"'1'\"/>", "", ERROR, ("SUCCESS", None)),
    # a text whose beginning is a whole number
    ('<Repeat num_cycles="1.5"><AlwaysSuccess/></Repeat>', "", ("SUCCESS", None), ERROR),
    ('<Repeat num_cycles="1 "><AlwaysSuccess/></Repeat>', "", ("SUCCESS", None), ERROR),
    (SWITCH.format("1.5"), "", ("SUCCESS", None), ("FAILURE", None)),
    (SWITCH.format("+1"), "", ("SUCCESS", None), ("FAILURE", None)),
    # a negative duration
    ('<Timeout msec="-1"><AlwaysSuccess/></Timeout>', "", ERROR, ("SUCCESS", None)),
    # a key without a value
    (
        '<Repeat num_cycles="2"><RunOnce then_skip="{none}"><AlwaysSuccess/></RunOnce></Repeat>',
        "",
        ("SKIPPED", None),
        ERROR,
    ),
    (ALL.format("LoopInt", "{none}"), "", ERROR, ("SUCCESS", "0")),
    ('<Precondition if="true" else="{none}"><AlwaysSuccess/></Precondition>', "", ERROR, ("SUCCESS", None)),
    # the number of an outcome, and JSON
    ('<Precondition if="true" else="3"><AlwaysSuccess/></Precondition>', "", ERROR, ("SUCCESS", None)),
    (ALL.format("LoopInt", "json:[1]"), "", ERROR, ("SUCCESS", "1")),
    # numbers that are too large
    ('<Script code="v := 1e400"/>', "", ERROR, ("SUCCESS", "inf")),
]


def document(body: str, script: str) -> str:
    subtree = f'<BehaviorTree ID="T"><Script code="{script}"/></BehaviorTree>' if script else ""
    main = f'<BehaviorTree ID="M"><Sequence>{body}</Sequence></BehaviorTree>'
    return f'<root BTCPP_format="4" main_tree_to_execute="M">{main}{subtree}</root>'


def theirs(text: str):
    factory, board = engine.BehaviorTreeFactory(), engine.Blackboard.create()
    try:
        factory.register_behavior_tree_from_text(text)
        tree = factory.create_tree("M", board)
        outcome = "RUNNING"
        while outcome == "RUNNING":
            outcome = str(tree.tick_exactly_once()).rpartition(".")[2]
    except (RuntimeError, ValueError, IndexError):  # IndexError: a number that is too large
        return ERROR
    return outcome, next((board.get_string(key) for key in ("v", "n") if key in board.get_keys()), None)


def ours(text: str):
    try:
        tree = Tree(load_xml(text, BUILTIN), clock=SimulatedClock(0.001))
        outcome = "RUNNING"
        while outcome == "RUNNING":
            outcome = outcome_name(tree.tick())
    except InputError:
        return ERROR
    texts = tree.board.texts()
    return outcome, texts.get("v", texts.get("n"))


@pytest.mark.parametrize(("body", "script", "cpp", "here"), ROWS)
def test_a_difference_is_as_the_page_says(body, script, cpp, here):
    text = document(body, script)
    assert (theirs(text), ours(text)) == (cpp, here)
