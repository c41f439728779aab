"""Ports, the boards of subtrees, and the nodes that write on a board."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.units import PositiveCount, PositiveMetres
from rocs_bt.trees.nodes import BUILTIN, InOut, Instant, Leaf, Output, Syntax, Tree, port_of
from rocs_bt.trees.status import FAILURE, SUCCESS, outcome_name
from rocs_bt.trees.xml import read_document, verify


class Greet(Instant):
    """Says hello."""

    who: Annotated[str, "who is greeted"]
    times: int = 1
    said: Output[str]
    count: InOut[int] = 0

    def update(self):
        self.said = f"hello {self.who}" * self.times
        self.count = self.count + 1
        return SUCCESS


class TestPorts:
    def test_they_are_read_and_written_as_attributes(self):
        tree = Tree(Greet("g", who="{name}", said="{out}", count="{n}"))
        tree.board.update({"name": "R2", "n": 4})
        assert tree.tick() is SUCCESS
        assert tree.board.texts() == {"name": "R2", "n": "5", "out": "hello R2"}

    @pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
    def test_a_value_of_the_board_is_refused_as_its_text_in_a_file_is(self, value):
        class Walk(Instant):
            way: PositiveMetres = 1.0

            def update(self):
                return SUCCESS if self.way > 0.0 else FAILURE

        with pytest.raises(InputError, match=r"way must be (positive|finite)"):
            Walk.ports["way"].converted(value)
        with pytest.raises(InputError, match="way must be positive"):
            Walk.ports["way"].converted("-1 m")
        assert Walk.ports["way"].converted(2) == 2.0

    def test_annotations_that_declare_nothing_usable_are_refused_with_advice(self):
        with pytest.raises(InputError, match=r"annotations of 'Lost' cannot be read.*Import the types"):
            type("Lost", (Instant,), {"__annotations__": {"way": "Nowhere"}, "update": lambda self: SUCCESS})
        with pytest.raises(InputError, match=r"'way' of 'Pick' has values that are no texts.*Bounds\(1, 2\)"):
            type("Pick", (Instant,), {"__annotations__": {"way": Literal[1, 2]}, "update": lambda self: SUCCESS})

    def test_an_attribute_that_is_annotated_as_a_port_says_how_to_write_it(self):
        with pytest.raises(InputError, match=r"write '_times' if it is an attribute"):
            Greet("g", who="a").times = 2

    def test_the_key_of_the_same_name(self):
        tree = Tree(Greet("g", who="{=}", said="=", times="2", count="{n}"))
        tree.board.update({"who": "you", "n": 0})
        tree.tick()
        assert tree.board["said"] == "hello youhello you"

    @pytest.mark.parametrize(("text", "error"), [("x y", "ValueError: "), ("1" * 9, "ZeroDivisionError: ")])
    def test_an_exception_of_a_ports_parser_is_a_fault_of_the_text(self, text, error):
        class Custom(Leaf):
            size: Annotated[float, Syntax(lambda text: 1 / (len(text) - 9) / int(text))]

        document = read_document(
            f'<root BTCPP_format="4">\n<BehaviorTree ID="Main">\n<Custom size="{text}"/></BehaviorTree></root>'
        )
        (fault,) = verify(document, {**BUILTIN, "Custom": Custom})
        assert fault.line == 3
        assert f"port 'size': '{text}' cannot be converted: {error}" in fault.message

    @pytest.mark.parametrize(
        ("given", "fault"),
        [
            ({"count": "0"}, "count must be positive, found 0"),
            ({"gap": "-1 m"}, "gap must be positive, found '-1 m'"),
            ({"side": "lft"}, "Did you mean 'left'?"),
        ],
    )
    def test_a_literal_lies_within_the_bounds_that_the_annotation_declares(self, given, fault):
        class Bounded(Leaf):
            count: PositiveCount = 1
            gap: PositiveMetres = 1.0
            side: Literal["left", "right"] = "left"

        with pytest.raises(InputError, match=re.escape(fault)):
            Bounded("b", **given)
        assert Bounded("b", count="2", gap="2 m", side="right").gap == 2.0

    def test_a_key_without_a_value_is_told(self):
        with pytest.raises(InputError, match="'who' of Greet 'g' reads the key 'name', which has no value"):
            Tree(Greet("g", who="{name}")).tick()

    @pytest.mark.parametrize("taken", ["status", "key", "board", "children"])
    def test_a_port_cannot_hide_what_every_node_has(self, taken):
        with pytest.raises(InputError, match=f"Write '{taken}_', which is the port '{taken}' in files"):
            type("Bad", (Leaf,), {"__annotations__": {taken: str}})

    @pytest.mark.parametrize("member", [lambda self: 2, property(lambda self: 2)])
    def test_a_port_cannot_hide_a_method_of_its_base(self, member):
        base = type("Base", (Instant,), {"look": member})
        with pytest.raises(InputError, match=r"More cannot have a port in 'look', which its base has\. Write 'look_'"):
            type("More", (base,), {"__annotations__": {"look": int}})

    def test_one_key_cannot_have_two_types(self):
        class Other(Greet):
            level: float

        root = BUILTIN.make("Sequence", "s", [Greet("g", who="a", times="{x}"), Other("o", who="a", level="{x}")], {})
        with pytest.raises(InputError, match="the key 'x' is of type int, not float"):
            Tree(root)

    def test_a_class_inherits_the_ports_of_its_base(self):
        assert list(type("More", (Greet,), {"__annotations__": {"extra": int}, "extra": 0}).ports) == [
            "who",
            "times",
            "said",
            "count",
            "extra",
        ]

    @pytest.mark.parametrize(("given", "times"), [({}, 1), ({"times": 3}, 3)])
    def test_a_port_that_is_annotated_again_has_the_default_of_its_base_or_another(self, given, times):
        more = type("More", (Greet,), {"__annotations__": {"times": Annotated[int, "how often"]}, **given})
        assert (more.ports["times"].default, more.ports["times"].doc) == (times, "how often")
        assert more("m", who="a").times == times

    def test_a_class_that_a_program_makes_has_ports_in_its_members(self):
        members = {"size": port_of(int, "how many", default=2), "member": port_of(int, name="if")}
        one, two = (type(tag, (Instant,), {**members, "update": lambda self: SUCCESS}) for tag in ("One", "Two"))
        assert [*one.ports] == [*two.ports] == ["size", "if"]
        assert (two("t", **{"if": "7"}).size, one("o", size="3", **{"if": "7"}).member) == (2, 7)

    def test_a_port_may_have_a_slot(self):
        members = {"__annotations__": {"size": int}, "__slots__": ("size",), "update": lambda self: SUCCESS}
        slotted = type("Slotted", (Instant,), members)
        assert slotted.ports["size"].required
        assert slotted("s", size="2").size == 2

    @pytest.mark.parametrize("member", [lambda self: 2, property(lambda self: 2), classmethod(lambda cls: 2)])
    def test_a_method_cannot_hide_a_port(self, member):
        with pytest.raises(InputError, match=r"More has a port 'times' and a method of that name. Rename it"):
            type("More", (Greet,), {"times": member})
        with pytest.raises(InputError, match=r"Own has a port 'size' and a method of that name. Rename it"):
            type("Own", (Leaf,), {"__annotations__": {"size": int}, "size": member})


class TestSubTrees:
    def make(self, child, **attributes):
        return BUILTIN.make("SubTree", "sub", [child], attributes)

    @pytest.mark.parametrize(("given", "value"), [("7", 7), ("1.5", 1.5), ("home", "home")])
    def test_a_literal_is_a_value_of_its_own(self, given, value):
        inner = BUILTIN.make("Script", "s", [], {"code": "@seen := goal"})
        tree = Tree(self.make(inner, goal=given, _autoremap="true"))
        tree.tick()
        assert tree.board["seen"] == value
        assert "goal" not in tree.board

    def test_its_own_conditions_are_asked_on_the_board_outside(self):
        inner = BUILTIN.make("AlwaysFailure", "f", [], {})
        tree = Tree(self.make(inner, _successIf="x == 1"))
        tree.board["x"] = 1
        assert tree.tick() is SUCCESS

    def test_paths_are_those_of_the_cpp_engine(self):
        inner = BUILTIN.make("Sequence", "Sequence", [Greet("hi", who="a"), Greet("", who="b")], {})
        tree = Tree(BUILTIN.make("Inverter", "not", [self.make(inner, ID="T")], {}))
        assert list(tree.paths().values()) == ["not", "sub", "sub/Sequence::3", "sub/hi", "sub/Greet::5"]
        assert [tree.uid(node) for node in tree.nodes] == [1, 2, 3, 4, 5]


class TestBoardNodes:
    def run(self, tag, board=(), ticks=1, **attributes):
        tree = Tree(BUILTIN.make(tag, tag, [], attributes))
        tree.board.update(dict(board))
        return [outcome_name(tree.tick()) for _ in range(ticks)], tree.board.texts()

    def test_unset(self):
        assert self.run("UnsetBlackboard", {"a": 2}, key="a") == (["SUCCESS"], {})

    def test_sleep_reads_the_trees_clock(self, bench):
        assert bench.of("Sleep", msec="150").ticks(3) == ["RUNNING", "RUNNING", "SUCCESS"]

    def test_a_tree_without_a_clock_says_so(self):
        with pytest.raises(InputError, match="has no clock"):
            self.run("Sleep", msec="150")

    def test_a_stand_in(self, bench):
        bench.of("TestNode", return_status="FAILURE", failure_script="f := 1", post_script="p := 1", async_delay="150")
        assert bench.ticks(3) == ["RUNNING", "RUNNING", "FAILURE"]
        assert bench.built.board.texts() == {"f": "1", "p": "1"}
        assert bench.of("TestNode", return_status_script="1 > 2 ? 2 : 3").tick() == "FAILURE"
