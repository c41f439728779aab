"""GroupClock: calendar time that all agents of a group agree on; and reports of faulty peers."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..base.clock import Clock
from ..event import EventSink, PeerFault
from .presence import Presence
from .replica import STAMP_LIMIT
from .scope import agent_of
from .wire import Heartbeat

DRIFT = 1.0
"""Tolerated lag of a clock behind a peer's [s]; longer than the transmission of a heartbeat."""


class GroupClock:
    """Calendar time that is corrected to the most advanced calendar in a group of agents.

    This time stamps the writes; of two conflicting writes, the later one wins. Without the correction, a robot with a
    calendar years behind would lose every conflict with a peer. The calendar is read only once, and then advanced by
    the agent's own clock, so setting the computer's date during a run has no effect.

    Args:
        calendar: Time since an epoch that all peers share [s].
        clock: The agent's clock; it must be running when `now` is first called.

    Attributes:
        ahead: Correction that has been added to this agent's calendar so far [s], never negative.
    """

    def __init__(self, calendar: Callable[[], float], clock: Clock) -> None:
        self.ahead = 0.0
        self._calendar = calendar
        self._clock = clock
        self._start: float | None = None  # [s] calendar time at which the agent's clock was zero

    def now(self) -> float:
        """Group time: calendar time of this agent plus the correction `ahead` [s]."""
        if self._start is None:
            self._start = self._calendar() - self._clock.now()
        return self._start + self._clock.now() + self.ahead

    def follow(self, time: float) -> float:
        """Advance to a peer's calendar time [s] if that is ahead by more than `DRIFT`.

        Returns:
            Time by which the correction has increased [s]; 0 if the peer is not ahead.
        """
        behind = time - self.now()
        if behind <= DRIFT:
            return 0.0
        self.ahead += behind
        return behind


def is_calendar(time: float, ahead: float) -> bool:
    """Whether the calendar time and the correction [s] that a peer reports are plausible."""
    return 0.0 <= time < STAMP_LIMIT * 0.5e-6 and 0.0 <= ahead < math.inf


_REASON = 300  # maximum number of characters of a reported reason


class PeerFaults:
    """Reports refused writes and wrong clocks of peers, and corrects the agent's calendar time."""

    def __init__(self, agent: str, presence: Presence, clock: GroupClock, sink: EventSink) -> None:
        self._agent = agent
        self._presence = presence
        self._clock = clock
        self._sink = sink

    def check_clock(self, sender: str, beat: Heartbeat, t: float) -> bool:
        """Advance the group clock if the peer's is ahead; False if the time in its heartbeat is implausible."""
        if not is_calendar(beat.time, beat.ahead):
            return False
        if behind := self._clock.follow(beat.time):
            self._report(sender, "clock", f"this robot's clock was {_span(behind)} behind and has been corrected", t)
        elif beat.ahead > DRIFT:
            self._report(sender, "behind", f"its clock was {_span(beat.ahead)} behind and has been corrected", t)
        return True

    def refused(self, sender: str, reason: str, t: float) -> None:
        """Report that a write of a peer was refused."""
        self._report(sender, "refused", f"a write was refused: {reason[:_REASON]}", t)

    def _report(self, origin: str, kind: str, detail: str, t: float) -> None:
        peer = self._presence.peers.get(origin)
        if peer is not None and kind not in peer.faults:
            peer.faults.add(kind)
            event = PeerFault(t=t, agent=self._agent, peer=agent_of(origin), start=origin, kind=kind, detail=detail)
            self._sink.emit(event)


def _span(seconds: float) -> str:
    """A duration in words."""
    return f"{seconds:.1f} s" if seconds < 86400.0 else f"{seconds / 86400.0:.1f} days"
