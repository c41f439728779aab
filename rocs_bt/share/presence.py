"""Presence: which peers are present, and which writes each peer has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .scope import agent_of

BEAT_PERIOD = 0.5
"""Period of the heartbeats [s]."""

ABSENT_AFTER = 3.0 * BEAT_PERIOD
"""Time without a message after which a peer counts as vanished [s]."""


AGENT_LIMIT = 1024
"""Maximum number of departed agents with a remembered last message."""


@dataclass
class Peer:
    """One start of another agent's process; the agent is another peer after a restart.

    Attributes:
        origin: Name of the agent and of this start of its process, `agent#start`.
        heard: Time of the peer's last message [s].
        seen: Number of the newest write that the peer has reported as seen, for each origin of writes.
        present: Whether the peer is present.
        faults: Kinds of faults of the peer that have been reported.
    """

    origin: str
    heard: float
    seen: dict[str, int] = field(default_factory=dict)
    present: bool = True
    faults: set[str] = field(default_factory=set)


class Presence:
    """All known peers, present or absent."""

    def __init__(self) -> None:
        self.peers: dict[str, Peer] = {}
        self._last: dict[str, float] = {}  # by agent, time of the last message of its forgotten starts [s]

    def record_message(self, origin: str, t: float) -> tuple[Peer, bool]:
        """Record a message of a peer; returns the peer, and whether it has just appeared or returned."""
        peer = self.peers.get(origin)
        if peer is None:
            peer = self.peers[origin] = Peer(origin, t)
            return peer, True
        appeared, peer.present, peer.heard = not peer.present, True, t
        return peer, appeared

    def record_mention(self, origin: str, t: float) -> None:
        """Record an origin that another peer mentioned; it counts as present only after a message of its own."""
        peer = self.peers.setdefault(origin, Peer(origin, t, present=False))
        peer.heard = max(peer.heard, t) if not peer.present else peer.heard

    def record_departure(self, origin: str) -> bool:
        """Record the departure of a peer; returns whether it was present."""
        peer = self.peers.get(origin)
        was = peer is not None and peer.present
        if peer is not None:
            peer.present = False
        return was

    def overdue(self, t: float) -> list[str]:
        """Present peers without a message for longer than `ABSENT_AFTER`."""
        return [p.origin for p in self.peers.values() if p.present and t - p.heard > ABSENT_AFTER]

    @property
    def starts(self) -> dict[str, str]:
        """Newest origin (`agent#start`) of each present agent."""
        return {agent_of(p.origin): p.origin for p in sorted(self.peers.values(), key=lambda p: p.heard) if p.present}

    def silence(self, t: float) -> dict[str, float]:
        """Time since the last message of each absent agent [s]."""
        last = dict(self._last)
        for peer in self.peers.values():
            agent = agent_of(peer.origin)
            last[agent] = max(last.get(agent, peer.heard), peer.heard)
        here = self.starts
        return {agent: t - heard for agent, heard in last.items() if agent not in here}

    def forget(self, t: float, after: float) -> list[str]:
        """Forget the origins that have been absent for longer than `after` [s] at time `t` [s], and return them."""
        gone = [p for p in self.peers.values() if not p.present and t - p.heard > after]
        for peer in gone:
            del self.peers[peer.origin]
            agent = agent_of(peer.origin)
            self._last[agent] = max(peer.heard, self._last.pop(agent, peer.heard))
        while len(self._last) > AGENT_LIMIT:
            del self._last[next(iter(self._last))]
        return [peer.origin for peer in gone]

    def stable(self, mine: Mapping[str, int]) -> dict[str, int]:
        """Number of the newest write that this agent and every peer have seen, for each origin of writes.

        The result is empty while a peer has seen a write that this agent has not.
        """
        known = [peer.seen for peer in self.peers.values()]
        if any(number > mine.get(origin, 0) for seen in known for origin, number in seen.items()):
            return {}
        return {origin: min([number, *(seen.get(origin, 0) for seen in known)]) for origin, number in mine.items()}
