"""TreeState: statuses of the nodes of a mission's tree, followed through the events of a run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..event import NodeTicked, SubtreeSwapped
from .header import TreeNode, nodes_after


class TreeState:
    """Statuses of the nodes of a mission's tree.

    Args:
        nodes: Nodes of the tree, parents before children.

    Attributes:
        events: Last event of each node that has been ticked, in the order of the first events.
        since: Time of the last change of the status of each of these nodes [s].
    """

    def __init__(self, nodes: Iterable[TreeNode] = ()) -> None:
        self.events: dict[str, NodeTicked] = {}
        self.since: dict[str, float] = {}
        self._set(nodes)

    def _set(self, nodes: Iterable[TreeNode]) -> None:
        self._children = {node.path: node.children for node in nodes}
        self._root = next(iter(self._children), "")

    def take(self, event: NodeTicked) -> None:
        """Add an event of a node."""
        before = self.events.get(event.node)
        if before is None or before.status != event.status:
            self.since[event.node] = event.t
        self.events[event.node] = event

    def swap(self, event: SubtreeSwapped) -> None:
        """Replace the nodes of the tree."""
        self._set(nodes_after(event))
        for path in [p for p in self.events if p not in self._children]:
            del self.events[path], self.since[path]

    @property
    def root(self) -> NodeTicked | None:
        """Last event of the root; None before the first tick."""
        return self.events.get(self._root)

    def waiting(self) -> list[tuple[NodeTicked, float]]:
        """Nodes in which a RUNNING tree waits, each with the time from which it does [s].

        These are the RUNNING leaves, and below a RUNNING node without RUNNING children the node that was ticked last.
        """
        if self.root is None or self.root.status != "RUNNING":
            return []
        return [(self.events[path], self.since[path]) for path in self._front(self._root)]

    def deadlines(self, path: str) -> list[str]:
        """What the RUNNING nodes above a node wait for, such as the deadline of a Timeout; nearest first."""
        parents = {child: parent for parent, children in self._children.items() for child in children}
        found = []
        while (path := parents.get(path, "")) in self.events:
            event = self.events[path]
            if event.status == "RUNNING" and event.feedback:
                found.append(event.feedback)
        return found

    def failed(self) -> NodeTicked | None:
        """Last event of the leaf that made the root fail; None if the root has not failed."""
        if self.root is None or self.root.status != "FAILURE":
            return None
        return self.events[self._last(self._root)]

    def _front(self, path: str) -> Iterator[str]:
        children = [child for child in self._children.get(path, ()) if child in self.events]
        running = [child for child in children if self.events[child].status == "RUNNING"]
        for child in running:
            yield from self._front(child)
        if not running:
            yield self._last(path)

    def _last(self, path: str) -> str:
        """Node below a path that was ticked last and gave its outcome; the path itself if there is none."""
        while True:
            status = self.events[path].status
            below = [e for child in self._children.get(path, ()) if (e := self.events.get(child)) is not None]
            ended = [e for e in below if e.status != "INVALID"]
            if not ended:
                return path
            same = [e for e in ended if e.status == status] or ended
            path = max(enumerate(same), key=lambda item: (item[1].t, item[0]))[1].node
