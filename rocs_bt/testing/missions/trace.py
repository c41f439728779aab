"""Trace: what a mission did, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...errors import Fault, InputError, unknown
from ...knowledge import Knowledge
from ...trees.board import Board


@dataclass(frozen=True)
class Trace:
    """What a mission did.

        trace["GoTo dock"] == "R R S"    # `.` where it was not ticked, `H` where it was halted, `RH` for both

    Attributes:
        outcomes: What the root came to in each tick, by name.
        cells: The letters of each node by its path, one text a tick.
        board: The root's board.
        knowledge: What the robot knows in the end.
        said: What the mission said, and logged.
        reason: What the node that decided has to say; empty where it has nothing.
        times: When each tick was [s].
    """

    outcomes: tuple[str, ...]
    cells: Mapping[str, tuple[str, ...]]
    board: Board
    knowledge: Knowledge
    said: tuple[str, ...]
    reason: str
    times: tuple[float, ...]

    @property
    def outcome(self) -> str:
        """What the root came to at last."""
        return self.outcomes[-1]

    @property
    def ticks(self) -> int:
        """How often the tree was ticked."""
        return len(self.outcomes)

    def __getitem__(self, node: str) -> str:
        """The letters of a node, a word a tick.

        Args:
            node: Its path, or its name where only one has it.

        Raises:
            InputError: No node has it, or more than one.
        """
        found = [path for path in self.cells if node in (path, path.rsplit("/", 1)[-1])]
        if not found:
            raise InputError(unknown("node", node, self.cells, "The tree"))
        if len(found) > 1 and node not in self.cells:
            raise InputError(Fault(f"{len(found)} nodes are named '{node}'.", hint=f"Say which: {', '.join(found)}."))
        return " ".join(self.cells[node] if node in self.cells else self.cells[found[0]])

    def __str__(self) -> str:
        width = max(max(len(cell) for cell in row) for row in self.cells.values())
        lines = [
            f"{'  ' * path.count('/') + path.rsplit('/', 1)[-1]:<40} {' '.join(f'{c:<{width}}' for c in row)}".rstrip()
            for path, row in self.cells.items()
        ]
        ending = f"{self.outcome} after {self.ticks} ticks" + (f": {self.reason}" if self.reason else "")
        return "\n".join([*lines, ending])
