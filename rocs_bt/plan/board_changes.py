"""Changes of blackboard values, for recordings: only keys that changed, each as a short text."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from typing import Any

from ..trees.board import Board, Entry
from ..trees.nodes import Tree
from ..trees.xml.write import value_text

MAX_TEXT = 120
"""Maximum length of a recorded value [characters]; longer ones are cut."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = MAX_TEXT


class BoardChanges:
    """Finds the keys with values that changed since the last call, on the blackboards of a tree and its subtrees.

    Args:
        tree: The tree.
    """

    def __init__(self, tree: Tree) -> None:
        self._tree = tree
        self._nodes: tuple[Any, ...] = ()
        self._boards: dict[str, Board] = {}
        self._seen: dict[tuple[str, str], tuple[Entry, int]] = {}
        self._texts: dict[tuple[str, str], str] = {}

    def take(self) -> Iterator[tuple[str, str, str]]:
        """Path of the subtree (empty for the root), key and new value of each changed key; an empty value if unset."""
        if self._nodes is not self._tree.nodes:
            self._find_boards()
        for path, board in self._boards.items():
            for key, entry in board.entries():
                known = self._seen.get((path, key))
                if known is not None and known[0] is entry and known[1] == entry.sequence:
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

    def _find_boards(self) -> None:
        """Update the blackboards: that of the root, and those of the subtrees by their paths."""
        self._nodes = self._tree.nodes
        paths = self._tree.paths()
        self._boards = {"": self._tree.board}
        for node in self._tree.subtrees():
            self._boards.setdefault(paths[node.id], self._tree.boards[node.children[0]])


def short_text(value: Any) -> str:
    """Text of a value as in a document, at most `MAX_TEXT` characters long."""
    simple = isinstance(value, (str, bool, int, float))
    text = value_text(value) if simple else _SHORT.repr(value)
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 1]}\u2026"
