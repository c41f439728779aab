"""Visits: what a tick passed, for py_trees' generators, which yield each node that was ticked."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from py_trees.behaviour import Behaviour

from ..status import Outcome


class Visits:
    """Writes down which nodes below a root are ticked, children before parents, while it listens.

    Our nodes are ticked by calls, which leave no trace. So a root that is ticked as a generator puts a wrapper around
    the ticks below it, once, and listens only while its generator is at work.

    Args:
        ours: Whether a behaviour is a node of ours.
    """

    def __init__(self, ours: Callable[[Any], bool]) -> None:
        self._ours = ours
        self._seen: list[Behaviour] | None = None

    def of(self, root: Behaviour) -> Iterator[Behaviour]:
        """Tick a root, and yield what was ticked."""
        self._install(root)
        seen: list[Behaviour] = []
        before, self._seen = self._seen, seen
        try:
            root.tick_once()
        finally:
            self._seen = before
        yield from seen

    def around(self, node: Behaviour, tick: Callable[[], Outcome]) -> Callable[[], Outcome]:
        """A tick of ours that is written down."""

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
            if not self._ours(node):
                node.__dict__["tick_once"] = self._collected(node)
                continue
            if node.visits is not self:
                node.visits = self
                node.rewire()
            todo += node.children

    def _collected(self, node: Behaviour) -> Callable[[], None]:
        """A tick of py_trees' own, whose generator tells by itself."""

        def collected() -> None:
            for visited in node.tick():
                if self._seen is not None:
                    self._seen.append(visited)

        return collected
