"""Coverage of behaviour trees: the leaves that all tests of a session ticked, and the outcomes of each node."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from ...trees.nodes import Node, Tree
from ...trees.status import IDLE, Outcome, outcome_name
from .inject import Faulty
from .match import identity

if TYPE_CHECKING:
    from ...trees import Behaviour

ENDS: Final = ("SUCCESS", "FAILURE")
"""Final outcomes of a node, counted as branches."""

_ONE_END: Final = {
    **dict.fromkeys(("AlwaysSuccess", "ForceSuccess", "Script", "Sleep", "UnsetBlackboard"), "SUCCESS"),
    **dict.fromkeys(("Wait", "Enter", "Speak", "Log"), "SUCCESS"),
    **dict.fromkeys(("AlwaysFailure", "ForceFailure", "KeepRunningUntilFailure"), "FAILURE"),
}
"""Nodes with only one possible final outcome."""


@dataclass
class NodeCoverage:
    """Observed outcomes of one tree node.

    Attributes:
        path: Node names from the root, joined by `/`; a second sibling of the same name ends in `#2`.
        kind: Name of the node's class; for a leaf made by `mission.act`, of its action.
        depth: Depth of the node in the tree; 0 for the root.
        leaf: Whether the node has no children.
        counts: Number of ticks by outcome.
    """

    path: str
    kind: str
    depth: int
    leaf: bool
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def ends(self) -> tuple[str, ...]:
        """Final outcomes (SUCCESS, FAILURE) that this node can have."""
        return (_ONE_END[self.kind],) if self.kind in _ONE_END else ENDS

    @property
    def name(self) -> str:
        """Name of the node."""
        return self.path.rsplit("/", 1)[-1]


class TreeCoverage:
    """Counts the outcomes of tree nodes over any number of runs.

    Decorators from `inject` do not appear: the outcome of the decorator counts for the decorated node.

    Attributes:
        trees: Nodes of each tree by their paths, parents before children; keyed by the tree's name.
    """

    def __init__(self) -> None:
        self.trees: dict[str, dict[str, NodeCoverage]] = {}

    def watch(self, name: str, tree: Tree) -> Callable[[], None]:
        """Start counting the outcomes of a tree.

        Args:
            name: Name of the tree; trees of the same name are counted together.
            tree: The tree, bound.

        Returns:
            Function to call after each tick; it counts the outcomes of stock py_trees nodes, which do not report them.
        """
        known, by_id = self.trees.setdefault(name, {}), dict[Any, NodeCoverage]()
        for node, path, depth in outline(tree.root, _original):
            original = _original(node)
            made = NodeCoverage(path, identity(original), depth, not original.children)
            by_id[node.id] = known.setdefault(path, made)
        tree.watch(lambda node, outcome: _count(by_id, node, outcome))
        stock = [node for node in tree.nodes if not isinstance(node, Node)]

        def ticked() -> None:
            for node in stock:
                _count(by_id, node, node.status)

        return ticked

    def leaves(self) -> tuple[int, int]:
        """Number of leaves that were ticked, and total number of leaves."""
        found = [node for nodes in self.trees.values() for node in nodes.values() if node.leaf]
        return sum(bool(node.counts) for node in found), len(found)

    def branches(self) -> tuple[int, int]:
        """Number of observed final outcomes (SUCCESS and FAILURE of each node), and number of possible ones."""
        found = [node for nodes in self.trees.values() for node in nodes.values()]
        return sum(e in node.counts for node in found for e in node.ends), sum(len(node.ends) for node in found)

    def missing(self) -> list[str]:
        """Return a text for each node or outcome that was not tested, such as `patrol: dock/GoTo never FAILURE`."""
        return [
            f"{name}: {node.path} {'never ticked' if not node.counts else f'never {end}'}"
            for name, nodes in self.trees.items()
            for node in nodes.values()
            for end in (node.ends if node.counts else ENDS[:1])
            if end not in node.counts
        ]

    def table(self) -> str:
        """Return all trees as a table: one line per node, with the number of ticks by outcome."""
        lines = []
        for name, nodes in self.trees.items():
            lines += [f"{name:<44}      S      F      R      K"]
            lines += [_line(node) for node in nodes.values()]
        (ticked, leaves), (seen, ends) = self.leaves(), self.branches()
        return "\n".join([*lines, f"leaves {ticked}/{leaves} ticked, branches {seen}/{ends}"])


def outline(
    root: Behaviour, original: Callable[[Behaviour], Behaviour] = lambda node: node
) -> Iterator[tuple[Behaviour, str, int]]:
    """Iterate over the nodes of a tree, each with its path and depth, parents before children."""
    todo = [(root, original(root).name, 0)]
    while todo:
        node, path, depth = todo.pop()
        yield node, path, depth
        twins: Counter[str] = Counter()
        below = []
        for child in original(node).children:
            name = original(child).name
            twins[name] += 1
            suffix = f"#{twins[name]}" if twins[name] > 1 else ""
            below.append((child, f"{path}/{name}{suffix}", depth + 1))
        todo += reversed(below)


def _original(node: Behaviour) -> Behaviour:
    """Node inside decorators from `inject`."""
    while isinstance(node, Faulty):
        node = node.decorated
    return node


def _count(by_id: dict[Any, NodeCoverage], node: Behaviour, outcome: Outcome) -> None:
    if outcome is not IDLE and node.id in by_id:
        by_id[node.id].counts[outcome_name(outcome)] += 1


def _line(node: NodeCoverage) -> str:
    cells = []
    for outcome in ("SUCCESS", "FAILURE", "RUNNING", "SKIPPED"):
        count = node.counts.get(outcome, 0)
        cells.append(f"{count or ('!' if outcome in node.ends else '-'):>7}")
    mark = "" if node.counts else "   never ticked"
    return f"{'  ' * (node.depth + 1) + node.name:<44}"[:44] + "".join(cells) + mark
