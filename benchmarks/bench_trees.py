"""What a tick costs, beside BehaviorTree.CPP (behaviortreepy) and stock py_trees in the same process, in CPU time.

Run it with `python benchmarks trees`, or all benchmarks with `make bench`. The C++ engine is measured twice,
ticked from Python and turning round in a Repeat of its own; the faster one counts. py_trees is ticked by `tick_once`,
which is faster than its BehaviourTree. Rounds are interleaved, and the fastest one of each counts: what else runs on
the machine only adds.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, Running, Success
from row import Row, size

from rocs_bt.clock import SimulatedClock
from rocs_bt.plan.nodes import BUILTIN, Tree
from rocs_bt.plan.xml import load_tree

try:
    import behaviortreepy
except ImportError:
    behaviortreepy = None

ROUNDS = size(15, 1)
ROUND = size(1e7, 1e4)  # [ns] CPU time of a round
TIMES = size(20, 1)  # calls that find out how many fill a round
LONG = "100000000"


class Shape:
    """A tree to measure, as tags with attributes and children, and how py_trees would build it."""

    def __init__(self, name: str, tag: str, *children: Shape, count: int = 1, wide: bool = False, **attributes: str):
        self.name, self.tag, self.attributes = name, tag, attributes
        self.children = list(children) * count
        self.wide = wide

    def ours(self) -> Behaviour:
        return BUILTIN.make(self.tag, self.tag, [c.ours() for c in self.children], self.attributes)

    def xml(self) -> str:
        attributes = "".join(f' {n}="{v.replace("<", "&lt;")}"' for n, v in self.attributes.items())
        return f"<{self.tag}{attributes}>{''.join(c.xml() for c in self.children)}</{self.tag}>"

    def stock(self) -> Behaviour:
        children = [c.stock() for c in self.children]
        composites = py_trees.composites
        made: Mapping[str, Callable[[], Behaviour]] = {
            "AlwaysSuccess": lambda: Success("s"),
            "AlwaysFailure": lambda: Failure("f"),
            "Sleep": lambda: Running("r"),
            "Sequence": lambda: composites.Sequence("s", memory=True, children=children),
            "Fallback": lambda: composites.Selector("f", memory=True, children=children),
            "ReactiveFallback": lambda: composites.Selector("f", memory=False, children=children),
            "Parallel": lambda: composites.Parallel("p", py_trees.common.ParallelPolicy.SuccessOnAll(), children),
            "Inverter": lambda: py_trees.decorators.Inverter("i", children[0]),
        }
        return made[self.tag]()


def shapes() -> list[Shape]:
    """The trees."""
    good, bad, busy = Shape("", "AlwaysSuccess"), Shape("", "AlwaysFailure"), Shape("", "Sleep", msec=LONG)
    chain = busy
    for _ in range(20):
        chain = Shape("chain of 20 sequences over a running leaf", "Sequence", chain)
    inverters = good
    for _ in range(20):
        inverters = Shape("20 decorators over a leaf", "Inverter", inverters)
    return [
        Shape("sequence of 10 leaves", "Sequence", good, count=10),
        Shape("fallback of 100 leaves that fail", "Fallback", bad, count=100, wide=True),
        Shape("reactive fallback, 9 fail and 1 runs", "ReactiveFallback", *[bad] * 9, busy),
        Shape("reactive fallback, 98 fail and 1 runs", "ReactiveFallback", *[bad] * 98, busy, wide=True),
        chain,
        inverters,
        Shape("parallel of 10 leaves", "Parallel", good, count=10),
        Shape("sequence of 10 sequences of 10 leaves", "Sequence", Shape("", "Sequence", good, count=10), count=10),
    ]


def guarded() -> Shape:
    """A tree with scripts, which py_trees has not."""
    return Shape("sequence of 10 leaves with a _skipIf each", "Sequence", guarded_leaf(), count=10)


def guarded_leaf() -> Shape:
    return Shape("", "AlwaysSuccess", _skipIf="x < 3")


def run() -> Iterator[Row]:
    """All rows."""
    for shape in [*shapes(), guarded()]:
        yield from measured(shape)
    yield loading()
    yield from_xml()


def measured(shape: Shape) -> list[Row]:
    """A shape's rows: beside C++, and beside py_trees."""
    tree = Tree(shape.ours(), clock=SimulatedClock(0.1))
    tree.board["x"] = 5.0
    contestants: dict[str, Callable[[], float]] = {"ours": timed(tree.tick)}
    if shape.tag != "Sequence" or "_skipIf" not in shape.xml():
        contestants["py_trees"] = timed(shape.stock().tick_once)
    if behaviortreepy is not None:
        contestants |= cpp(shape)
    best = {name: min(values) for name, values in interleaved(contestants).items()}
    name, ours = f"tick: {shape.name}", best["ours"]
    rows = []
    theirs = [best[n] for n in ("C++ called", "C++ alone") if n in best]
    if theirs:
        ratio = ours / min(theirs)
        rows.append(Row(name, ours, "us", "BehaviorTree.CPP 4.8.2", ratio, "<= 1x", ratio <= 1.0))
    if "py_trees" in best:
        times = 10 if shape.wide else 6
        ratio = best["py_trees"] / ours
        words = f">= {times}x as many ticks"
        rows.append(Row(name, 1e6 / ours, "1/s", "py_trees", ratio, words, ratio >= times))
    return rows


def interleaved(contestants: Mapping[str, Callable[[], float]]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(ROUNDS):
        for name, once in contestants.items():
            found[name].append(once())
    return found


def timed(call: Callable[[], object]) -> Callable[[], float]:
    """One round: the CPU time of a call, the empty loop included [us]."""
    call()
    start = time.process_time_ns()
    for _ in range(TIMES):
        call()
    count = max(TIMES, int(ROUND / max((time.process_time_ns() - start) / TIMES, 1.0)))

    def once() -> float:
        start = time.process_time_ns()
        for _ in itertools.repeat(None, count):
            call()
        return (time.process_time_ns() - start) / count / 1e3

    return once


def cpp(shape: Shape) -> dict[str, Callable[[], float]]:
    """The C++ engine, called from Python, and alone in a Repeat for trees that end."""
    called = theirs(shape.xml()).tick_exactly_once
    found = {"C++ called": timed(called)}
    if "Sleep" not in shape.xml():
        rounds = size(2000, 2)
        alone = theirs(f'<Repeat num_cycles="{rounds}"><ForceSuccess>{shape.xml()}</ForceSuccess></Repeat>').tick_once

        def once() -> float:
            start = time.process_time_ns()
            alone()  # Repeat wakes the tree after each round, so this is all of them
            return (time.process_time_ns() - start) / rounds / 1e3

        found["C++ alone"] = once
    return found


def theirs(xml: str) -> behaviortreepy.Tree:
    board = behaviortreepy.Blackboard.create()
    board.set_double("x", 5.0)
    factory = behaviortreepy.BehaviorTreeFactory()
    text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{xml}</BehaviorTree></root>'
    tree = factory.create_tree_from_text(text, board)
    KEPT.append(factory)
    return tree


KEPT: list[object] = []
"""Factories, which their trees need."""


def loading() -> Row:
    """How long 1000 nodes take to be made and bound."""
    shape = Shape("", "Sequence", Shape("", "Sequence", guarded_leaf(), count=9), count=100)

    def once() -> float:
        start = time.process_time_ns()
        Tree(shape.ours())
        return (time.process_time_ns() - start) / 1e6

    value = min(once() for _ in range(5))
    return Row("tree: make and bind 1000 nodes, 900 with a script", value, "ms", "", None, "<= 100 ms", value <= 100.0)


def from_xml() -> Row:
    """How long the same document takes to be read, checked, made and bound."""
    shape = Shape("", "Sequence", Shape("", "Sequence", guarded_leaf(), count=9), count=100)
    text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{shape.xml()}</BehaviorTree></root>'

    def once() -> float:
        start = time.process_time_ns()
        Tree(load_tree(text))
        return (time.process_time_ns() - start) / 1e6

    value = min(once() for _ in range(5))
    return Row("tree: load 1000 nodes from XML", value, "ms", "", None, "<= 100 ms", value <= 100.0)
