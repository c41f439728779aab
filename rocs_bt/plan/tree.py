"""TreePlan: a planner that ticks a behaviour tree."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.display import unicode_tree
from py_trees.logging import Logger

from ..errors import Fault, InputError
from ..event import NodeTicked
from .mission import Mission
from .plan import FAILURE, SUCCESS, Plan
from .shape import shape_faults


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
    """The shipped planner: a py_trees tree, ticked once a turn until its root succeeds or fails.

    Its nodes' loggers are silenced, since only the command line prints.

    Args:
        root: The tree.
        mission: The context that its leaves were made with.

    Raises:
        InputError: It is no tree, or has a composite without children.

    Attributes:
        root: The tree.
        outline: All its nodes, parents before children.
        ticks: How often it was ticked.
    """

    def __init__(self, root: Behaviour, mission: Mission) -> None:
        if faults := shape_faults(root):
            raise InputError(*faults)
        super().__init__(
            mission.name,
            knowledge=mission.knowledge,
            pipeline=mission.pipeline,
            actions=mission.actions,
            clock=mission.clock,
            sink=mission.sink,
        )
        self.root = root
        self.ticks = 0
        self._mission = mission
        self._nodes: list[tuple[Behaviour, str]] = []
        self.outline = tuple(self._walk(root, root.name, 0))
        self._paths: dict[Any, str] = {node.id: path for node, path in self._nodes}
        self._seen: list[Status] = [Status.INVALID] * len(self._nodes)
        for node, _ in self._nodes:
            node.logger = QUIET
            node.setup()

    def run(self, t: float) -> None:
        self.changes()  # what changed stands in Knowledge; here it only calls for a tick
        if self.status != "RUNNING":
            return
        self._mission.begin(t, self._paths)
        for node in self.root.tick():
            if node.status is Status.INVALID:
                raise InputError(self._no_status(node))
        self.ticks += 1
        self._tell()
        if self.root.status is Status.SUCCESS:
            self.status = SUCCESS
        elif self.root.status is not Status.RUNNING:
            self.status, self.reason = FAILURE, self._why()

    def close(self) -> None:
        """Halt what runs, so that leaves let go, and shut the nodes down, each of them whatever another one raises."""
        with ExitStack() as ends:  # last in, first out
            for node, _ in reversed(self._nodes):
                ends.callback(node.shutdown)
            ends.callback(self._tell)
            # A tick that raised leaves a root behind that does not run over leaves that do.
            if any(node.status is Status.RUNNING for node, _ in self._nodes):
                self.root.stop(Status.INVALID)

    def display(self) -> str:
        """The tree with its present statuses, as text."""
        text: str = unicode_tree(self.root, show_status=True)
        return text

    def _walk(self, node: Behaviour, path: str, depth: int) -> list[NodeOutline]:
        self._nodes.append((node, path))
        found = [NodeOutline(path, node.name, type(node).__name__, depth)]
        twins: Counter[str] = Counter()
        for child in node.children:
            twins[child.name] += 1
            suffix = f"#{twins[child.name]}" if twins[child.name] > 1 else ""
            found += self._walk(child, f"{path}/{child.name}{suffix}", depth + 1)
        return found

    def _tell(self) -> None:
        """Emit what changed its status, children before their parents."""
        for i in range(len(self._nodes) - 1, -1, -1):
            node, path = self._nodes[i]
            if node.status is not self._seen[i]:
                self._seen[i] = node.status
                self._mission.note(NodeTicked, node=path, status=node.status.name, feedback=node.feedback_message)

    def _no_status(self, node: Behaviour) -> Fault:
        path, kind = self._paths.get(node.id, node.name), type(node).__name__
        return Fault(
            f"update of '{path}' ({kind}) gave no status back.", hint="Return Status.RUNNING, SUCCESS or FAILURE."
        )

    def _why(self) -> str:
        tip = self.root.tip() or self.root
        return f"{self._paths.get(tip.id, tip.name)}: {tip.feedback_message or tip.status.name}"
