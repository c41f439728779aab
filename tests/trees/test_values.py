"""The table of docs/missions-rules.md: every value, from every source, for every type of port, in two runs."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.common import Status

from rocs_bt.base.errors import InputError
from rocs_bt.base.units import Metres
from rocs_bt.trees.board import Board
from rocs_bt.trees.nodes import BUILTIN, Instant, Output, Tree
from rocs_bt.trees.status import SUCCESS, outcome_name
from rocs_bt.trees.value import converted
from rocs_bt.trees.xml import load_xml

from .. import needs

PAGE = Path(__file__).parents[2] / "docs" / "missions-rules.md"
REFUSED = "refused"


class Colour(enum.Enum):
    RED = 0
    BLUE = 2


ENUMS = {member.name: member.value for member in Colour}
TYPES = {
    "bool": bool,
    "int": int,
    "float": float,
    "str": str,
    "Status": Status,
    "Colour": Colour,
    "list[int]": list[int],
    "length": Metres,
}


def probe(kind: str, default=None):
    """A class that keeps what its port reads."""

    def update(self):
        self.seen.append(self.p)
        return SUCCESS

    given = {} if default is None else {"p": default}
    return type("Probe", (Instant,), {"__annotations__": {"p": TYPES[kind]}, "update": update, "seen": [], **given})


class Give(Instant):
    """Writes a Python value to a key."""

    out: Output[Any]
    values = ()

    def update(self):
        self.out = self.values[0]
        return SUCCESS


def table() -> dict[str, dict[str, str]]:
    """Cells of the page by value and type."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("| value | bool"))
    heads = [cell.strip() for cell in lines[start].strip("|").split("|")][1:]
    found = {}
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        first, *cells = (cell.strip().strip("`") for cell in line.strip("|").split("|"))
        found[first] = dict(zip(heads, cells, strict=True))
    assert heads == list(TYPES)
    return found


TABLE = table()
NAMES = {"Colour": Colour, "Status": Status, "true": True, "false": False}


def value_of(name: str):
    """Python value of a row."""
    return eval(name, {}, NAMES)


def cell(value) -> str:
    if isinstance(value, enum.Enum):
        return value.name if isinstance(value, Colour) else outcome_name(value)
    return repr(value) if not isinstance(value, str) else f"'{value}'"


def document(body: str, others: str = "") -> str:
    return f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree>{others}</root>'


def told(kind, body: str, others: str = "", default=None, values=(), before=None, after=None, **arguments) -> str:
    """What a probe reads in the first and in the second run; "refused" if it cannot."""
    cls = probe(kind, default)
    nodes = BUILTIN.with_([cls, type("Give", (Give,), {"values": values})])
    try:
        if arguments:
            tree = Tree(cls("probe", **arguments), enums=ENUMS)
        else:
            text = document(body, others)
            board = Board()
            if before is not None:
                board["k"] = before
            tree = Tree(load_xml(text, nodes), board=board, enums=ENUMS)
        for _ in range(2):
            if after is not None:
                tree.board["k"] = after
            assert tree.tick() is SUCCESS
    except InputError:
        return REFUSED
    first, second = (cell(value) for value in cls.seen)
    assert first == second
    return first


def sequence(*parts: str) -> str:
    return f"<Sequence>{''.join(parts)}</Sequence>"


READ = '<Probe p="{k}"/>'
INNER = '<BehaviorTree ID="S"><Probe p="{p}"/></BehaviorTree>'


def script(text: str) -> str:
    return f"<Script code={quoteattr('k := ' + text)}/>"


def from_text(text: str):
    """Sources of a text, with what a probe of a type reads from them."""
    q = quoteattr(text)
    yield "a literal", lambda kind: told(kind, f"<Probe p={q}/>")
    yield "a default", lambda kind: told(kind, "<Probe/>", default=text)
    yield "SetBlackboard", lambda kind: told(kind, sequence(f'<SetBlackboard value={q} output_key="k"/>', READ))
    yield "a script", lambda kind: told(kind, sequence(script(f"'{text}'"), READ))
    yield (
        "a remapped key",
        lambda kind: told(kind, sequence(script(f"'{text}'"), '<SubTree ID="S" p="{k}"/>'), INNER),
    )


def from_number(text: str):
    """Sources of a number that stands in a file."""
    yield "a script", lambda kind: told(kind, sequence(script(text), READ))
    if text[0].isdigit():
        yield "an attribute", lambda kind: told(kind, f'<SubTree ID="S" p="{text}"/>', INNER)
    yield "a remapped key", lambda kind: told(kind, sequence(script(text), '<SubTree ID="S" p="{k}"/>'), INNER)
    yield "a private key", lambda kind: told(kind, sequence(script(text).replace("k", "_k"), '<Probe p="{_k}"/>'))


def from_python(value):
    """Sources of a Python value."""
    yield "the board before", lambda kind: told(kind, READ, before=value)
    yield "the board after", lambda kind: told(kind, READ, after=value)
    yield "an output", lambda kind: told(kind, sequence('<Give out="{k}"/>', READ), values=(value,))
    yield "an argument", lambda kind: told(kind, "", p=value)
    if isinstance(value, (bool, int, float)):
        yield "numpy", lambda kind: told(kind, READ, after=numpy.array(value)[()])


def sources(row: str):
    value = value_of(row)
    if isinstance(value, str):
        yield from from_text(value)
    elif isinstance(value, (bool, int, float)):
        yield from from_number(row)
        if value == 2.0 and isinstance(value, float):
            yield "an enum's name", lambda kind: told(kind, sequence(script("BLUE"), READ))
    yield from from_python(value)


@pytest.mark.parametrize("row", TABLE)
def test_a_value_is_the_same_from_every_source_and_in_every_run(row):
    found = {(kind, source): read(kind) for source, read in sources(row) for kind in TYPES}
    expected = {(kind, source): TABLE[row][kind] for kind, source in found}
    for number, text in (("1.0", "'1.0'"), ("2.0", "'2.0'"), ("0.5", "'0.5'"), ("0.0", "'0.0'")):
        if row == number:
            expected["str", "an attribute"] = text  # a port for text reads an attribute as written
    assert found == expected


def test_an_enum_value_of_a_port_can_be_compared_and_assigned_in_scripts():
    board = Board()
    board.enums = ENUMS
    cls = probe("Colour")
    text = sequence(
        script("BLUE"), "<ScriptCondition code=\"k == BLUE &amp;&amp; k != RED &amp;&amp; k == 'BLUE'\"/>", READ
    )
    text = sequence(text, script("RED"), READ, script("'BLUE'"), READ)
    tree = Tree(
        load_xml(f'<root BTCPP_format="4"><BehaviorTree ID="M">{text}</BehaviorTree></root>', BUILTIN.with_([cls])),
        board=board,
    )
    assert (tree.tick(), tree.tick()) == (SUCCESS, SUCCESS)
    assert cls.seen == [Colour.BLUE, Colour.RED, Colour.BLUE] * 2


@given(st.floats(allow_nan=False) | st.integers() | st.booleans(), st.sampled_from([bool, int, float, str]))
def test_a_converted_number_is_of_its_type_and_converting_it_again_changes_nothing(value, kind):
    try:
        found = converted(value, kind)
    except InputError:
        assert kind is not str
        return
    assert type(found) is kind
    assert converted(found, kind) is found
    assert kind in (str, bool) or found == pytest.approx(float(value))


def theirs(row: str, kind: str) -> str:
    """What the C++ engine reads at a port, or from the board, after a script."""
    engine = needs.package("behaviortreepy")
    factory, board = engine.BehaviorTreeFactory(), engine.Blackboard.create()
    readers = {"bool": board.get_bool, "int": board.get_int, "float": board.get_double, "str": board.get_string}
    body = sequence(script(row), '<Precondition if="false" else="{k}"><AlwaysSuccess/></Precondition>')
    if kind != "Status":
        body = script(row)
    text = f'<root BTCPP_format="4"><BehaviorTree ID="M">{body}</BehaviorTree></root>'
    try:
        outcome = factory.create_tree_from_text(text, board).tick_exactly_once()
        return str(outcome).rpartition(".")[2] if kind == "Status" else repr(readers[kind]("k"))
    except (RuntimeError, ValueError, TypeError):
        return REFUSED


NUMBER_ROWS = [row for row in TABLE if isinstance(value_of(row), (bool, int, float))]


KINDS = ("bool", "int", "float", "str", "Status")
UNLIKE = ("IDLE", REFUSED)  # C++ casts any number to a status, and cannot return IDLE


@pytest.mark.parametrize(
    ("row", "kind"),
    [(row, kind) for row in NUMBER_ROWS for kind in KINDS if kind != "Status" or TABLE[row][kind] not in UNLIKE],
)
def test_numbers_are_read_as_by_the_cpp_engine(row, kind):
    assert theirs(row, kind) == TABLE[row][kind]


@pytest.mark.parametrize("row", [row for row in TABLE if isinstance(value_of(row), str)])
def test_texts_are_read_as_by_the_cpp_engine(row):
    assert theirs(row, "str") == TABLE[row]["str"]
    for kind in ("int", "float"):
        if TABLE[row][kind] != REFUSED and value_of(row) not in ENUMS:
            assert theirs(row, kind) == TABLE[row][kind]


@pytest.mark.parametrize("given", ["true", "abc"])
@pytest.mark.parametrize("code", ["flag := false", "flag = false", "flag := 1", "flag := 'x'", "flag := flag"])
def test_a_script_on_a_text_that_a_subtree_was_given_does_what_it_does_in_the_cpp_engine(given, code):
    engine = needs.package("behaviortreepy")
    text = (
        f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M"><SubTree ID="S" flag="{given}"/>'
        f'</BehaviorTree><BehaviorTree ID="S"><Script code="{code}"/></BehaviorTree></root>'
    )
    try:
        tree = engine.BehaviorTreeFactory().create_tree_from_text(text, engine.Blackboard.create())
        expected = str(tree.tick_exactly_once()).rpartition(".")[2]
    except RuntimeError:
        expected = REFUSED
    try:
        found = outcome_name(Tree(load_xml(text)).tick())
    except InputError:
        found = REFUSED
    assert found == expected
