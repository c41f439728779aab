"""Tree: a root node with its descendants, bound to a blackboard and a clock, which can be ticked."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from itertools import repeat
from traceback import walk_tb
from typing import Any

from py_trees.behaviour import Behaviour

from ...base.clock import Clock
from ...base.errors import Fault
from ...base.nesting import descendants
from ..board import Board
from ..error import TreeError
from ..status import RUNNING, Outcome
from ..value import Enums
from .base_classes import halt
from .node import Node, is_own_node
from .runtime import Runtime, Watch
from .subtree import SubTree
from .swap import find_node, keys_restored, replace_node, swapped_part

MAX_SETTLING = 10_000
"""Maximum number of ticks in `Tree.settle`; a tree that needs more would most likely never settle."""

_FRAMES = 8
"""Maximum number of Python stack frames per level of a tree during a tick."""


class Tree:
    """Behaviour tree of nodes of this package and stock py_trees behaviours, in any mixture.

    Args:
        root: Root node.
        board: Blackboard of the root; a new one by default.
        clock: Time source for nodes that wait.
        owner: Object that the tree works for, such as a mission; see `Runtime.owner`.
        enums: Enum values by name, for scripts and ports.
        faults: List to which faults are added, in a check; by default they are raised.

    Raises:
        TreeError: Keys have conflicting types, or enum names are unknown; the error lists all of them.

    Attributes:
        nodes: All nodes, parents before children; a node's uid is its position here, counted from 1.
        boards: Blackboard of each node.
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
        _write_initial_keys(root, self.board)
        self.bind()
        self._faults = None  # of a subtree that is swapped in later they are raised

    def bind(self) -> None:
        """Bind all nodes to their blackboards. Call this again after editing the tree; subtrees keep theirs."""
        nodes, boards = self._bind_below(self.root, self.board)
        self.nodes: tuple[Behaviour, ...] = tuple(nodes)
        self.boards: dict[Behaviour, Board] = dict(zip(nodes, boards, strict=True))

    def swap(self, old: Behaviour, new: Behaviour) -> None:
        """Replace a subtree by another one between two ticks. RUNNING nodes of the old subtree are halted.

        The blackboards keep their values, and all other nodes continue undisturbed. If `old` is a SubTree, the tree
        inside it is replaced; the remappings and the blackboard of the SubTree remain.

        Args:
            old: Root of the subtree to replace, a node of this tree.
            new: Root of the new subtree, which must not be part of a tree.

        Raises:
            TreeError: `new` belongs to a tree already, or uses a key with another type. The old subtree remains in use.
        """
        old = swapped_part(old)
        coming = list(descendants(new))
        if new.parent is not None or any(node in self.boards for node in coming):
            raise TreeError(Fault(f"'{new.name}' belongs to a tree already.", hint="Create a new tree to swap in."))
        board, leaving = self.boards[old], tuple(descendants(old))
        with keys_restored(board):
            _write_initial_keys(new, board)
            nodes, boards = self._bind_below(new, board, _depth(old))
        with ExitStack() as halts:  # all are halted, and the subtree is replaced, even if one of them raises
            halts.callback(self._replace, old, new, nodes, boards)
            for node in reversed(leaving):
                halts.callback(halt, node)

    def _replace(self, old: Behaviour, new: Behaviour, nodes: list[Behaviour], boards: list[Board]) -> None:
        """Put the bound nodes of a new subtree in place of an old one."""
        leaving = list(descendants(old))
        replace_node(old, new)
        if old is self.root:
            self.root = new
        at = next(i for i, node in enumerate(self.nodes) if node is old)
        self.nodes = (*self.nodes[:at], *nodes, *self.nodes[at + len(leaving) :])
        for node in leaving:
            del self.boards[node]
        self.boards.update(zip(nodes, boards, strict=True))

    def find(self, name: str) -> Behaviour:
        """Find a node by its full path (see `paths`), or by its name if only one node has this name.

        Raises:
            TreeError: No node, or more than one, matches.
        """
        return find_node(self.nodes, self.paths(), name)

    def _bind_below(self, root: Behaviour, board: Board, depth: int = 0) -> tuple[list[Behaviour], list[Board]]:
        """Bind a node and its descendants; returns them, parents first, and the blackboard of each."""
        nodes, boards, deepest = list[Behaviour](), list[Board](), 0
        stack = [iter([(root, board)])]
        with _no_collections():
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
        """Tick the tree once, even if `settle` would tick it again.

        Returns:
            Outcome of the root; SKIPPED if the root was skipped.

        Raises:
            TreeError: A node cannot continue; the message begins with its path. Other errors get the path as a note.
        """
        self.runtime.tick_again = False
        root: Any = self.root
        try:
            outcome = root.tick_once() or root.status
        except TreeError as error:
            path = self._raised_in(error)
            raise TreeError(*(replace(f, message=f"{path}: {f.message}") for f in error.faults)) from error
        except Exception as error:  # a leaf may raise anything; add its path and raise it again
            error.add_note(f"in the node '{self._raised_in(error)}'")
            raise
        self.ticked()
        return outcome

    def ticked(self) -> None:
        """Notify the watchers that a tick has ended. Call it if the root is ticked as a py_trees generator."""
        for after in self._after:
            after()

    def settle(self) -> Outcome:
        """Tick the tree until no node can continue before time passes.

        Nodes such as Repeat return RUNNING between two rounds so that other nodes can run; this method ticks again at
        once.

        Raises:
            TreeError: A node cannot continue.
        """
        outcome = self.tick()
        for _ in range(MAX_SETTLING):
            if outcome is not RUNNING or not self.runtime.tick_again:
                break
            outcome = self.tick()
        return outcome

    def halt(self) -> None:
        """Halt all running nodes, each once, children before their parents."""
        for node in self.nodes:
            halt(node)

    def watch(self, watcher: Watch, after: Callable[[], None] = lambda: None) -> Callable[[], None]:
        """Register an observer of the ticks of all nodes of this package, children before parents.

        Args:
            watcher: Callback with the node and its outcome: RUNNING, SUCCESS, FAILURE, SKIPPED, or IDLE if it was
                halted. It must not tick or edit the tree.
            after: Callback at the end of each tick of the tree.

        Returns:
            Function that unregisters the observer.
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
        """Number of a node, counted from 1 in the order of `nodes`, across subtrees."""
        return next(i for i, other in enumerate(self.nodes, 1) if other is node)

    def paths(self) -> Mapping[Any, str]:
        """Full path of each node by `id`, as in BehaviorTree.CPP: names of the enclosing subtrees, then the node's.

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
        """All SubTree nodes, outer ones first."""
        return (node for node in self.nodes if isinstance(node, SubTree))

    def _raised_in(self, error: Exception) -> str:
        """Path of the node that raised an exception, found in the traceback; the path of the root if none is found."""
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


@contextmanager
def _no_collections() -> Iterator[None]:
    """Context manager that pauses the garbage collector.

    Binding creates many small functions, all of which remain in use. The collector would visit them again and again,
    which takes three times as long as the rest for 10,000 scripts.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _write_initial_keys(root: Behaviour, board: Board) -> None:
    for key, value in root.initial_keys.items() if isinstance(root, Node) else ():
        if key not in board:
            board.set_local(key, value)


def _depth(node: Behaviour) -> int:
    """Number of ancestors of a node."""
    count, parent = 0, node.parent
    while parent is not None:
        count, parent = count + 1, parent.parent
    return count


def _raise_recursion_limit(depth: int) -> None:
    """Raise Python's recursion limit for a tree of this depth. It is never lowered, because other code may need it."""
    wanted = 600 + depth * _FRAMES
    if wanted > sys.getrecursionlimit():
        sys.setrecursionlimit(wanted)


def fault_at(
    node: Behaviour,
    message: str,
    hint: str = "",
    *,
    attribute: str = "",
    column: int | None = None,
    warning: bool = True,
) -> Fault:
    """Create a fault of a node, located at one of the node's attributes in its document.

    `column` is the position in the attribute's value, counted from 0.
    """
    text, origin = f"'{node.name}': {message}", getattr(node, "origin", None)
    if origin is not None:
        found: Fault = origin.fault(text, hint, attribute=attribute, column=column, warning=warning)
        return found
    return Fault(text, hint=hint, warning=warning)
