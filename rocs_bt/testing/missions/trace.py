"""Trace: record of a mission, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...base.errors import Fault, InputError, unknown
from ...knowledge import Knowledge
from ...trees.board import Board


@dataclass(frozen=True)
class Trace:
    """Record of a mission.

        trace["GoTo dock"] == "R R S"    # `.` if not ticked, `H` if halted, `RH` for both

    Attributes:
        outcomes: Name of the root's outcome in each tick, such as `RUNNING`.
        cells: Outcomes of each node as letters, one text per tick; keyed by the node's path.
        board: Blackboard of the root.
        knowledge: Knowledge at the end.
        said: Texts that the mission spoke or logged, in order of time.
        reason: Feedback message of the node that decided the last outcome; may be empty.
        times: Time of each tick [s].
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
        """Last outcome of the root."""
        return self.outcomes[-1]

    @property
    def ticks(self) -> int:
        """Number of ticks."""
        return len(self.outcomes)

    def __getitem__(self, node: str) -> str:
        """Return the outcomes of a node as letters, one word per tick.

        Args:
            node: Path of the node, or its name if unique.

        Raises:
            InputError: No node, or more than one, has this name.
        """
        found = [path for path in self.cells if node in (path, path.rsplit("/", 1)[-1])]
        if not found:
            raise InputError(unknown("node", node, self.cells, "The tree"))
        if len(found) > 1 and node not in self.cells:
            raise InputError(Fault(f"{len(found)} nodes are named '{node}'.", hint=f"Choose one: {', '.join(found)}."))
        return " ".join(self.cells[node] if node in self.cells else self.cells[found[0]])

    def __str__(self) -> str:
        width = max(max(len(cell) for cell in row) for row in self.cells.values())
        lines = [
            f"{'  ' * path.count('/') + path.rsplit('/', 1)[-1]:<40} {' '.join(f'{c:<{width}}' for c in row)}".rstrip()
            for path, row in self.cells.items()
        ]
        ending = f"{self.outcome} after {self.ticks} ticks" + (f": {self.reason}" if self.reason else "")
        return "\n".join([*lines, ending])
