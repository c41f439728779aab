"""SubTree: a tree within a tree, with its own blackboard."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour

from ...base.errors import Fault
from ..board import Board
from ..error import TreeError
from ..status import IDLE, RUNNING, SKIPPED, Outcome
from ..value import from_string
from .base_classes import Decorator, no_outcome
from .guard import CONDITIONS
from .node import RESERVED
from .port import ExactKey, pointed
from .runtime import Runtime


class SubTree(Decorator):
    """Ticks another tree, which has a blackboard of its own.

    `goal="{dock}"` makes the subtree's key `goal` refer to the key `dock` of the outer tree, `goal="{=}"` to the outer
    key `goal`. `goal="home"` writes the text `home` to the subtree's own key `goal`; so does `goal="="` with `=`.
    `_autoremap="true"` makes all other keys refer to the outer keys of the same name, except private ones, which begin
    with `_`.

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
            return [(self.decorated, self._inner)]  # bound again after another part of the tree was edited
        inner = self._inner = Board(board, autoremap=self.autoremap, name=self.name)
        for name, given in self.remaps.items():
            key = _key(given, name)
            if key is not None:
                inner.remapping[name] = key
            else:
                value = literal(given)
                inner.set_local(name, value, given if value is not given else None)
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
    """Outer key of a remapping; None for a literal. As in BehaviorTree.CPP, `=` without braces is a literal here."""
    if isinstance(given, ExactKey):
        return str(given)
    return None if given == "=" else pointed(given, name)


def literal(given: Any) -> Any:
    """Literal as stored on the subtree's blackboard: a number if the text can be converted to one, else the text."""
    if not isinstance(given, str):
        return given
    for kind in (int, float):
        try:
            return from_string(given, kind)
        except TreeError:
            continue
    return given
