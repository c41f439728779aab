"""TreePlan: planner that ticks a behaviour tree."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.display import unicode_tree
from py_trees.logging import Logger

from ..base.errors import Fault, InputError, interrupts
from ..base.nesting import descendants
from ..base.raised import Raised, from_actuator
from ..event import BlackboardChanged, NodeTicked, SubtreeSwapped, TreeNode
from ..trees.board import Board
from ..trees.draw import port_keys, ports_text
from ..trees.error import TreeError
from ..trees.examine import node_faults
from ..trees.nodes import Node, Tree, halt
from ..trees.nodes.runtime import Caught
from ..trees.nodes.swap import find_node, keys_restored, swapped_part
from ..trees.status import RUNNING, SKIPPED, Outcome
from .act import Act
from .board_changes import BoardChanges
from .mission import Mission
from .plan import FAILURE, SUCCESS, Plan
from .replacement import place_faults, replacement
from .waits import ancestors, front, wait_text


def shape_faults(root: object) -> list[Fault]:
    """Faults of the result of `build` that prevent ticking it: it is no tree, or a composite has no children."""
    if not isinstance(root, Behaviour):
        hint = "Return the root of a py_trees tree, or a Plan."
        return [Fault(f"build returned {root!r}, which is not a py_trees behaviour.", hint=hint)]
    return [
        Fault(f"'{node.name}' has no children.", hint="Add children, or remove it.")
        for node in descendants(root)
        if isinstance(node, Composite) and not node.children
    ]


_BETWEEN = "Swap between two ticks: from another thread, or where the tree is ticked."


class _Quiet(Logger):
    """Logger for py_trees nodes that discards all messages; nodes report in `feedback_message` instead."""

    def debug(self, msg: str) -> None:
        pass

    info = warning = error = debug


QUIET = _Quiet()


@dataclass(frozen=True)
class NodeOutline:
    """Description of a node of a tree, for displays and recordings.

    Attributes:
        path: Names from the root to the node, joined by `/`; of siblings with the same name, the second ends in `#2`.
        name: Name of the node.
        kind: Class of the node, such as `Sequence`.
        depth: Depth in the tree, 0 for the root.
    """

    path: str
    name: str
    kind: str
    depth: int


class TreePlan(Plan):
    """Planner that ticks a tree once per turn until its root succeeds or fails.

    The tree may contain nodes of this package and stock py_trees nodes. The loggers of all nodes are silenced, because
    only the command line prints.

    Args:
        root: Root of the tree.
        mission: Mission with which the leaves of the tree were created.
        tree: Tree with this root that was checked already; by default it is made and checked.

    Raises:
        InputError: `root` is no tree, a composite has no children, a key has two types, or a node reports an error.

    Attributes:
        tree: Tree with its blackboard.
        outline: Descriptions of all nodes, parents before children.
        ticks: Number of ticks.
    """

    def __init__(self, root: Behaviour, mission: Mission, tree: Tree | None = None) -> None:
        if tree is None and (faults := shape_faults(root)):
            raise InputError(*faults)
        super().__init__(mission.name, **mission.parts)
        self.root = root
        self.tree = tree or Tree(root, board=mission.board, clock=mission.clock, owner=mission)
        if tree is None:
            _refuse_faults(self.tree)
        self.ticks = 0
        self._mission = mission
        self._board_changes = BoardChanges(self.tree)
        # Held during a turn and a swap. Re-entrant, so that a leaf that swaps during its own tick is refused and does
        # not wait for itself.
        self._turn, self._ticking = threading.RLock(), False
        mission.swap = self.swap
        self._raised: list[Raised] = []
        self._restarts: list[Behaviour] = []
        self.tree.runtime.caught = self._caught
        self._seen: dict[Any, Status] = {}
        self._since: dict[Any, float] = {}  # [s] times from which the tree waits in the nodes of its front
        self._texts: dict[Any, str] = {}  # what they wait for
        self._told = ""  # the last leaf that failed with a message, and the message
        self._index_nodes()
        for node, _ in self._nodes:
            node.logger = QUIET
            node.setup()

    def run(self, t: float) -> None:
        self.changes()  # Knowledge already contains the changes; they only trigger this turn
        if self.status == "RUNNING":
            with self._turn:
                self._run(t)

    def _run(self, t: float) -> None:
        self._mission.begin(t, self._paths)
        if self._restarts:
            self._restart()
        self._ticking = True
        try:
            outcome = self._tick()
        finally:
            self._ticking = False
            self._emit_changes()
            if self._raised:
                self._report()
        self.ticks += 1
        if outcome is Status.SUCCESS:
            self.status = SUCCESS
        elif outcome is not RUNNING:
            self.status, self.reason = FAILURE, self._failure_reason(outcome)

    def find(self, name: str) -> Behaviour:
        """Find a node by its path as in `outline`, or by its name if only one node has this name.

        Raises:
            TreeError: No node, or more than one, matches.
        """
        return find_node(self.tree.nodes, self._paths, name)

    def load(self, source: Path | str, tree: str = "") -> Node:
        """Create a tree from an XML mission, by which `swap` can replace a subtree; see `replacement`."""
        return replacement(self._mission, source, tree)

    def place_faults(self, name: str, source: Path | str, tree: str = "") -> list[Fault]:
        """Faults of the ports of a tree from `load` in place of the node of this name; see `place_faults`."""
        return place_faults(self.tree, self.find(name), self._mission, source, tree)

    def swap(self, name: str, new: Behaviour) -> None:
        """Replace a subtree, given by its name, while the mission runs. Thread-safe.

        The swap happens between two ticks. RUNNING nodes of the old subtree are halted, so that its leaves cancel their
        actions. The blackboard and all other nodes keep their state. If the name is that of a SubTree, the tree inside
        it is replaced.

        Args:
            name: Path of the subtree's root as in `outline`, or its name if unique.
            new: Root of the new subtree, which must not be part of a tree.

        Raises:
            InputError: There is no such node, or the new subtree is not valid there; the old subtree remains in use.
        """
        with self._turn:
            if self._ticking:
                raise TreeError(Fault(f"cannot swap '{name}' during a tick of its tree.", hint=_BETWEEN))
            if self.status != "RUNNING":
                raise TreeError(Fault(f"cannot swap '{name}': the mission has ended ({self.status})."))
            old = swapped_part(self.find(name))
            if faults := shape_faults(new):
                raise InputError(*faults)
            if new.parent is None and new.id not in self._paths:
                board = self.tree.boards[old]
                with keys_restored(board):  # a blackboard of its own that shows the keys of its place
                    inner = Board(board, autoremap=True)
                    _refuse_faults(Tree(new, board=inner, clock=self._mission.clock, owner=self._mission))
            for node in descendants(new):
                node.logger = QUIET
                node.setup()
            leaving, old_nodes = self._paths[old.id], tuple(descendants(old))
            try:
                self.tree.swap(old, new)
            finally:  # also if a node of the old subtree raised when it was halted
                if old not in self.tree.boards:
                    self._swapped(leaving, new)
                    for node in old_nodes:
                        node.shutdown()

    def _swapped(self, leaving: str, new: Behaviour) -> None:
        """Describe the tree after the subtree with the path `leaving` was replaced."""
        self._emit_changes()
        self.root = self.tree.root
        self._index_nodes()
        self._mission.note(SubtreeSwapped, node=leaving, by=self._paths[new.id], nodes=self.tree_nodes())
        self.replan("a swapped subtree")

    def tree_nodes(self) -> tuple[TreeNode, ...]:
        """Nodes for recordings, in the order of `outline`, with their ports and the blackboard entries of these."""
        boards = {id(board): path for path, board in self._board_changes.boards().items()}

        def described(node: Behaviour, path: str) -> TreeNode:
            entries = {port: board.resolve(key) for port, key, board in port_keys(node)}
            return TreeNode(
                path=path,
                type=type(node).__name__,
                children=tuple(self._paths[child.id] for child in node.children),
                ports=ports_text(node),
                board=boards[id(self.tree.boards[node])],
                keys={port: f"{boards[id(board)]}\n{key}" for port, (board, key) in entries.items()},
            )

        return tuple(described(node, path) for node, path in self._nodes)

    def close(self) -> None:
        """Halt RUNNING nodes and shut all nodes down, even if one of them raises an exception."""
        with ExitStack() as ends:  # callbacks run in reverse order
            for node, _ in reversed(self._nodes):
                ends.callback(node.shutdown)
            ends.callback(self._emit_changes)
            # After a tick that raised, leaves may be RUNNING although the root is not.
            for node, _ in self._nodes:
                halt(node)

    def display(self) -> str:
        """Text drawing of the tree with the current statuses."""
        text: str = unicode_tree(self.root, show_status=True)
        return text

    def content_of(self, owner: object) -> tuple[str, str] | None:
        if isinstance(owner, Behaviour) and (path := self._paths.get(owner.id)) is not None:
            return "node" if owner.children else "leaf", path
        return super().content_of(owner)

    def definitions_of(self, owner: object) -> tuple[object, ...]:
        return owner, getattr(getattr(owner, "origin", None), "location", None)

    @property
    def running(self) -> str:
        return "; ".join(
            self._running_text(leaf) for leaf, waits in front(self.root) if waits and leaf.id in self._since
        )

    def _running_text(self, leaf: Behaviour) -> str:
        """Where the mission waits, for how long, and what for; deadlines of decorators included."""
        took = f"{self.clock.now() - self._since[leaf.id]:.1f} s"
        action = leaf.ticket.action if isinstance(leaf, Act) and leaf.ticket is not None else None
        what = f"'{self._paths[leaf.id]}'"
        if action is not None:
            about = next((value for n in ("goal", "leader") if (value := action.parameters.get(n))), None)
            what = what if about is None else f"{action.name}({about})"
            waits = action.awaits()
            return f"{what} has run for {took}" + (f", and waits {waits}" if waits else "")
        texts = [text for node in (leaf, *ancestors(leaf)) if (text := self._texts.get(node.id))]
        return f"{what} has waited for {took}" + (f": {'; '.join(texts)}" if texts else "")

    def _tick(self) -> Outcome:
        if isinstance(self.root, Node):
            return self.tree.tick()
        for node in self.root.tick():
            # Nodes of this package check their outcomes themselves, and INVALID is correct for a skipped one.
            if node.status is Status.INVALID and not isinstance(node, Node):
                raise InputError(self._no_status(node))
        self.tree.ticked()
        return self.root.status

    def _caught(self, leaf: Behaviour, error: BaseException) -> bool:
        """Handle the exception of a leaf, which counts as RUNNING in this tick; returns False to raise it."""
        if self.on_exception is None or from_actuator(error):
            return False
        if leaf.status is not Status.RUNNING:
            self._restarts.append(leaf)
            leaf.status = Status.RUNNING
        raised = self.blame(error) or Raised.of("leaf", self._mission.path(leaf), error, *self.definitions_of(leaf))
        leaf.feedback_message = f"raised {raised.detail}"
        self._raised.append(raised)
        return True

    def _restart(self) -> None:
        """Reset leaves that raised an exception in their first tick, so that they are initialised again."""
        for leaf in self._restarts:
            if leaf.status is Status.RUNNING:
                leaf.status = Status.INVALID
        self._restarts.clear()

    def _report(self) -> None:
        raised, self._raised = self._raised, []
        for each in raised:
            if self.on_exception is not None:
                self.on_exception(each)

    def _index_nodes(self) -> None:
        """Update the list of nodes and the path of each node."""
        self._nodes: list[tuple[Behaviour, str]] = []
        self.outline = tuple(self._walk(self.root))
        self._paths: dict[Any, str] = {node.id: path for node, path in self._nodes}
        self._seen = {node.id: self._seen.get(node.id, Status.INVALID) for node, _ in self._nodes}

    def _walk(self, root: Behaviour) -> list[NodeOutline]:
        found, todo = [], [(root, root.name, 0)]
        while todo:
            node, path, depth = todo.pop()
            self._nodes.append((node, path))
            if not (node.children or isinstance(node, Node)):
                guard_leaf(node, self._caught)
            found.append(NodeOutline(path, node.name, type(node).__name__, depth))
            twins: Counter[str] = Counter()
            below = []
            for child in node.children:
                twins[child.name] += 1
                suffix = f"#{twins[child.name]}" if twins[child.name] > 1 else ""
                below.append((child, f"{path}/{child.name}{suffix}", depth + 1))
            todo += reversed(below)
        return found

    def _emit_changes(self) -> None:
        """Emit an event for each node with a changed status, or in which the tree waits for something else than before.

        Children come before parents.
        """
        texts = {node.id: wait_text(node) for node, _ in front(self.root)}
        now, since, first = self.clock.now(), self._since, ""
        self._since = {}
        for node, path in reversed(self._nodes):
            changed, text = node.status is not self._seen[node.id], texts.get(node.id)
            if text is not None:
                self._since[node.id] = now if changed and node.status is RUNNING else since.get(node.id, now)
            if changed or (text is not None and text != self._texts.get(node.id)):
                self._seen[node.id] = node.status
                feedback = text or node.feedback_message
                self._mission.note(NodeTicked, node=path, status=node.status.name, feedback=feedback)
                if node.status is Status.FAILURE and feedback and not node.children:
                    first = first or f"{path}: {feedback}"
        self._texts, self._told = texts, first or self._told
        for subtree, key, value in self._board_changes.take():
            self._mission.note(BlackboardChanged, key=key, value=value, subtree=subtree)

    def _no_status(self, node: Behaviour) -> Fault:
        path, kind = self._paths.get(node.id, node.name), type(node).__name__
        return Fault(
            f"update of '{path}' ({kind}) returned no status.", hint="Return Status.RUNNING, SUCCESS or FAILURE."
        )

    def _failure_reason(self, outcome: Outcome) -> str:
        if outcome is SKIPPED:
            return f"{self.root.name}: the conditions of the root skip the whole mission"
        tip = self.root.tip() or self.root
        reason = f"{self._paths.get(tip.id, tip.name)}: {tip.feedback_message or tip.status.name}"
        # A leaf such as AlwaysFailure says nothing about the cause: a leaf before it often does.
        silent = self._told and not tip.feedback_message
        return f"{reason}; the last failure with a reason: {self._told}" if silent else reason


def guard_leaf(leaf: Behaviour, caught: Caught) -> None:
    """Make a stock py_trees leaf count as RUNNING if it raises; leaves of this package handle exceptions themselves.

    `caught` returns False to raise the exception.
    """
    if "tick" in vars(leaf):
        return
    plain = leaf.tick

    def tick() -> Iterator[Behaviour]:
        try:
            yield from plain()
        except BaseException as error:  # user code may raise anything
            if interrupts(error):
                raise
            if not caught(leaf, error):
                raise
            yield leaf

    vars(leaf)["tick"] = tick


def _refuse_faults(tree: Tree) -> None:
    if wrong := dict.fromkeys(fault for fault in node_faults(tree) if not fault.warning):
        raise InputError(*wrong)
