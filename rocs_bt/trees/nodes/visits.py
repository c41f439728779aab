"""Visits: recorder of the nodes that a tick reaches, for py_trees' `tick` generator, which yields these nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from py_trees.behaviour import Behaviour

from ..status import Outcome


class Visits:
    """Recorder of the nodes below a root that are ticked, children before parents.

    Nodes of this package are ticked by direct calls, which yield nothing. A root that is ticked as a generator
    therefore wraps the ticks of its descendants, once, and records them only while its generator runs.
    """

    def __init__(self, is_own: Callable[[Any], bool]) -> None:
        self._is_own = is_own
        self._seen: list[Behaviour] | None = None

    def of(self, root: Behaviour) -> Iterator[Behaviour]:
        """Tick a root and yield the nodes that were ticked."""
        self._install(root)
        seen: list[Behaviour] = []
        before, self._seen = self._seen, seen
        try:
            root.tick_once()
        finally:
            self._seen = before
        yield from seen

    def around(self, node: Behaviour, tick: Callable[[], Outcome]) -> Callable[[], Outcome]:
        """Wrap the tick function of a node so that each tick is recorded."""

        def visited() -> Outcome:
            outcome = tick()
            if self._seen is not None:
                self._seen.append(node)
            return outcome

        return visited

    def _install(self, root: Behaviour) -> None:
        todo: list[Any] = [root]
        while todo:
            node = todo.pop()
            if not self._is_own(node):
                node.__dict__["tick_once"] = self._collected(node)
                continue
            if node.visits is not self:
                node.visits = self
                node.rewire()
            todo += node.children

    def _collected(self, node: Behaviour) -> Callable[[], None]:
        """Tick function for a stock py_trees behaviour; it records the nodes that the behaviour's generator yields."""

        def collected() -> None:
            for visited in node.tick():
                if self._seen is not None:
                    self._seen.append(visited)

        return collected
