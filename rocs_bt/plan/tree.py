"""TreePlan: a planner that ticks a behaviour tree."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.display import unicode_tree
from py_trees.logging import Logger

from ..errors import Fault, InputError, interrupts
from ..event import NodeTicked, SubtreeSwapped
from ..raised import Raised, from_actuator
from ..trees.error import TreeError
from ..trees.examine import node_faults
from ..trees.nodes import Node, Tree, descendants, halt
from ..trees.nodes.runtime import Caught
from ..trees.nodes.swap import find_node, swapped_part
from ..trees.status import RUNNING, SKIPPED, Outcome
from .mission import Mission
from .plan import FAILURE, SUCCESS, Plan


def shape_faults(root: object) -> list[Fault]:
    """Why what `build` returned cannot be ticked; empty when it can."""
    if not isinstance(root, Behaviour):
        hint = "Return the root of a py_trees tree, or a Plan."
        return [Fault(f"build returned {root!r}, which is no py_trees behaviour.", hint=hint)]
    return [
        Fault(f"'{node.name}' has no children.", hint="Give it some, or leave it out.")
        for node in descendants(root)
        if isinstance(node, Composite) and not node.children
    ]


_BETWEEN = "Swap between two ticks: from another thread, or where the tree is ticked."


class _Quiet(Logger):
    """A logger of py_trees that keeps to itself: what a node has to say is its `feedback_message`."""

    def debug(self, msg: str) -> None:
        pass

    info = warning = error = debug


QUIET = _Quiet()


@dataclass(frozen=True)
class NodeOutline:
    """One node of a tree, for displays and recordings.

    Attributes:
        path: Names from the root joined by `/`; a second sibling of the same name ends in `#2`.
        name: Its name.
        kind: Its class, such as `Sequence`.
        depth: 0 for the root.
    """

    path: str
    name: str
    kind: str
    depth: int


class TreePlan(Plan):
    """The shipped planner: a tree, ticked once a turn until its root succeeds or fails.

    The tree's nodes are ours, py_trees' own, or both. Their loggers are silenced, since only the command line prints.

    Args:
        root: The tree.
        mission: The context that its leaves were made with.

    Raises:
        InputError: It is no tree, has a composite without children, uses a key with two types, or a node refuses.

    Attributes:
        root: The tree's root.
        tree: The tree, bound to its board, which `tree.board` is.
        outline: All its nodes, parents before children.
        ticks: How often it was ticked.
    """

    def __init__(self, root: Behaviour, mission: Mission) -> None:
        if faults := shape_faults(root):
            raise InputError(*faults)
        super().__init__(mission.name, **mission.parts)
        self.root = root
        self.tree = Tree(root, board=mission.board, clock=mission.clock, owner=mission)
        _refuse_faults(self.tree)
        self.ticks = 0
        self._mission = mission
        self._turn, self._ticking = threading.RLock(), False
        mission.swap = self.swap
        self._raised: list[Raised] = []
        self._restarts: list[Behaviour] = []
        self.tree.runtime.caught = self._caught
        self._seen: dict[Any, Status] = {}
        self._look()
        for node, _ in self._nodes:
            node.logger = QUIET
            node.setup()

    def run(self, t: float) -> None:
        self.changes()  # what changed stands in Knowledge; here it only calls for a tick
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
            self._tell()
            if self._raised:
                self._report()
        self.ticks += 1
        if outcome is Status.SUCCESS:
            self.status = SUCCESS
        elif outcome is not RUNNING:
            self.status, self.reason = FAILURE, self._why(outcome)

    def swap(self, name: str, new: Behaviour) -> None:
        """Put another subtree in the place of a named one while the mission runs. Any thread may.

        It happens between two ticks: what runs of the old one is halted, once, so that its leaves cancel their
        actions; the board and all other nodes keep what they have. Of a SubTree the tree in it is exchanged.

        Args:
            name: A node's path as in `outline`, or its name where no other node has it.
            new: The root of a tree that nobody else has.

        Raises:
            InputError: There is no such node, or the new tree cannot take its place; the old one is still in force.
        """
        with self._turn:
            if self._ticking:
                raise TreeError(Fault(f"'{name}' was to be swapped from within a tick of its tree.", hint=_BETWEEN))
            if self.status != "RUNNING":
                raise TreeError(Fault(f"'{name}' was to be swapped, but the mission has ended ({self.status})."))
            old = swapped_part(find_node(self.tree.nodes, self._paths, name))
            if faults := shape_faults(new):
                raise InputError(*faults)
            if new.parent is None and new.id not in self._paths:
                _refuse_faults(Tree(new, clock=self._mission.clock, owner=self._mission))  # on a board of its own
            leaving, gone = self._paths[old.id], tuple(descendants(old))
            for node in descendants(new):
                node.logger = QUIET
                node.setup()
            self.tree.swap(old, new)
            self._tell()
            self.root = self.tree.root
            self._look()
            self._mission.note(SubtreeSwapped, node=leaving, by=self._paths[new.id], nodes=self._told_nodes())
            for node in gone:
                node.shutdown()
        self.replan("a swapped subtree")

    def close(self) -> None:
        """Halt what runs, so that leaves let go, and shut the nodes down, each of them whatever another one raises."""
        with ExitStack() as ends:  # last in, first out
            for node, _ in reversed(self._nodes):
                ends.callback(node.shutdown)
            ends.callback(self._tell)
            # A tick that raised may leave a root behind that does not run over leaves that do.
            for node, _ in self._nodes:
                halt(node)

    def display(self) -> str:
        """The tree with its present statuses, as text."""
        text: str = unicode_tree(self.root, show_status=True)
        return text

    def content_of(self, owner: object) -> tuple[str, str] | None:
        if isinstance(owner, Behaviour) and (path := self._paths.get(owner.id)) is not None:
            return "node" if owner.children else "leaf", path
        return super().content_of(owner)

    def definitions_of(self, owner: object) -> tuple[object, ...]:
        return owner, getattr(getattr(owner, "origin", None), "location", None)

    def _tick(self) -> Outcome:
        if isinstance(self.root, Node):
            return self.tree.tick()
        for node in self.root.tick():
            # Our nodes complain themselves, and one of them that was skipped is idle by right.
            if node.status is Status.INVALID and not isinstance(node, Node):
                raise InputError(self._no_status(node))
        self.tree.ticked()
        return self.root.status

    def _caught(self, leaf: Behaviour, error: BaseException) -> bool:
        """Have a leaf that raised count as RUNNING in this tick; False where nothing takes its exception."""
        if self.on_exception is None or from_actuator(error):
            return False
        if leaf.status is not Status.RUNNING:
            self._restarts.append(leaf)
            leaf.status = Status.RUNNING
        raised = self.blame(error) or Raised.of("leaf", self._mission.path(leaf), error, *self.definitions_of(leaf))
        leaf.feedback_message = f"it raised {raised.detail}"
        self._raised.append(raised)
        return True

    def _restart(self) -> None:
        """Leaves that raised in their first tick begin again."""
        for leaf in self._restarts:
            if leaf.status is Status.RUNNING:
                leaf.status = Status.INVALID
        self._restarts.clear()

    def _report(self) -> None:
        raised, self._raised = self._raised, []
        for each in raised:
            if self.on_exception is not None:
                self.on_exception(each)

    def _look(self) -> None:
        """Take in which nodes there are, and where."""
        self._nodes: list[tuple[Behaviour, str]] = []
        self.outline = tuple(self._walk(self.root))
        self._paths: dict[Any, str] = {node.id: path for node, path in self._nodes}
        self._seen = {node.id: self._seen.get(node.id, Status.INVALID) for node, _ in self._nodes}

    def _told_nodes(self) -> tuple[tuple[str, str, str], ...]:
        paths = self._paths
        return tuple((path, type(n).__name__, paths[n.parent.id] if n.parent else "") for n, path in self._nodes)

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

    def _tell(self) -> None:
        """Emit what changed its status, children before their parents."""
        for node, path in reversed(self._nodes):
            if node.status is not self._seen[node.id]:
                self._seen[node.id] = node.status
                self._mission.note(NodeTicked, node=path, status=node.status.name, feedback=node.feedback_message)

    def _no_status(self, node: Behaviour) -> Fault:
        path, kind = self._paths.get(node.id, node.name), type(node).__name__
        return Fault(
            f"update of '{path}' ({kind}) gave no status back.", hint="Return Status.RUNNING, SUCCESS or FAILURE."
        )

    def _why(self, outcome: Outcome) -> str:
        if outcome is SKIPPED:
            return f"{self.root.name}: its conditions skip the whole mission"
        tip = self.root.tip() or self.root
        return f"{self._paths.get(tip.id, tip.name)}: {tip.feedback_message or tip.status.name}"


def guard_leaf(leaf: Behaviour, caught: Caught) -> None:
    """Have a leaf of py_trees' own kind count as RUNNING when it raises; leaves of ours do so by themselves."""
    if "tick" in vars(leaf):
        return
    plain = leaf.tick

    def tick() -> Iterator[Behaviour]:
        try:
            yield from plain()
        except BaseException as error:  # a leaf may raise anything
            if interrupts(error):
                raise
            if not caught(leaf, error):
                raise
            yield leaf

    vars(leaf)["tick"] = tick


def _refuse_faults(tree: Tree) -> None:
    if wrong := [fault for fault in node_faults(tree) if not fault.warning]:
        raise InputError(*wrong)
