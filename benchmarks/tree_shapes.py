"""Trees for `bench_trees`: flat, deep, and with scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, Running, Success

from rocs_bt.trees.nodes import BUILTIN

LONG = "100000000"
ONE = "y := x + 1"
FIVE = "y := x + 1; z := y * 2; w := z > x ? 1 : 0; v := 'state'; u += 1"


class Shape:
    """A tree as tags with attributes and children.

    Args:
        name: Name of the row.
        tag: Tag of the root.
        children: Trees below the root.
        count: Number of times that the children are repeated.
        budget: Largest ratio to the time of BehaviorTree.CPP.
        attributes: Ports and conditions of the root.
    """

    def __init__(
        self, name: str, tag: str, *children: Shape, count: int = 1, budget: float = 1.0, **attributes: str
    ) -> None:
        self.name, self.tag, self.attributes = name, tag, attributes
        self.children = list(children) * count
        self.budget = budget

    def ours(self) -> Behaviour:
        """The tree in rocs_bt."""
        return BUILTIN.make(self.tag, self.tag, [c.ours() for c in self.children], self.attributes)

    def xml(self) -> str:
        """The tree as an element."""
        attributes = "".join(f' {n}="{v.replace("<", "&lt;")}"' for n, v in self.attributes.items())
        return f"<{self.tag}{attributes}>{''.join(c.xml() for c in self.children)}</{self.tag}>"

    def stock(self) -> Behaviour | None:
        """The tree in py_trees; None if py_trees lacks one of its nodes."""
        children = [c.stock() for c in self.children]
        make = _STOCK.get(self.tag)
        if make is None or None in children or any(name.startswith("_") for name in self.attributes):
            return None
        return make([c for c in children if c is not None])


_STOCK: Mapping[str, Callable[[list[Behaviour]], Behaviour]] = {
    "AlwaysSuccess": lambda children: Success("s"),
    "AlwaysFailure": lambda children: Failure("f"),
    "Sleep": lambda children: Running("r"),
    "Sequence": lambda children: py_trees.composites.Sequence("s", memory=True, children=children),
    "Fallback": lambda children: py_trees.composites.Selector("f", memory=True, children=children),
    "ReactiveSequence": lambda children: py_trees.composites.Sequence("s", memory=False, children=children),
    "ReactiveFallback": lambda children: py_trees.composites.Selector("f", memory=False, children=children),
    "Parallel": lambda children: py_trees.composites.Parallel(
        "p", py_trees.common.ParallelPolicy.SuccessOnAll(), children
    ),
    "Inverter": lambda children: py_trees.decorators.Inverter("i", children[0]),
    "ForceSuccess": lambda children: py_trees.decorators.FailureIsSuccess("s", children[0]),
}

_GOOD, _BAD, _BUSY = Shape("", "AlwaysSuccess"), Shape("", "AlwaysFailure"), Shape("", "Sleep", msec=LONG)


def flat() -> Iterator[Shape]:
    """Flat, wide and reactive trees."""
    yield Shape("sequence of 10 leaves", "Sequence", _GOOD, count=10)
    yield Shape("fallback of 100 leaves that fail", "Fallback", _BAD, count=100)
    yield Shape("reactive fallback, 9 fail and 1 runs", "ReactiveFallback", *[_BAD] * 9, _BUSY)
    yield Shape("reactive fallback, 98 fail and 1 runs", "ReactiveFallback", *[_BAD] * 98, _BUSY)
    yield Shape("parallel of 10 leaves", "Parallel", _GOOD, count=10)
    ten = Shape("", "Sequence", _GOOD, count=10)
    yield Shape("sequence of 10 sequences of 10 leaves", "Sequence", ten, count=10)


def deep() -> Iterator[Shape]:
    """Chains of 10 and 100 of each control and decorator, over a running leaf and over one that ends."""
    chains: list[tuple[str, dict[str, str], list[Shape]]] = [
        ("Sequence", {}, []),
        ("Fallback", {}, []),
        ("ReactiveSequence", {}, []),
        ("ReactiveFallback", {}, []),
        ("Parallel", {}, []),
        ("Inverter", {}, []),
        ("ForceSuccess", {}, []),
        ("Repeat", {"num_cycles": "3"}, []),
        ("RetryUntilSuccessful", {"num_attempts": "3"}, []),
        ("Timeout", {"msec": LONG}, []),
        ("Precondition", {"if": "x > 3"}, []),
        ("IfThenElse", {}, [_GOOD]),
        ("WhileDoElse", {}, [_GOOD]),
    ]
    for tag, attributes, first in chains:
        for count in (10, 100):
            yield chain(tag, count, "that runs", _BUSY, attributes, first)
    for tag in ("Sequence", "Fallback", "ReactiveSequence", "Parallel", "Inverter"):
        for count in (10, 100):
            yield chain(tag, count, "that succeeds", _GOOD, {}, [])


def chain(tag: str, count: int, state: str, leaf: Shape, attributes: dict[str, str], first: list[Shape]) -> Shape:
    """A chain of nested nodes over a leaf; each node also has the same first children."""
    name = f"chain of {count} {tag} over a leaf {state}"
    for _ in range(count):
        leaf = Shape(name, tag, *first, leaf, budget=2.0, **attributes)
    return leaf


def scripted() -> Iterator[Shape]:
    """Ten leaves with a guard, a script or an assignment each."""
    guards: list[dict[str, str]] = [
        {"_skipIf": "x < 3"},
        {"_skipIf": "t == 'none'"},
        {"_while": "x > 3"},
        {"_onSuccess": ONE},
        {"_post": ONE},
        {"_skipIf": "x < 3", "_onSuccess": "u += 1"},
        {"_failureIf": "x < 1", "_successIf": "x < 2", "_skipIf": "x < 3"},
        {"_skipIf": "x < 3", "_onSuccess": FIVE},
    ]
    for guard in guards:
        statements = " of five statements" if FIVE in guard.values() else ""
        yield _ten(f"AlwaysSuccess with {' and '.join(guard)}{statements}", "AlwaysSuccess", **guard)
    yield _ten("Script of one statement", "Script", code=ONE)
    yield _ten("Script of five statements", "Script", code=FIVE)
    yield _ten("ScriptCondition", "ScriptCondition", code="x > 3 && x < 9 || t == 'none'")
    yield _ten("SetBlackboard of a text", "SetBlackboard", value="7", output_key="q")
    yield _ten("SetBlackboard of a number", "SetBlackboard", value="7", output_key="y")
    yield _ten("SetBlackboard of a key", "SetBlackboard", value="{x}", output_key="q")


def _ten(name: str, tag: str, **attributes: str) -> Shape:
    return Shape(f"10 {name}", "Sequence", Shape("", tag, **attributes), count=10, budget=2.0)
