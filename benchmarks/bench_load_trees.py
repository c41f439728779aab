"""CPU time of loading 10,000 nodes of XML, relative to BehaviorTree.CPP (behaviortreepy) in the same process.

Both parse and check the text, create the nodes and bind them to a blackboard. Rounds are interleaved, and the fastest
round of each counts.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator

from row import Row, size

from rocs_bt.trees.nodes import Tree
from rocs_bt.trees.xml import load_xml

try:
    import behaviortreepy
except ImportError:
    behaviortreepy = None

NODES = size(10_000, 20)
ROUNDS = size(5, 1)
BUDGET = 8.0


def run() -> Iterator[Row]:
    """All rows."""
    for name, text in documents().items():
        yield measured(f"load: {NODES} nodes, {name}", text)


def documents() -> dict[str, str]:
    """Documents by their distinguishing feature."""
    five = "a := {0}; b := a + {0}; c += 1; d := a * b; e := 's{0}'"
    return {
        "no attributes": flat("AlwaysSuccess", ""),
        "named": flat("AlwaysSuccess", 'name="leaf {0}"'),
        "in groups of 9, indented": groups(),
        "equal _skipIf": flat("AlwaysSuccess", '_skipIf="x &lt; 3"'),
        "distinct _skipIf": flat("AlwaysSuccess", '_skipIf="x{0} &lt; {0}"'),
        "distinct _onSuccess": flat("AlwaysSuccess", '_onSuccess="x := {0}"'),
        "distinct _onSuccess of five statements": flat("AlwaysSuccess", f'_onSuccess="{five}"'),
        "distinct Script": flat("Script", 'code="x := {0}"'),
        "SetBlackboard": flat("SetBlackboard", 'value="{0}" output_key="key"'),
    }


def flat(tag: str, attributes: str) -> str:
    """A sequence of nodes; attributes may contain the node's number."""
    return document("".join(f"<{tag} {attributes.format(i)}/>" for i in range(NODES)))


def groups() -> str:
    """Sequences of nine nodes, one node per line."""
    leaves = "".join('\n        <AlwaysSuccess name="leaf"/>' for _ in range(9))
    return document(f"\n      <Sequence>{leaves}\n      </Sequence>" * (NODES // 10))


def document(inside: str) -> str:
    """A document with a single tree, a sequence."""
    return f'<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>{inside}</Sequence></BehaviorTree></root>'


def measured(name: str, text: str) -> Row:
    """Row of a document."""
    contestants: dict[str, Callable[[str], object]] = {"ours": lambda text: Tree(load_xml(text))}
    if behaviortreepy is not None:
        contestants["C++"] = theirs
    best = dict.fromkeys(contestants, float("inf"))
    for _ in range(ROUNDS):
        for contestant, load in contestants.items():
            best[contestant] = min(best[contestant], timed(load, text))
    if "C++" not in best:
        return Row(name, best["ours"], "ms")
    ratio = best["ours"] / best["C++"]
    return Row(name, best["ours"], "ms", "BehaviorTree.CPP 4.8.2", ratio, f"<= {BUDGET:g}x", ratio <= BUDGET)


def timed(load: Callable[[str], object], text: str) -> float:
    """CPU time of a load [ms], without the disposal of its result."""
    gc.collect()
    start = time.process_time_ns()
    kept = load(text)
    took = (time.process_time_ns() - start) / 1e6
    del kept
    return took


def theirs(text: str) -> object:
    """Load with BehaviorTree.CPP."""
    factory = behaviortreepy.BehaviorTreeFactory()
    return factory.create_tree_from_text(text, behaviortreepy.Blackboard.create()), factory
