"""What is wrong between an agent and its peers, reported once for each kind and start of a peer."""

from __future__ import annotations

from ...event import EventSink, PeerFault
from .group_clock import DRIFT, GroupClock, is_calendar
from .presence import Presence
from .scope import agent_of
from .wire import Beat

_REASON = 300  # characters of a reason that are reported at most


class PeerFaults:
    """Reports refused writes and wrong clocks, and keeps the agent's clock with its peers'.

    Args:
        agent: Name of the agent.
        presence: Peers and what was reported of them.
        clock: Calendar of the group.
        sink: Receives PeerFault.
    """

    def __init__(self, agent: str, presence: Presence, clock: GroupClock, sink: EventSink) -> None:
        self._agent = agent
        self._presence = presence
        self._clock = clock
        self._sink = sink

    def keep_time(self, sender: str, beat: Beat, t: float) -> bool:
        """Follow the clock of a peer that is ahead; False if its beat tells no time at all."""
        if not is_calendar(beat.time, beat.ahead):
            return False
        if behind := self._clock.follow(beat.time):
            self._report(sender, "clock", f"this robot's clock was {_span(behind)} behind, and follows it now", t)
        elif beat.ahead > DRIFT:
            self._report(sender, "behind", f"its clock was {_span(beat.ahead)} behind, and follows the others' now", t)
        return True

    def refused(self, sender: str, reason: str, t: float) -> None:
        """A write of a peer was refused."""
        self._report(sender, "refused", f"a write was refused: {reason[:_REASON]}", t)

    def _report(self, origin: str, kind: str, detail: str, t: float) -> None:
        peer = self._presence.peers.get(origin)
        if peer is not None and kind not in peer.faults:
            peer.faults.add(kind)
            event = PeerFault(t=t, agent=self._agent, peer=agent_of(origin), start=origin, kind=kind, detail=detail)
            self._sink.emit(event)


def _span(seconds: float) -> str:
    """A time in words."""
    return f"{seconds:.1f} s" if seconds < 86400.0 else f"{seconds / 86400.0:.1f} days"
