"""Tree: a root that is bound to a board and a clock, and ticked."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import repeat
from traceback import walk_tb
from typing import Any

from py_trees.behaviour import Behaviour

from ...clock import Clock
from ...errors import Fault
from ..board import Board, Enums
from ..error import TreeError
from ..status import RUNNING, Outcome
from .family import halt
from .node import Node, is_own_node
from .runtime import Runtime, Watch
from .subtree import SubTree
from .swap import find_node, keys_restored, replace_node, swapped_part

MAX_SETTLING = 10_000
"""How often a tree may be ticked until it settles; more is a tree that never does."""

_FRAMES = 8
"""Python frames that one level of a tree takes at most when it is ticked."""


class Tree:
    """A tree of behaviours, ours and py_trees' own in any mixture.

    Args:
        root: Its root.
        board: The root's board; a new one by default.
        clock: Time, for nodes that wait.
        owner: Whoever the tree works for, such as a mission; see `Runtime.owner`.
        enums: Names of numbers for scripts and ports.
        faults: Takes what is wrong, for a tree that is only looked at; it is raised by default.

    Raises:
        TreeError: A key is used with two types, or a number's name is unknown; all such faults.

    Attributes:
        root: Its root.
        board: The root's board.
        nodes: All nodes, parents before children; a node's number in it, counted from 1, is its uid.
        boards: The board of each node.
    """

    def __init__(
        self,
        root: Behaviour,
        *,
        board: Board | None = None,
        clock: Clock | None = None,
        owner: object = None,
        enums: Enums | None = None,
        faults: list[Fault] | None = None,
    ) -> None:
        self.root = root
        self.board = board or Board()
        if enums is not None:
            self.board.enums = enums
        self.runtime = Runtime(clock, owner)
        self._watchers: list[Watch] = []
        self._after: list[Callable[[], None]] = []
        self._faults = faults
        self.bind()

    def bind(self) -> None:
        """Give each node its place; again after the tree was edited. Boards of subtrees that stay are kept."""
        nodes, boards = self._bind_below(self.root, self.board)
        self.nodes: tuple[Behaviour, ...] = tuple(nodes)
        self.boards: dict[Behaviour, Board] = dict(zip(nodes, boards, strict=True))

    def swap(self, old: Behaviour, new: Behaviour) -> None:
        """Put another subtree in the place of one, between two ticks. What runs of the old one is halted, once.

        The boards keep what they know, and all other nodes go on as if nothing had happened. Of a SubTree the tree in
        it is exchanged: its remappings and its board stay.

        Args:
            old: A node of this tree.
            new: The root of a tree that nobody else has.

        Raises:
            TreeError: `new` has a place already, or uses a key with another type. The old one is still in force.
        """
        old = swapped_part(old)
        coming = list(descendants(new))
        if new.parent is not None or any(node in self.boards for node in coming):
            raise TreeError(Fault(f"'{new.name}' has a place in a tree already.", hint="Make a new tree to swap in."))
        board, leaving = self.boards[old], list(descendants(old))
        with keys_restored(board):
            nodes, boards = self._bind_below(new, board, _depth(old))
        for node in leaving:
            halt(node)
        replace_node(old, new)
        if old is self.root:
            self.root = new
        at = next(i for i, node in enumerate(self.nodes) if node is old)
        self.nodes = (*self.nodes[:at], *nodes, *self.nodes[at + len(leaving) :])
        for node in leaving:
            del self.boards[node]
        self.boards.update(zip(nodes, boards, strict=True))

    def find(self, name: str) -> Behaviour:
        """The node of a full path (see `paths`), or the only one of a name.

        Raises:
            TreeError: There is none, or there are several of that name.
        """
        return find_node(self.nodes, self.paths(), name)

    def _bind_below(self, root: Behaviour, board: Board, depth: int = 0) -> tuple[list[Behaviour], list[Board]]:
        """Bind a node that has so many above it and all below it; each with its board, parents before children."""
        nodes, boards, deepest = list[Behaviour](), list[Board](), 0
        stack = [iter([(root, board)])]
        while stack:
            for node, own in stack[-1]:
                nodes.append(node)
                boards.append(own)
                below = node.bind(own, self.runtime) if is_own_node(node) else zip(node.children, repeat(own))
                if below:
                    stack.append(iter(below))
                    break
            else:
                deepest = max(deepest, len(stack))
                stack.pop()
        _raise_recursion_limit(depth + deepest)
        self._report(
            [fault_at(n, f.message, f.hint, attribute=a, warning=f.warning) for n, a, f in self.runtime.faults]
        )
        return nodes, boards

    def _report(self, faults: list[Fault]) -> None:
        self.runtime.faults.clear()
        if self._faults is not None:
            self._faults += faults
        elif faults:
            raise TreeError(*faults)

    def tick(self) -> Outcome:
        """Tick exactly once: one traversal, however much is left to do.

        Returns:
            The root's outcome; SKIPPED where the root was skipped.

        Raises:
            TreeError: A node cannot go on; the message begins with its path. Other errors get it as a note.
        """
        self.runtime.woken = False
        root: Any = self.root
        try:
            outcome = root.tick_once() or root.status
        except TreeError as error:
            path = self._raised_in(error)
            raise TreeError(*(replace(f, message=f"{path}: {f.message}") for f in error.faults)) from error
        except Exception as error:  # whatever a leaf raised goes on, with its place in the tree
            error.add_note(f"in the node '{self._raised_in(error)}'")
            raise
        self.ticked()
        return outcome

    def ticked(self) -> None:
        """Tell watchers that a tick is over; for a root of py_trees' own that is ticked as a generator."""
        for after in self._after:
            after()

    def settle(self) -> Outcome:
        """Tick until nothing can be done without time passing.

        Nodes such as Repeat stop between two rounds so that others have their turn; this goes on with them at once.

        Raises:
            TreeError: A node cannot go on.
        """
        outcome = self.tick()
        for _ in range(MAX_SETTLING):
            if outcome is not RUNNING or not self.runtime.woken:
                break
            outcome = self.tick()
        return outcome

    def halt(self) -> None:
        """Halt what runs: each running node once, children before their parents."""
        for node in self.nodes:
            halt(node)

    def watch(self, watcher: Watch, after: Callable[[], None] = lambda: None) -> Callable[[], None]:
        """Have somebody hear the outcome of every tick of every node of ours, children before parents.

        Args:
            watcher: Called with the node and its outcome: RUNNING, SUCCESS, FAILURE, SKIPPED, or IDLE when it was
                halted. It must not tick or edit the tree.
            after: Called when a tick of the tree is over.

        Returns:
            What to call to have it hear no more.
        """
        self._watchers.append(watcher)
        self._after.append(after)
        self._connect_watchers()

        def leave() -> None:
            self._watchers.remove(watcher)
            self._after.remove(after)
            self._connect_watchers()

        return leave

    def uid(self, node: Behaviour) -> int:
        """A node's number, counted from 1 in the order of `nodes`, across subtrees."""
        return next(i for i, other in enumerate(self.nodes, 1) if other is node)

    def paths(self) -> Mapping[Any, str]:
        """The full path of each node by its `id`, as BehaviorTree.CPP builds it: names of subtrees, then the node's.

        A node without a name of its own is called `Tag::uid`.
        """
        found: dict[Any, str] = {}
        prefixes: dict[Any, str] = {self.root.id: ""}
        for uid, node in enumerate(self.nodes, 1):
            prefix = prefixes[node.id]
            tag = node.tree if isinstance(node, SubTree) else getattr(node, "tag", type(node).__name__)
            own = node.name if node.name != tag else f"{tag}::{uid}"
            found[node.id] = prefix + own
            inner = f"{prefix}{own}/" if isinstance(node, SubTree) else prefix
            prefixes.update({child.id: inner for child in node.children})
        return found

    def subtrees(self) -> Iterator[SubTree]:
        """All subtrees, outer ones first."""
        return (node for node in self.nodes if isinstance(node, SubTree))

    def _raised_in(self, error: Exception) -> str:
        """The path of the node that an error came from: the innermost one that was at work."""
        paths = self.paths()
        path = paths[self.root.id]
        for frame, _ in walk_tb(error.__traceback__):
            for name in ("self", "node"):
                node = frame.f_locals.get(name)
                if isinstance(node, Behaviour):
                    path = paths.get(node.id, path)
        return path

    def _connect_watchers(self) -> None:
        watchers = tuple(self._watchers)

        def all_of(node: Behaviour, outcome: Outcome) -> None:
            for watcher in watchers:
                watcher(node, outcome)

        self.runtime.watch = None if not watchers else watchers[0] if len(watchers) == 1 else all_of
        for node in self.nodes:
            if isinstance(node, Node):
                node.rewire()


def _depth(node: Behaviour) -> int:
    """How many nodes stand above a node."""
    count, parent = 0, node.parent
    while parent is not None:
        count, parent = count + 1, parent.parent
    return count


def _raise_recursion_limit(depth: int) -> None:
    """Let Python nest as deep as a tree does. The limit is the process's, so it is only ever raised."""
    wanted = 600 + depth * _FRAMES
    if wanted > sys.getrecursionlimit():
        sys.setrecursionlimit(wanted)


def descendants(root: Behaviour) -> Iterator[Behaviour]:
    """A node and all below it, parents before children, however deep."""
    todo = [root]
    while todo:
        node = todo.pop()
        yield node
        todo += reversed(node.children)


def fault_at(
    node: Behaviour,
    message: str,
    hint: str = "",
    *,
    attribute: str = "",
    column: int | None = None,
    warning: bool = True,
) -> Fault:
    """A fault of a node, at one of its attributes where it stands in a document.

    Args:
        node: The node.
        message: What is wrong; the node is named before it.
        hint: What to do.
        attribute: The attribute.
        column: Where in the attribute's value, counted from 0.
        warning: Whether the tree still runs.
    """
    text, origin = f"'{node.name}': {message}", getattr(node, "origin", None)
    if origin is not None:
        found: Fault = origin.fault(text, hint, attribute=attribute, column=column, warning=warning)
        return found
    return Fault(text, hint=hint, warning=warning)
