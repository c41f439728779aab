"""Cost of a tick, relative to BehaviorTree.CPP (behaviortreepy) and stock py_trees in the same process, in CPU time.

Run it with `python benchmarks trees`, or all benchmarks with `make bench`. The C++ engine is measured twice, ticked
from Python and looping in its own Repeat node; the faster figure counts. py_trees is ticked by `tick_once`, which is
faster than its BehaviourTree. Rounds are interleaved, and the fastest round of each counts, since other load only adds
time.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping

from row import Row, size
from tree_shapes import Shape, deep, flat, scripted

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.trees.nodes import Tree

try:
    import behaviortreepy
except ImportError:
    behaviortreepy = None

ROUNDS = size(15, 1)
ROUND = size(1e7, 1e4)  # [ns] CPU time of a round
TIMES = size(20, 1)  # calls that estimate the number of calls per round


KEYS = {"x": 5.0, "y": 0.0, "z": 0.0, "u": 0.0, "t": "some"}
"""Blackboard of all trees."""


def run() -> Iterator[Row]:
    """All rows."""
    for shape in [*flat(), *deep(), *scripted()]:
        yield from measured(shape)


def measured(shape: Shape) -> list[Row]:
    """Rows of a shape: relative to C++ and to py_trees."""
    tree = Tree(shape.ours(), clock=SimulatedClock(0.1))
    tree.board.update(KEYS)
    contestants: dict[str, Callable[[], float]] = {"ours": timed(tree.tick)}
    if (stock := shape.stock()) is not None:
        contestants["py_trees"] = timed(stock.tick_once)
    if behaviortreepy is not None:
        contestants |= cpp(shape)
    best = {name: min(values) for name, values in interleaved(contestants).items()}
    name, ours = f"tick: {shape.name}", best["ours"]
    rows = []
    theirs = [best[n] for n in ("C++ called", "C++ alone") if n in best]
    if theirs:
        ratio = ours / min(theirs)
        words = f"<= {shape.budget:g}x"
        rows.append(Row(name, ours, "us", "BehaviorTree.CPP 4.8.2", ratio, words, ratio <= shape.budget))
    if "py_trees" in best:
        ratio = best["py_trees"] / ours
        rows.append(Row(name, 1e6 / ours, "1/s", "py_trees", ratio, ">= 10x as many ticks", ratio >= 10))
    return rows


def interleaved(contestants: Mapping[str, Callable[[], float]]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(ROUNDS):
        for name, once in contestants.items():
            found[name].append(once())
    return found


def timed(call: Callable[[], object]) -> Callable[[], float]:
    """Function that measures one round: CPU time of a call, including the loop [us]."""
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
    """The C++ engine called from Python, and looping in its own Repeat for trees that end."""
    called = theirs(shape.xml()).tick_exactly_once
    found = {"C++ called": timed(called)}
    if "Sleep" not in shape.xml():
        rounds = size(2000, 2)
        alone = theirs(f'<Repeat num_cycles="{rounds}"><ForceSuccess>{shape.xml()}</ForceSuccess></Repeat>').tick_once

        def once() -> float:
            start = time.process_time_ns()
            alone()  # Repeat wakes the tree after each cycle, so one call runs all cycles
            return (time.process_time_ns() - start) / rounds / 1e3

        found["C++ alone"] = once
    return found


def theirs(xml: str) -> behaviortreepy.Tree:
    board = behaviortreepy.Blackboard.create()
    for key, value in KEYS.items():
        board.set_string(key, value) if isinstance(value, str) else board.set_double(key, value)
    factory = behaviortreepy.BehaviorTreeFactory()
    text = f'<root BTCPP_format="4"><BehaviorTree ID="Main">{xml}</BehaviorTree></root>'
    tree = factory.create_tree_from_text(text, board)
    KEPT.append(factory)
    return tree


KEPT: list[object] = []
"""Factories, kept alive for their trees."""
