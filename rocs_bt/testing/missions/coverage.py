"""Coverage of trees: which leaves were ticked, and which outcomes each node came to, over all tests of a session."""

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
"""The two branches of a node."""

_ONE_END: Final = {
    **dict.fromkeys(("AlwaysSuccess", "ForceSuccess", "Script", "Sleep", "UnsetBlackboard"), "SUCCESS"),
    **dict.fromkeys(("Wait", "Enter", "Speak", "Log"), "SUCCESS"),
    **dict.fromkeys(("AlwaysFailure", "ForceFailure", "KeepRunningUntilFailure"), "FAILURE"),
}
"""Nodes that come to one end only, whatever happens."""


@dataclass
class NodeCoverage:
    """What one node came to.

    Attributes:
        path: Names from the root joined by `/`; a second sibling of the same name ends in `#2`.
        kind: The name of its class, or of its action.
        depth: 0 for the root.
        leaf: Whether it has no children.
        counts: How often it came to each outcome, by name.
    """

    path: str
    kind: str
    depth: int
    leaf: bool
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def ends(self) -> tuple[str, ...]:
        """The ends that it can come to."""
        return (_ONE_END[self.kind],) if self.kind in _ONE_END else ENDS

    @property
    def name(self) -> str:
        """Its name."""
        return self.path.rsplit("/", 1)[-1]


class TreeCoverage:
    """Counts what nodes come to, by tree and path, over as many runs as it is shown.

    What was put into a tree by `inject` is looked through: a node that was broken came to what its decorator did.

    Attributes:
        trees: The nodes of each tree by its name, parents before children.
    """

    def __init__(self) -> None:
        self.trees: dict[str, dict[str, NodeCoverage]] = {}

    def watch(self, name: str, tree: Tree) -> Callable[[], None]:
        """Count what a tree's nodes come to from now on.

        Args:
            name: The tree's name; trees of one name are counted together.
            tree: The tree, bound.

        Returns:
            What to call after each tick of the tree: it looks at py_trees' own nodes, which tell nobody.
        """
        known, by_id = self.trees.setdefault(name, {}), dict[Any, NodeCoverage]()
        for node, path, depth in outline(tree.root, _whole):
            whole = _whole(node)
            made = NodeCoverage(path, identity(whole), depth, not whole.children)
            by_id[node.id] = known.setdefault(path, made)
        tree.watch(lambda node, outcome: _count(by_id, node, outcome))
        strangers = [node for node in tree.nodes if not isinstance(node, Node)]

        def ticked() -> None:
            for node in strangers:
                _count(by_id, node, node.status)

        return ticked

    def leaves(self) -> tuple[int, int]:
        """How many leaves were ticked, and how many there are."""
        found = [node for nodes in self.trees.values() for node in nodes.values() if node.leaf]
        return sum(bool(node.counts) for node in found), len(found)

    def branches(self) -> tuple[int, int]:
        """How many ends of nodes were come to, SUCCESS and FAILURE of each, and how many there are."""
        found = [node for nodes in self.trees.values() for node in nodes.values()]
        return sum(e in node.counts for node in found for e in node.ends), sum(len(node.ends) for node in found)

    def missing(self) -> list[str]:
        """What was never come to, such as `patrol: dock/GoTo never FAILURE`."""
        return [
            f"{name}: {node.path} {'never ticked' if not node.counts else f'never {end}'}"
            for name, nodes in self.trees.items()
            for node in nodes.values()
            for end in (node.ends if node.counts else ENDS[:1])
            if end not in node.counts
        ]

    def table(self) -> str:
        """All trees as text: a line a node, and how often it came to what."""
        lines = []
        for name, nodes in self.trees.items():
            lines += [f"{name:<44}      S      F      R      K"]
            lines += [_line(node) for node in nodes.values()]
        (ticked, leaves), (seen, ends) = self.leaves(), self.branches()
        return "\n".join([*lines, f"leaves {ticked}/{leaves} ticked, branches {seen}/{ends}"])


def outline(
    root: Behaviour, stands_for: Callable[[Behaviour], Behaviour] = lambda node: node
) -> Iterator[tuple[Behaviour, str, int]]:
    """All nodes with their path and depth, parents before children.

    Args:
        root: The root.
        stands_for: Which node's name and children count in a node's place.
    """
    todo = [(root, stands_for(root).name, 0)]
    while todo:
        node, path, depth = todo.pop()
        yield node, path, depth
        twins: Counter[str] = Counter()
        below = []
        for child in stands_for(node).children:
            name = stands_for(child).name
            twins[name] += 1
            suffix = f"#{twins[name]}" if twins[name] > 1 else ""
            below.append((child, f"{path}/{name}{suffix}", depth + 1))
        todo += reversed(below)


def _whole(node: Behaviour) -> Behaviour:
    """The node that was broken on purpose; what its decorator comes to is what it comes to."""
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
