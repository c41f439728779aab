"""Changes of blackboard values, for recordings: only keys that changed, each as a short text."""

from __future__ import annotations

import reprlib
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from typing import Any

from ..trees.board import Board, BoardEntry
from ..trees.nodes import Tree
from ..trees.xml.write import value_text

MAX_TEXT = 120
"""Maximum length of a recorded value [characters]; longer ones are cut."""

_MUTABLE = frozenset((list, dict, set, deque))  # values that nodes change in place, such as a queue


class _Short(reprlib.Repr):
    """Texts of lists and objects, with short numbers: 16 digits of a route say nothing to people."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = MAX_TEXT

    def repr_float(self, x: float, level: int) -> str:
        return f"{x:.6g}"


_SHORT = _Short()


class BoardChanges:
    """Finds the keys with values that changed since the last call, on the blackboards of a tree and its subtrees."""

    def __init__(self, tree: Tree) -> None:
        self._tree = tree
        self._nodes: tuple[Any, ...] = ()
        self._boards: dict[str, Board] = {}
        self._seen: dict[tuple[str, str], tuple[BoardEntry, int]] = {}
        self._texts: dict[tuple[str, str], str] = {}

    def take(self) -> Iterator[tuple[str, str, str]]:
        """Path of the subtree (empty for the root), key and new value of each changed key; an empty value if unset."""
        for path, board in self.boards().items():
            for key, entry in board.entries():
                known = self._seen.get((path, key))
                written = known is None or known[0] is not entry or known[1] != entry.sequence
                if not written and type(entry.value) not in _MUTABLE:
                    continue
                self._seen[path, key] = entry, entry.sequence
                yield from self._changed(path, key, "" if entry.value is None else short_text(entry.value))
        for path, key in [at for at, (entry, _) in self._seen.items() if not entry.alive]:
            del self._seen[path, key]
            yield from self._changed(path, key, "")

    def _changed(self, path: str, key: str, text: str) -> Iterator[tuple[str, str, str]]:
        if self._texts.get((path, key), "") != text:
            self._texts[path, key] = text
            yield path, key, text

    def boards(self) -> Mapping[str, Board]:
        """Blackboards of the tree by the paths of their subtrees; that of the root has an empty path."""
        if self._nodes is self._tree.nodes:
            return self._boards
        self._nodes = self._tree.nodes
        paths, twins = self._tree.paths(), Counter[str]()
        self._boards = {"": self._tree.board}
        for node in self._tree.subtrees():
            path = paths[node.id]
            twins[path] += 1
            name = f"{path}#{twins[path]}" if twins[path] > 1 else path
            self._boards[name] = self._tree.boards[node.children[0]]
        return self._boards


def short_text(value: Any) -> str:
    """Text of a value as in a document, at most `MAX_TEXT` characters long."""
    simple = isinstance(value, (str, bool, int, float))
    text = value_text(value) if simple else _SHORT.repr(value)
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}\u2026"
