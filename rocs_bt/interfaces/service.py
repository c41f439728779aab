"""What a package runs beside the blocks of an agent, in turns, such as the sharing of knowledge."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Protocol

from .message import Messenger


class Service(Protocol):
    """Runs in turns before the blocks of its agent; on wall time, in a thread of its own.

    A turn never blocks.

    Attributes:
        awake: Set when there is work to do.
        messenger: Messages to and from other robots.
    """

    awake: threading.Event

    @property
    def messenger(self) -> Messenger: ...

    @property
    def due_at(self) -> float:
        """Earliest time of the next turn [s]."""

    def due(self, t: float) -> bool:
        """Whether a turn may run at time t [s]."""

    def run(self, t: float) -> None:
        """Run one turn at time t [s]."""

    def halt(self, t: float) -> None:
        """Tell others at time t [s] that the robot stops, because its agent has ended."""

    def close(self) -> None:
        """Leave."""

    def statistics(self) -> Mapping[str, float]:
        """Statistics for summary.json."""
