"""Nodes that replace an action server of Nav2: their goals can be cancelled by another node."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, Final

from ..plan.context import MissionContext, mission_of
from ..trees.nodes import SUCCESS, Instant, Leaf, Node, Outcome
from ..trees.status import IDLE
from .lenient import Served

YOUNG = 0.01
"""Age up to which a goal is not cancelled [s]."""


class Cancellable(Served, Leaf):
    """Base of leaves that pursue a goal for a while, and end with SUCCESS if a Cancel node cancels it."""

    cancelled = False

    def initialise(self) -> None:
        self.cancelled, self.begun = False, self.runtime.now()
        running(mission_of(self), self.tag)[id(self)] = self
        super().initialise()

    def terminate(self, new_status: Any) -> None:
        running(mission_of(self), self.tag).pop(id(self), None)
        if new_status is IDLE:
            self.put_error()
        super().terminate(new_status)


def running(mission: MissionContext, tag: str) -> dict[int, Cancellable]:
    """Nodes of a class that pursue a goal now."""
    found: dict[int, Cancellable] = mission.shared.setdefault("nav2 goals", {}).setdefault(tag, {})
    return found


class _Cancel(Served, Instant):
    """Base of nodes that cancel the goals of another node's class."""

    server: ClassVar[str] = ""

    def update(self) -> Outcome:
        now = self.runtime.now()
        for node in running(mission_of(self), self.server).values():
            node.cancelled = node.cancelled or now - node.begun > YOUNG
        return SUCCESS


CANCELLED: Final = {
    "CancelControl": "FollowPath",
    "CancelBackUp": "BackUp",
    "CancelDriveOnHeading": "DriveOnHeading",
    "CancelSpin": "Spin",
    "CancelAssistedTeleop": "AssistedTeleop",
    "CancelWait": "Wait",
    "CancelComputeAndTrackRoute": "ComputeAndTrackRoute",
    "CancelFollowObject": "FollowObject",
}
"""Node with goals that a Cancel node cancels, by its name."""


def cancel_nodes() -> Iterable[type[Node]]:
    """Create the Cancel nodes: SUCCESS, after which the cancelled nodes end with SUCCESS and the error code 0."""
    for tag, server in CANCELLED.items():
        doc = f"Cancels the goals of {server} that are older than 10 ms, which then ends with SUCCESS."
        yield type(tag, (_Cancel,), {"tag": tag, "server": server, "__doc__": doc, "__module__": __name__})
