"""Check for reactive nodes with first children that interrupt the later ones in each tick."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour

from ...base.errors import Fault
from ..nodes import CONDITIONS, Instant, Node, Tree
from ..nodes.tree import fault_at

_INSTANT_SUCCESS = ("AlwaysSuccess", "Script")
_DECORATORS = ("Inverter", "ForceSuccess", "ForceFailure", "Repeat", "RetryUntilSuccessful", "Timeout", "SubTree")
_TICK_FIRST = (*_DECORATORS, "Fallback", "ReactiveFallback", "AsyncFallback")
_SEQUENCES = ("Sequence", "ReactiveSequence", "AsyncSequence")


def restart_faults(tree: Tree) -> Iterator[Fault]:
    """Warnings about ReactiveSequence and ReactiveFallback with a child, not the last one, that begins as RUNNING.

    A reactive node ticks its children from the first one in each tick. When such a child has ended and a later child is
    RUNNING, the next tick starts the first one again, which halts the later one: it is restarted for ever.
    """
    for node in tree.nodes:
        if not isinstance(node, Node) or node.tag not in ("ReactiveSequence", "ReactiveFallback"):
            continue
        for index, child in enumerate(node.children[:-1]):
            later = next((other for other in node.children[index + 1 :] if _may_run(other)), None)
            if later is not None and _begins_running(child):
                hint = "Use a Sequence; or put before the last child only conditions and nodes that end at once."
                message = f"is RUNNING at the start of each run, and so restarts '{later.name}' for ever."
                yield fault_at(child, f"{message[:-1]}: '{node.name}' ticks both again in each tick.", hint)
                break


def _begins_running(node: Behaviour) -> bool:
    """Whether the first tick of each run of a node returns RUNNING, as far as the classes of its nodes tell."""
    while isinstance(node, Node) and not any(name in node.conditions for name in CONDITIONS[:4]):
        if node.begins_running():
            return True
        if node.tag in _SEQUENCES:
            following = (c for c in node.children if getattr(c, "tag", "") not in _INSTANT_SUCCESS)
            first = next(following, None)
        else:
            first = node.children[0] if node.tag in _TICK_FIRST else None
        if first is None:
            return False
        node = first
    return False


def _may_run(node: Behaviour) -> bool:
    """Whether a node may be RUNNING after a tick: it contains a leaf that is not known to end at once."""
    leaves = (each for each in node.iterate() if not each.children)
    return any(not isinstance(leaf, Instant) and getattr(leaf, "kind", "") != "Condition" for leaf in leaves)
