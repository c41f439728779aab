"""SubTree: a tree within a tree, with its own blackboard."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour

from ...errors import Fault
from ..board import Board, from_string
from ..error import TreeError
from ..status import IDLE, RUNNING, SKIPPED, Outcome
from .family import Decorator, no_outcome
from .guard import CONDITIONS
from .node import RESERVED
from .port import ExactKey, pointed
from .runtime import Runtime


class SubTree(Decorator):
    """Ticks another tree, which has its own keys except for those that are remapped.

    `goal="{dock}"` makes the subtree's key `goal` the key `dock` of this tree, `goal="{=}"` the key `goal`.
    `goal="home"`
    gives the subtree a value of its own, and so does `goal="="`. `_autoremap="true"` maps all other keys to this tree's
    keys of the same name, except private ones, which begin with `_`.

    Args:
        name: Name in displays.
        child: Root of the subtree.
        attributes: `ID`, the tree's name; `_autoremap`; conditions; all others are remappings.
    """

    kind = "SubTree"

    def __init__(self, name: str, child: Behaviour | Sequence[Behaviour], /, **attributes: Any) -> None:
        self.remaps = {n: v for n, v in attributes.items() if n not in RESERVED and n not in CONDITIONS and n[0] != "_"}
        self.tree = str(attributes.get("ID", name))
        self.autoremap = from_string(str(attributes.get("_autoremap", "false")), bool)
        super().__init__(name, child, **{n: v for n, v in attributes.items() if n not in self.remaps and n != "ID"})
        self.given = dict(self.remaps)
        self._inner: Board | None = None

    @classmethod
    def attribute_faults(cls, attributes: Mapping[str, Any]) -> list[tuple[str, Fault]]:
        known = {n: v for n, v in attributes.items() if n in CONDITIONS or n in RESERVED or n.startswith("_")}
        return super().attribute_faults(known)

    def bind(self, board: Board, runtime: Runtime) -> Iterable[tuple[Behaviour, Board]]:
        super().bind(board, runtime)
        if self._inner is not None and self._inner.parent is board:
            return [(self.decorated, self._inner)]  # another part of the tree was edited; keep this subtree's values
        inner = self._inner = Board(board, autoremap=self.autoremap, name=self.name)
        for name, given in self.remaps.items():
            key = _key(given, name)
            if key is not None:
                inner.remapping[name] = key
            else:
                inner.set_local(name, _literal(given))
        return [(self.decorated, inner)]

    def tick_once(self) -> Outcome:
        self.status = RUNNING
        child: Any = self.decorated
        outcome = child.tick_once() or child.status
        if outcome is IDLE:
            raise no_outcome(child, outcome)
        if outcome is not SKIPPED:
            self.status = outcome
        return outcome


def _key(given: Any, name: str) -> str | None:
    """Outer key of a remapping; None for a literal, which `=` without braces is here, as in BehaviorTree.CPP."""
    if isinstance(given, ExactKey):
        return str(given)
    return None if given == "=" else pointed(given, name)


def _literal(given: Any) -> Any:
    """Literal as stored on the subtree's blackboard: a number if it reads as one, else text."""
    if not isinstance(given, str):
        return given
    for kind in (int, float):
        try:
            return from_string(given, kind)
        except TreeError:
            continue
    return given
