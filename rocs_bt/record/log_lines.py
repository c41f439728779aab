"""Log lines: what viewers show of a run as text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .. import event as ev
from ..event import Event
from ..raised import reported
from . import foxglove

LogLine = tuple[int, str]
"""Level, as in `foxglove.Log`, and text."""


def log_line(event: Event) -> LogLine | None:
    """Log line about an event; None for events that are not logged."""
    line = LOGGED.get(type(event))
    return None if line is None else line(event)


def _rule(event: ev.RuleChanged) -> LogLine:
    level = foxglove.WARNING if event.phase.startswith("fired") else foxglove.DEBUG
    return level, f"rule {event.rule} {event.phase}" + (f" ({event.reading})" if event.reading else "")


def _ticket(event: ev.TicketChanged) -> LogLine | None:
    return (foxglove.WARNING, f"{event.action} failed: {event.reason}") if event.state == "FAILED" else None


LOGGED: Mapping[type[Event], Callable[[Any], LogLine | None]] = {
    ev.SensorFailed: lambda e: (foxglove.ERROR, f"sensor {e.sensor}: {e.detail}"),
    ev.SubscriberDetached: lambda e: (foxglove.ERROR, f"{e.callback} raised: {e.detail}"),
    ev.ContentRaised: lambda e: (foxglove.ERROR, reported(e)),
    ev.BlockFailed: lambda e: (foxglove.FATAL, f"{e.what} {e.kind}: {e.detail}"),
    ev.ContactBegan: lambda e: (foxglove.ERROR, f"{e.kind} with {e.other}"),
    ev.RobotPushed: lambda e: (foxglove.WARNING, e.text),
    ev.CommandExpired: lambda e: (foxglove.ERROR, f"no command for {e.actuator}"),
    ev.MotionHeld: lambda e: (foxglove.WARNING, f"{e.actuator} held in neutral: {e.reason}"),
    ev.MotionReleased: lambda e: (foxglove.INFO, f"{e.actuator} released"),
    ev.OtherPublisherFound: lambda e: (foxglove.WARNING, e.text),
    ev.Stuck: lambda e: (foxglove.WARNING, e.reason),
    ev.PeerFault: lambda e: (foxglove.WARNING, f"peer {e.peer}: {e.detail}"),
    ev.GoalEntered: lambda e: (foxglove.INFO, f"goal {e.goal} reached"),
    ev.OutcomeDecided: lambda e: (foxglove.INFO, f"outcome: {e.outcome}. {e.reason}"),
    ev.Replanned: lambda e: (foxglove.INFO, f"{e.node} replans ({e.count})"),
    ev.BlackboardChanged: lambda e: (foxglove.INFO, e.text),
    ev.Said: lambda e: (foxglove.INFO, e.text),
    ev.RuleChanged: _rule,
    ev.TicketChanged: _ticket,
}
"""Functions that describe the events that are logged, by type of event."""
