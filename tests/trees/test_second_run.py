"""The second run of every standard node: as that of a new node, with the values of now.

Each case has two sets of values. A node is ticked to its end, or halted on the way, with the first set; its next run
with the same, with other, or with equal values must be the run of a node that was made for that.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.trees.nodes import BUILTIN, Leaf, Tree
from rocs_bt.trees.status import FAILURE, RUNNING, SUCCESS, outcome_name

TICKS = 8
KEEPS = {
    "RunOnce": "it runs its child once in its life",
    "SequenceWithMemory": "it resumes at the failed child, also after a halt",
    "SequenceStar": "as SequenceWithMemory",
    "RoundRobin": "it begins after the child that succeeded",
    "WasEntryUpdated": "it compares with the write that it saw last",
    "SkipUnlessUpdated": "the same",
    "WaitValueUpdate": "the same",
    "PersistentSequence": "its index is a key of the blackboard",
    "UnsetBlackboard": "it removes the value of the case",
}
"""Nodes that keep something from run to run by intention; docs/missions-rules.md names them."""


@dataclass
class Case:
    """A node with its children, as letters, and two sets of values of its keys."""

    ports: dict[str, str] = field(default_factory=dict)
    children: tuple[str, ...] = ()
    values: tuple[dict[str, object], dict[str, object]] = ({}, {})


ORDERED = Case({}, ("RS", "S", "RF"))
CASES = {
    "AlwaysFailure": Case(),
    "AlwaysSuccess": Case(),
    "AsyncFallback": Case({}, ("F", "RF", "S")),
    "AsyncSequence": ORDERED,
    "Delay": Case({"delay_msec": "{a}"}, ("RS",), ({"a": 200}, {"a": 400})),
    "Fallback": Case({}, ("RF", "F", "RS")),
    "ForceFailure": Case({}, ("RS",)),
    "ForceSuccess": Case({}, ("RF",)),
    "IfThenElse": Case({}, ("RS", "RF", "S")),
    "Inverter": Case({}, ("RS",)),
    "KeepRunningUntilFailure": Case({}, ("SRF",)),
    "LoopBool": Case({"queue": "{a}", "value": "{v}"}, ("RS",), ({"a": "1;0"}, {"a": "true"})),
    "LoopDouble": Case({"queue": "{a}", "value": "{v}"}, ("S",), ({"a": (0.5, 1)}, {"a": (7,)})),
    "LoopInt": Case({"queue": "{a}", "value": "{v}"}, ("S",), ({"a": "1;2;3"}, {"a": "4"})),
    "LoopString": Case({"queue": "{a}", "value": "{v}"}, ("RS",), ({"a": "x;y"}, {"a": 'json:["z"]'})),
    "NonblockingSequence": ORDERED,
    "Parallel": Case({"success_count": "{a}"}, ("RS", "RRS", "F"), ({"a": 1}, {"a": 2})),
    "ParallelAll": Case({"max_failures": "{a}"}, ("RS", "RRF", "F"), ({"a": 1}, {"a": 3})),
    "PauseResumeController": Case({"paused": "{a}"}, ("RRS", "RS", "RS", "S"), ({"a": False}, {"a": True})),
    "PipelineSequence": ORDERED,
    "Precondition": Case({"if": "a > 1", "else": "{e}"}, ("RS",), ({"a": 2, "e": "FAILURE"}, {"a": 0, "e": "SUCCESS"})),
    "ReactiveFallback": Case({}, ("F", "RF", "RS")),
    "ReactiveSequence": Case({}, ("S", "RS", "RF")),
    "RecoveryNode": Case({"number_of_retries": "{a}"}, ("RF", "RS"), ({"a": 1}, {"a": 2})),
    "Repeat": Case({"num_cycles": "{a}"}, ("RS",), ({"a": 2}, {"a": 1.0})),
    "RetryUntilSuccessful": Case({"num_attempts": "{a}"}, ("RF",), ({"a": 2}, {"a": True})),
    "Script": Case({"code": "{a}"}, (), ({"a": "v := 1"}, {"a": "v := 2"})),
    "ScriptCondition": Case({"code": "{a}"}, (), ({"a": "1 == 1"}, {"a": "1 == 2"})),
    "Sequence": ORDERED,
    "SetBlackboard": Case({"value": "{a}", "output_key": "v"}, (), ({"a": "x"}, {"a": "y"})),
    "Sleep": Case({"msec": "{a}"}, (), ({"a": 300}, {"a": "100"})),
    "SubTree": Case({"ID": "T", "x": "{a}"}, ("RS",), ({"a": 1}, {"a": 2})),
    "Switch2": Case(
        {"variable": "{a}", "case_1": "1", "case_2": "{b}"},
        ("RS", "F", "RF"),
        ({"a": "1", "b": "x"}, {"a": "1.0", "b": "x"}),
    ),
    "TestNode": Case(
        {"return_status": "{a}", "async_delay": "{b}"}, (), ({"a": "SUCCESS", "b": 200}, {"a": "FAILURE", "b": 0})
    ),
    "Timeout": Case({"msec": "{a}"}, ("RRRRS",), ({"a": 200}, {"a": 0})),
    "TryCatch": Case({"catch_on_halt": "{a}"}, ("RS", "F", "RS"), ({"a": 0}, {"a": "true"})),
    "WhileDoElse": Case({}, ("S", "RS", "F")),
}
for cases in range(3, 7):
    switch = {"variable": "{a}"} | {f"case_{i}": str(i) for i in range(1, cases + 1)}
    CASES[f"Switch{cases}"] = Case(switch, ("RS", "F") * 4, ({"a": "1"}, {"a": "2"}))
    CASES[f"Switch{cases}"].children = CASES[f"Switch{cases}"].children[: cases + 1]


class Letters(Leaf):
    """Returns one outcome per tick of a run, the last one for ever."""

    def __init__(self, letters: str) -> None:
        super().__init__("leaf")
        self.letters, self.at = letters, 0

    def initialise(self) -> None:
        self.at = 0

    def update(self):
        letter = self.letters[min(self.at, len(self.letters) - 1)]
        self.at += 1
        return {"R": RUNNING, "S": SUCCESS, "F": FAILURE}[letter]


class Stage:
    """A node in a tree of its own."""

    def __init__(self, tag: str) -> None:
        case = CASES[tag]
        self.clock = SimulatedClock(0.1)
        self.node = BUILTIN.make(tag, tag, [Letters(letters) for letters in case.children], case.ports)
        self.tree = Tree(self.node, clock=self.clock)

    def run(self, values, ticks=TICKS) -> list[str]:
        """Outcomes and values of the keys after each tick of a run, at most `ticks`."""
        found = []
        for key, value in values.items():
            self.tree.board[key] = value
        for _ in range(ticks):
            outcome = self.tree.tick()
            self.clock.advance()
            found.append(f"{outcome_name(outcome)} {self.tree.board.texts()}")
            if outcome is not RUNNING:
                break
        return found


def test_every_standard_node_has_a_case():
    assert set(CASES) | set(KEEPS) == set(BUILTIN)


@pytest.mark.parametrize("tag", CASES)
@pytest.mark.parametrize(("first", "second"), [(0, 0), (0, 1), (1, 0)])
def test_the_second_run_is_that_of_a_new_node(tag, first, second):
    case = CASES[tag]
    for ticks, halted in itertools.product((TICKS, 1, 2), (True, False)):
        stage = Stage(tag)
        before = stage.run(case.values[first], ticks)
        if before[-1].startswith("RUNNING"):
            if not halted:
                continue
            stage.tree.halt()
        new = Stage(tag)
        new.run(case.values[first], 0)  # keys keep their first types
        for key, value in stage.tree.board.entries():
            if key not in case.values[second]:
                new.tree.board.set_local(key, value.value)
        assert stage.run(case.values[second]) == new.run(case.values[second]), (ticks, halted)
