"""What nodes can come to, and so which of their children are never ticked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour

from ...errors import Fault
from ..nodes import BUILTIN, Node, SubTree, Tree
from .constant import constant
from .flow import scripts_of
from .place import fault_at

Outcomes = frozenset[str]
ALL = frozenset("SFRK")
"""S: SUCCESS, F: FAILURE, R: RUNNING, K: SKIPPED."""

_SEQUENCES = ("Sequence", "AsyncSequence", "SequenceWithMemory", "ReactiveSequence")
_FALLBACKS = ("Fallback", "AsyncFallback", "ReactiveFallback")
_LEAVES = {"AlwaysSuccess": "S", "AlwaysFailure": "F", "Script": "S", "Sleep": "SR", "SetBlackboard": "SF"}
_MAPPINGS = {
    "Inverter": {"S": "F", "F": "S"},
    "ForceSuccess": {"F": "S"},
    "ForceFailure": {"S": "F"},
    "KeepRunningUntilFailure": {"S": "R", "K": "R"},
}
_WORDS = {"S": "succeeds", "F": "fails", "R": "runs", "K": "is skipped"}


def unreachable(tree: Tree) -> Iterator[Fault]:
    """Children that are never ticked, whatever happens."""
    known: dict[Any, Outcomes] = {}
    found: list[Fault] = []
    for node in reversed(tree.nodes):  # children before their parents
        known[node.id] = _guarded(node, _own(node, known, found))
    yield from reversed(found)


def _own(node: Behaviour, known: dict[Any, Outcomes], found: list[Fault]) -> Outcomes:
    tag = node.tag if isinstance(node, Node) else ""
    if isinstance(node, Node) and BUILTIN.get(tag) is not type(node):
        return ALL  # one's own, or a stand-in that only bears the name, and may have fewer children
    below = [known[child.id] for child in node.children]
    if tag in _SEQUENCES or (not tag and isinstance(node, composites.Sequence)):
        return _in_order(node, below, "S", found)
    if tag in _FALLBACKS or (not tag and isinstance(node, composites.Selector)):
        return _in_order(node, below, "F", found)
    if tag in _MAPPINGS:
        return frozenset(_MAPPINGS[tag].get(outcome, outcome) for outcome in below[0])
    if tag in ("IfThenElse", "WhileDoElse"):
        return _branches(node, below, found)
    if tag in _LEAVES:
        return frozenset(_LEAVES[tag])
    if tag == "ScriptCondition" and isinstance(node, Node):
        values = [constant(script) for attribute, script in scripts_of(node) if attribute == "code"]
        return frozenset("SF" if not values or values[0] is None else "S" if values[0] else "F")
    if tag in ("Repeat", "RetryUntilSuccessful") and isinstance(node, Node):
        return _endless(node, below[0])
    return below[0] if isinstance(node, SubTree) else ALL


def _in_order(node: Behaviour, below: list[Outcomes], passes: str, found: list[Fault]) -> Outcomes:
    """A Sequence (that goes on after S) or a Fallback (after F)."""
    outcomes, reached = set[str](), True
    for child, its in zip(node.children, below, strict=True):
        if not reached:
            message = f"is never ticked: what stands before it in '{node.name}' never {_WORDS[passes]}."
            found.append(fault_at(child, message, "Change the order, or leave it out."))
            break
        outcomes |= its - {passes, "K"}
        reached = bool(its & {passes, "K"})
    if reached:
        outcomes |= {passes} if any(its != {"K"} for its in below) else set()
        outcomes |= {"K"} if all("K" in its for its in below) else set()
    yields = isinstance(node, Node) and (node.tag.startswith("Async") or node.tag == "SequenceWithMemory")
    return frozenset(outcomes | {"R"} if yields else outcomes)


def _branches(node: Behaviour, below: list[Outcomes], found: list[Fault]) -> Outcomes:
    condition, outcomes = below[0], set("R") | (below[0] & {"K"})
    for child, its, needs in zip(node.children[1:], below[1:], "SF", strict=False):
        if needs in condition:
            outcomes |= its
        else:
            name = node.children[0].name
            message = f"is never ticked: the condition '{name}' never {_WORDS[needs]}."
            found.append(fault_at(child, message, "Change the condition, or leave the branch out."))
    return frozenset(outcomes | ({"F"} if len(below) == 2 and "F" in condition else set()))


def _endless(node: Node, below: Outcomes) -> Outcomes:
    """Repeat and Retry; with -1 they never come to the outcome that they count."""
    counted, port = ("S", "num_cycles") if node.tag == "Repeat" else ("F", "num_attempts")
    never = {counted} if str(node.given.get(port)).strip() == "-1" else set()
    return (below | {"R", counted}) - never


def _guarded(node: Behaviour, own: Outcomes) -> Outcomes:
    """With pre-conditions that may decide instead of the node."""
    if not isinstance(node, Node) or not node.conditions:
        return own
    added = {"_failureIf": "F", "_successIf": "S", "_skipIf": "K", "_while": "K"}
    return own | {added[name] for name in node.conditions if name in added}
