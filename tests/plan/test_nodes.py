"""The nodes, one truth after the other; the traps of BehaviorTree.CPP's semantics by name.

Where 4.8.2 does the same, test_conformance.py compares random trees with the C++ engine; what only later versions have,
and what we do otherwise on purpose (docs/missions-deviations.md), stands here.
"""

from __future__ import annotations

import pytest
from py_trees.behaviours import Dummy, Failure, Success
from py_trees.common import Status
from py_trees.composites import Sequence as StockSequence

from rocs_bt.clock import SimulatedClock
from rocs_bt.errors import InputError
from rocs_bt.plan.nodes import BUILTIN, CONDITIONS, InOut, Input, Instant, Leaf, Output, Tree
from rocs_bt.plan.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, outcome_name

OUTCOMES = {"S": SUCCESS, "F": FAILURE, "R": RUNNING, "K": SKIPPED}


class Scripted(Leaf):
    """Comes to one letter after the other, the last one for ever, and writes down what was asked of it."""

    def __init__(self, name, letters, log, **attributes):
        super().__init__(name, **attributes)
        self.letters, self.log, self.calls, self.word = letters, log, 0, ""

    def initialise(self):
        self.word = "start"

    def update(self):
        letter = self.letters[min(self.calls, len(self.letters) - 1)]
        self.calls += 1
        self.log.append(f"{self.name}.{self.word}={letter}")
        self.word = "run"
        return OUTCOMES[letter]

    def terminate(self, new_status):
        if new_status is IDLE:
            self.log.append(f"{self.name}.halt")


class Bench:
    """A tree, its leaves' log, and its clock."""

    def __init__(self):
        self.log = []
        self.clock = SimulatedClock(0.1)

    def leaf(self, name, letters, **attributes):
        return Scripted(name, letters, self.log, **attributes)

    def node(self, tag, *children, **attributes):
        made = [c if not isinstance(c, str) else self.leaf(chr(65 + i), c) for i, c in enumerate(children)]
        return BUILTIN.make(tag, tag, made, {k.rstrip("_"): v for k, v in attributes.items()})

    def tree(self, root, **board):
        self.built = Tree(root, clock=self.clock)
        self.built.board.update(board)
        return self

    def ticks(self, count=1):
        """What happens tick after tick, such as `RUNNING A.start=S B.start=R`."""
        return [self.tick() for _ in range(count)]

    def tick(self):
        self.log.clear()
        outcome = self.built.tick()
        self.clock.advance()
        return " ".join([outcome_name(outcome), *self.log])

    def of(self, tag, *children, **attributes):
        return self.tree(self.node(tag, *children, **attributes))


@pytest.fixture
def bench():
    return Bench()


@pytest.mark.parametrize(
    ("tag", "letters", "stories"),
    [
        ("Sequence", ["S", "RS", "F"], ["RUNNING A.start=S B.start=R", "FAILURE B.run=S C.start=F"]),
        ("Fallback", ["F", "RF", "S"], ["RUNNING A.start=F B.start=R", "SUCCESS B.run=F C.start=S"]),
        ("Sequence", ["K", "K"], ["SKIPPED A.start=K B.start=K"]),
        ("Sequence", ["K", "S"], ["SUCCESS A.start=K B.start=S"]),
        ("Fallback", ["K", "F"], ["FAILURE A.start=K B.start=F"]),
        ("AsyncSequence", ["S", "RS", "S"], ["RUNNING A.start=S", "RUNNING B.start=R", "SUCCESS B.run=S C.start=S"]),
        ("AsyncFallback", ["F", "F"], ["RUNNING A.start=F", "FAILURE B.start=F"]),
        (
            "ReactiveSequence",
            ["SF", "RR"],
            ["RUNNING A.start=S B.start=R", "FAILURE A.start=F B.halt"],
        ),
        ("ReactiveFallback", ["FS", "RR"], ["RUNNING A.start=F B.start=R", "SUCCESS A.start=S B.halt"]),
        ("Parallel", ["RS", "S", "R"], ["RUNNING A.start=R B.start=S C.start=R", "RUNNING A.run=S C.run=R"]),
        ("ParallelAll", ["F", "RS"], ["RUNNING A.start=F B.start=R", "FAILURE B.run=S"]),
        ("IfThenElse", ["S", "RS", "S"], ["RUNNING A.start=S B.start=R", "SUCCESS B.run=S"]),
        ("IfThenElse", ["F", "S", "RS"], ["RUNNING A.start=F C.start=R", "SUCCESS C.run=S"]),
        ("IfThenElse", ["F", "S"], ["FAILURE A.start=F", "FAILURE A.start=F"]),  # 4.8.2 asks only once in its life
        ("TryCatch", ["S", "F", "RS"], ["RUNNING A.start=S B.start=F C.start=R", "FAILURE C.run=S"]),
        ("TryCatch", ["S", "S", "S"], ["SUCCESS A.start=S B.start=S"]),
        ("TryCatch", ["K", "S"], ["SKIPPED A.start=K"]),
    ],
)
def test_what_a_control_does(bench, tag, letters, stories):
    assert bench.of(tag, *letters).ticks(len(stories)) == stories


class TestTraps:
    def test_a_stateful_condition_that_nobody_resets_is_not_asked_again(self, bench):
        bench.of("WhileDoElse", "SF", "RRS", "S")
        assert bench.ticks(3) == ["RUNNING A.start=S B.start=R", "RUNNING B.run=R", "SUCCESS B.run=S"]

    def test_one_that_its_parent_resets_is(self, bench):
        condition = bench.node("Sequence", bench.leaf("A", "SF"))
        bench.of("WhileDoElse", condition, bench.leaf("B", "R"), bench.leaf("C", "S"))
        assert bench.ticks(2) == ["RUNNING A.start=S B.start=R", "SUCCESS A.start=F B.halt C.start=S"]

    def test_repeat_is_running_between_rounds_when_ticked_exactly_once(self, bench):
        assert bench.of("Repeat", "S", num_cycles=3).ticks(3) == ["RUNNING A.start=S"] * 2 + ["SUCCESS A.start=S"]

    def test_and_goes_through_when_the_tree_is_settled(self, bench):
        tree = bench.of("Repeat", "S", num_cycles=3).built
        assert tree.settle() is SUCCESS
        assert len(bench.log) == 3

    def test_sequence_with_memory_gives_way_after_each_child_and_keeps_its_place_through_a_halt(self, bench):
        bench.of("SequenceWithMemory", "S", "FR", "S")
        assert bench.ticks(3) == ["RUNNING A.start=S", "FAILURE B.start=F", "RUNNING B.start=R"]
        bench.built.halt()
        assert bench.log[-1] == "B.halt"
        assert bench.tick() == "RUNNING B.start=R"

    def test_skipped_is_told_and_never_stored(self, bench):
        root = bench.leaf("A", "S", _skipIf="true")
        assert bench.tree(root).tick() == "SKIPPED"
        assert root.status is IDLE

    def test_two_stateful_children_of_a_reactive_node_halt_each_other(self, bench):
        bench.of("ReactiveSequence", "SRR", "RR")
        assert bench.ticks(3) == [
            "RUNNING A.start=S B.start=R",
            "RUNNING A.start=R B.halt",
            "RUNNING A.run=R",
        ]

    def test_post_runs_on_no_halt(self, bench):
        bench.tree(bench.leaf("A", "R", _post="n += 1", _onHalted="h += 1"), n=0, h=0)
        bench.tick()
        bench.built.halt()
        assert bench.built.board.texts() == {"h": "1", "n": "0"}

    def test_precondition_is_not_asked_while_the_child_is_under_way(self, bench):
        bench.of("Precondition", "RRS", if_="x == 1", else_="RUNNING")
        bench.built.board["x"] = 0
        assert bench.tick() == "RUNNING"
        bench.built.board["x"] = 1
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["x"] = 0
        assert bench.ticks(2) == ["RUNNING A.run=R", "SUCCESS A.run=S"]

    def test_parallel_all_fails_at_the_number_given_and_not_above_it(self, bench):
        assert bench.of("ParallelAll", "F", "F", "S", max_failures=2).tick().startswith("FAILURE")
        assert bench.of("ParallelAll", "F", "S", "S", max_failures=2).tick().startswith("SUCCESS")

    def test_children_that_had_ended_are_not_halted(self, bench):
        bench.of("Sequence", "S", "R")
        bench.tick()
        bench.built.halt()
        assert bench.log == ["A.start=S", "B.start=R", "B.halt"]

    def test_a_composite_without_children_is_refused(self):
        with pytest.raises(InputError, match=r"'go' \(Sequence\) needs at least 1 children, found 0"):
            BUILTIN.make("Sequence", "go", [], {})

    def test_parallel_decides_after_each_child(self, bench):
        assert bench.of("Parallel", "S", "S", "S", success_count=1).tick() == "SUCCESS A.start=S"
        assert bench.of("Parallel", "F", "S", "S", failure_count=1).tick() == "FAILURE A.start=F"

    def test_parallel_counts_a_skipped_child_only_where_the_count_is_from_the_end(self, bench):
        assert bench.of("Parallel", "K", "S", success_count=-1).tick().startswith("SUCCESS")
        assert bench.of("Parallel", "K", "S", success_count=2).ticks(2)[1].startswith("RUNNING")

    def test_parallel_refuses_a_count_that_it_can_never_reach(self, bench):
        with pytest.raises(InputError, match="waits for 3 of its children, and has 2"):
            bench.of("Parallel", "S", "S", success_count=3).tick()

    def test_what_skips_half_way_counts_as_running_until_its_parent_ends(self, bench):
        inner = bench.node("Sequence", bench.leaf("A", "K"), _onHalted="h += 1")
        bench.of("Sequence", inner, bench.leaf("B", "S"))
        bench.built.board["h"] = 0
        assert bench.tick() == "SUCCESS A.start=K B.start=S"
        assert bench.built.board["h"] == 1

    @pytest.mark.parametrize("tag", ["IfThenElse", "WhileDoElse"])
    def test_a_condition_may_not_be_skipped(self, bench, tag):
        with pytest.raises(InputError, match="was skipped"):
            bench.of(tag, "K", "S", "S").tick()


class TestConditions:
    @pytest.mark.parametrize(
        ("condition", "story"),
        [("_failureIf", "FAILURE"), ("_successIf", "SUCCESS"), ("_skipIf", "SKIPPED"), ("_while", "RUNNING A.start=R")],
    )
    def test_before_a_node_starts(self, bench, condition, story):
        assert bench.tree(bench.leaf("A", "R", **{condition: "x > 0"}), x=1).tick() == story

    def test_they_are_asked_in_this_order(self, bench):
        every = dict.fromkeys(CONDITIONS[:4], "true")
        assert bench.tree(bench.leaf("A", "S", **every)).tick() == "FAILURE"
        del every["_failureIf"]
        assert bench.tree(bench.leaf("A", "S", **every)).tick() == "SUCCESS"

    def test_only_while_is_asked_of_a_node_that_runs(self, bench):
        bench.tree(bench.leaf("A", "R", _failureIf="x > 0", _while="x < 2"), x=0)
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["x"] = 1
        assert bench.tick() == "RUNNING A.run=R"
        bench.built.board["x"] = 2
        assert bench.tick() == "SKIPPED A.halt"

    def test_after_it_has_ended(self, bench):
        told = {"_onSuccess": "t += 's'", "_onFailure": "t += 'f'", "_post": "t += 'p'"}
        for letter in "SFRK":
            bench.tree(bench.leaf("A", letter, **told), t="")
            bench.tick()
            assert bench.built.board["t"] == {"S": "sp", "F": "fp"}.get(letter, "")

    def test_also_when_a_pre_condition_decided(self, bench):
        bench.tree(bench.leaf("A", "R", _failureIf="true", _onFailure="n += 1", _post="n += 1"), n=0)
        assert bench.tick() == "FAILURE"
        assert bench.built.board["n"] == 2

    @pytest.mark.parametrize(
        ("tag", "port"),
        [("Script", "code"), ("ScriptCondition", "code"), ("Precondition", "if"), ("TestNode", "post_script")],
    )
    def test_a_script_in_a_port_is_parsed_when_the_node_is_made(self, tag, port):
        ((name, fault),) = BUILTIN[tag].attribute_faults({port: "1 +"})
        assert name == port
        assert "a value is missing at the end" in str(fault)

    def test_all_that_is_wrong_with_a_node_is_told_at_once(self):
        attributes = {"_skipIf": "1 +", "num_cycles": "x y", "wrong": "1", "_editor": "kept"}
        found = BUILTIN["Repeat"].attribute_faults(attributes)
        assert [name for name, _ in found] == ["_skipIf", "num_cycles", "wrong"]
        assert "Repeat has: num_cycles" in str(found[2][1])
        assert [name for name, _ in BUILTIN["Repeat"].attribute_faults({})] == ["num_cycles"]


class TestHalts:
    def test_each_running_node_is_halted_once_children_first(self, bench):
        told = {"_onHalted": "t += '{}'"}

        def mark(name):
            return {key: value.format(name) for key, value in told.items()}

        inner = bench.node("Inverter", bench.leaf("A", "R", **mark("a")), **mark("i"))
        root = bench.node("Parallel", inner, bench.leaf("B", "R", **mark("b")), bench.leaf("C", "S"), **mark("p"))
        bench.tree(root, t="")
        bench.tick()
        bench.built.halt()
        bench.built.halt()
        assert bench.built.board["t"] == "aibp"
        assert bench.log == ["A.start=R", "B.start=R", "C.start=S", "A.halt", "B.halt"]

    @pytest.mark.parametrize("tag", ["SkipUnlessUpdated", "WaitValueUpdate"])
    def test_what_waits_for_a_key_halts_its_child_too(self, bench, tag):
        """Theirs leaves it running."""
        bench.tree(bench.node(tag, "R", entry="{x}"), x=1)
        bench.tick()
        bench.built.halt()
        assert bench.log[-1] == "A.halt"

    def test_try_catch_may_clean_up_when_it_is_halted(self, bench):
        bench.of("TryCatch", "R", "S", catch_on_halt=True)
        bench.tick()
        bench.built.halt()
        assert bench.log == ["A.start=R", "A.halt", "B.start=S"]


@pytest.mark.parametrize(
    ("tag", "attributes", "letters", "stories"),
    [
        ("Inverter", {}, "SFRK", ["FAILURE A.start=S", "SUCCESS A.start=F", "RUNNING A.start=R", "SKIPPED A.run=K"]),
        ("ForceSuccess", {}, "SF", ["SUCCESS A.start=S", "SUCCESS A.start=F"]),
        ("ForceFailure", {}, "SF", ["FAILURE A.start=S", "FAILURE A.start=F"]),
        ("KeepRunningUntilFailure", {}, "SF", ["RUNNING A.start=S", "FAILURE A.start=F"]),
        ("Repeat", {"num_cycles": "0"}, "S", ["SUCCESS"]),
        ("Repeat", {"num_cycles": "2"}, "SF", ["RUNNING A.start=S", "FAILURE A.start=F"]),
        ("Repeat", {"num_cycles": "2"}, "SKS", ["RUNNING A.start=S", "SKIPPED A.start=K", "SUCCESS A.start=S"]),
        ("RetryUntilSuccessful", {"num_attempts": "0"}, "S", ["FAILURE"]),
        ("RetryUntilSuccessful", {"num_attempts": "2"}, "F", ["RUNNING A.start=F", "FAILURE A.start=F"]),
        ("RetryUntilSuccessful", {"num_attempts": "-1"}, "FFS", ["RUNNING A.start=F"] * 2 + ["SUCCESS A.start=S"]),
        ("RunOnce", {}, "RS", ["RUNNING A.start=R", "SUCCESS A.run=S", "SKIPPED"]),
        ("RunOnce", {"then_skip": "false"}, "F", ["FAILURE A.start=F", "FAILURE"]),
        ("Delay", {"delay_msec": "150"}, "RS", ["RUNNING", "RUNNING", "RUNNING A.start=R", "SUCCESS A.run=S"]),
        ("Timeout", {"msec": "150"}, "R", ["RUNNING A.start=R", "RUNNING A.run=R", "FAILURE A.halt"]),
        ("Timeout", {"msec": "0"}, "RRRS", ["RUNNING A.start=R"] + ["RUNNING A.run=R"] * 2 + ["SUCCESS A.run=S"]),
        ("Timeout", {"msec": "150"}, "RS", ["RUNNING A.start=R", "SUCCESS A.run=S", "SUCCESS A.start=S"]),
        (
            "LoopInt",
            {"queue": "1;2", "value": "{v}"},
            "S",
            ["RUNNING A.start=S"] * 2 + ["SUCCESS", "RUNNING A.start=S"],
        ),
        ("LoopString", {"queue": "", "if_empty": "SKIPPED"}, "S", ["SKIPPED"]),
        ("LoopBool", {"queue": "true;0"}, "F", ["FAILURE A.start=F"]),
        ("Precondition", {"if": "1 > 2", "else": "SKIPPED"}, "S", ["SKIPPED"]),
        ("Precondition", {"if": "1 > 2"}, "S", ["FAILURE"]),
    ],
)
def test_what_a_decorator_does(bench, tag, attributes, letters, stories):
    assert bench.of(tag, letters, **attributes).ticks(len(stories)) == stories


def test_a_loop_empties_the_list_on_the_board(bench):
    bench.tree(bench.node("LoopDouble", "S", queue="{q}", value="{v}"))
    items = bench.built.board["q"] = [1.5, 2.5]
    assert bench.tick() == "RUNNING A.start=S"
    assert (items, bench.built.board["v"]) == ([2.5], 1.5)


def test_a_limit_that_is_a_key_is_read_again_after_each_round(bench):
    child = bench.leaf("A", "F", _onFailure="n = 2")
    bench.tree(bench.node("RetryUntilSuccessful", child, num_attempts="{n}"), n=9)
    assert bench.ticks(2) == ["RUNNING A.start=F", "FAILURE A.start=F"]


@pytest.mark.parametrize(
    ("value", "child"),
    [("1", "A"), (1, "A"), (1.0, "A"), ("two", "B"), (3, "B"), ("other", "C"), (None, "C"), ("01", "A")],
)
def test_a_switch_compares_text_then_numbers_with_enums(bench, value, child):
    root = bench.node("Switch2", "S", "S", "S", variable="{x}", case_1="1", case_2="two")
    bench.built = Tree(root, enums={"two": 3})
    if value is not None:
        bench.built.board["x"] = value
    assert bench.tick() == f"SUCCESS {child}.start=S"


def test_a_switch_that_changes_halts_the_child_it_leaves(bench):
    bench.tree(bench.node("Switch2", "R", "S", "S", variable="{x}", case_1="1", case_2="2"), x=1)
    assert bench.tick() == "RUNNING A.start=R"
    bench.built.board["x"] = 2
    assert bench.tick() == "SUCCESS A.halt B.start=S"


class TestNavigation:
    """Nav2's control nodes; the truths are those of nav2_behavior_tree/test/plugins/control."""

    def test_pipeline(self, bench):
        bench.of("PipelineSequence", "S", "RSR", "RS")
        assert bench.ticks(3) == [
            "RUNNING A.start=S B.start=R",
            "RUNNING A.start=S B.run=S C.start=R",
            "SUCCESS A.start=S B.start=R C.run=S B.halt",
        ]

    def test_recovery(self, bench):
        bench.of("RecoveryNode", "FFS", "S", number_of_retries=2)
        assert bench.tick() == "SUCCESS A.start=F B.start=S A.start=F B.start=S A.start=S"
        assert Bench().of("RecoveryNode", "F", "S").tick() == "FAILURE A.start=F B.start=S A.start=F"
        assert Bench().of("RecoveryNode", "F", "F").tick() == "FAILURE A.start=F B.start=F"
        assert Bench().of("RecoveryNode", "K", "F").tick() == "SKIPPED A.start=K"

    def test_round_robin(self, bench):
        bench.of("RoundRobin", "FS", "S", "F")
        assert bench.ticks(2) == ["SUCCESS A.start=F B.start=S", "SUCCESS B.start=S"]
        assert Bench().of("RoundRobin", "F", "F").tick() == "FAILURE A.start=F B.start=F"

    def test_nonblocking(self, bench):
        bench.of("NonblockingSequence", "RS", "S")
        assert bench.ticks(2) == ["RUNNING A.start=R B.start=S", "SUCCESS A.run=S B.start=S"]

    def test_persistent(self, bench):
        bench.tree(bench.node("PersistentSequence", "S", "RRS", current_child_idx="{at}"), at=0)
        assert bench.tick() == "RUNNING A.start=S B.start=R"
        bench.built.halt()
        assert bench.tick() == "RUNNING B.start=R"
        assert bench.built.board["at"] == 1

    def test_pause(self, bench):
        bench.tree(bench.node("PauseResumeController", "R", "R", "S", "S", paused="{p}"), p=False)
        assert bench.tick() == "RUNNING A.start=R"
        bench.built.board["p"] = True
        assert bench.ticks(2) == ["RUNNING A.halt C.start=S", "RUNNING B.start=R"]
        bench.built.board["p"] = False
        assert bench.ticks(2) == ["RUNNING B.halt D.start=S", "RUNNING A.start=R"]


class Greet(Instant):
    """Says hello."""

    who = Input(str, doc="who is greeted")
    times = Input(int, 1)
    said = Output(str)
    count = InOut(int, 0)

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

    def test_the_key_of_the_same_name(self):
        tree = Tree(Greet("g", who="{=}", said="=", times="2", count="{n}"))
        tree.board.update({"who": "you", "n": 0})
        tree.tick()
        assert tree.board["said"] == "hello youhello you"

    def test_text_on_the_board_is_converted_when_it_is_read(self):
        tree = Tree(Greet("g", who="you", times="{t}", said="{s}"))
        tree.board["t"] = "2"
        tree.tick()
        assert tree.board["s"] == "hello youhello you"

    def test_a_key_without_a_value_is_told(self):
        with pytest.raises(InputError, match="'who' of Greet 'g' reads the key 'name', which has no value"):
            Tree(Greet("g", who="{name}")).tick()

    @pytest.mark.parametrize(
        ("attributes", "message"),
        [
            ({}, "Greet needs 'who'. who is greeted"),
            ({"who": "x", "times": "1.5"}, "port 'times': '1.5' is not a whole number"),
            ({"who": "x", "said": "out"}, "the output port 'said' needs a key, found 'out'. Write said=\"{out}\""),
            ({"who": "x", "whom": "y"}, "no port is named 'whom'. Did you mean 'who'"),
            ({"who": "{a@b}"}, "may have one '@', at its beginning"),
        ],
    )
    def test_what_is_wrong_is_told_when_the_node_is_made(self, attributes, message):
        with pytest.raises(InputError) as caught:
            Greet("g", **attributes)
        assert message in str(caught.value)

    @pytest.mark.parametrize("taken", ["status", "key", "board", "children"])
    def test_a_port_cannot_hide_what_every_node_has(self, taken):
        with pytest.raises(InputError, match=rf'Write: {taken}_ = Input\(..., name="{taken}"\)'):
            type("Bad", (Leaf,), {taken: Input(str)})

    def test_one_key_cannot_have_two_types(self):
        class Other(Greet):
            level = Input(float)

        root = BUILTIN.make("Sequence", "s", [Greet("g", who="a", times="{x}"), Other("o", who="a", level="{x}")], {})
        with pytest.raises(InputError, match="the key 'x' is of type int, not float"):
            Tree(root)

    def test_a_class_inherits_the_ports_of_its_base(self):
        assert list(type("More", (Greet,), {"extra": Input(int, 0)}).ports) == [
            "who",
            "times",
            "said",
            "count",
            "extra",
        ]


class TestSubTrees:
    def make(self, child, **attributes):
        return BUILTIN.make("SubTree", "sub", [child], attributes)

    def test_keys_go_through_remapping_and_stay_inside_otherwise(self):
        inner = BUILTIN.make("Script", "s", [], {"code": "goal := 'B'; local := 1"})
        tree = Tree(self.make(inner, ID="T", goal="{dock}"))
        tree.tick()
        assert tree.board.texts() == {"dock": "B"}

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

    def test_set_copies_a_text_or_another_key(self):
        assert self.run("SetBlackboard", value="5", output_key="k") == (["SUCCESS"], {"k": "5"})
        assert self.run("SetBlackboard", {"a": 2}, value="{a}", output_key="{k}")[1] == {"a": "2", "k": "2"}

    def test_unset(self):
        assert self.run("UnsetBlackboard", {"a": 2}, key="a") == (["SUCCESS"], {})

    def test_was_it_written(self):
        assert self.run("WasEntryUpdated", {"a": 2}, entry="{a}", ticks=2)[0] == ["SUCCESS", "FAILURE"]
        assert self.run("WasEntryUpdated", entry="{a}")[0] == ["FAILURE"]

    def test_sleep_reads_the_trees_clock(self, bench):
        assert bench.of("Sleep", msec="150").ticks(3) == ["RUNNING", "RUNNING", "SUCCESS"]

    def test_a_tree_without_a_clock_says_so(self):
        with pytest.raises(InputError, match="was given no clock"):
            self.run("Sleep", msec="150")

    def test_a_stand_in(self, bench):
        bench.of("TestNode", return_status="FAILURE", failure_script="f := 1", post_script="p := 1", async_delay="150")
        assert bench.ticks(3) == ["RUNNING", "RUNNING", "FAILURE"]
        assert bench.built.board.texts() == {"f": "1", "p": "1"}
        assert bench.of("TestNode", return_status_script="1 > 2 ? 2 : 3").tick() == "FAILURE"


@pytest.mark.parametrize("wrong", [None, Status.INVALID, True])
@pytest.mark.parametrize("base", [Leaf, Instant])
def test_a_leaf_that_gives_no_outcome_is_named(base, wrong):
    rotten = type("Rotten", (base,), {"update": lambda self: wrong})
    with pytest.raises(InputError, match=r"'b' \(Rotten\) gave no status back"):
        Tree(BUILTIN.make("Sequence", "s", [rotten("b")], {})).tick()


@pytest.mark.parametrize("tag", sorted(BUILTIN))
def test_every_node_says_what_it_and_its_ports_are_for(tag):
    node = BUILTIN[tag]
    assert node.description().endswith((".", "_count`."))
    assert all(port.doc for port in node.ports.values())


def test_py_trees_own_nodes_may_stand_anywhere(bench):
    stock = StockSequence("stock", memory=True, children=[Success("a"), bench.leaf("L", "RS"), Dummy("d")])
    bench.of("Fallback", Failure("f"), stock)
    assert bench.ticks(2) == ["RUNNING L.start=R", "RUNNING L.run=S"]
    bench.built.halt()
    assert stock.status is IDLE
