"""Who is there, who was, and how much each has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .scope import agent_of

BEAT_PERIOD = 0.5
"""[s] How often a peer says that it is there."""

ABSENT_AFTER = 3.0 * BEAT_PERIOD
"""[s] After which one that says nothing has vanished."""


AGENT_LIMIT = 1024
"""Agents at most of which it is remembered that they are gone for good."""


@dataclass
class Peer:
    """A start of another agent.

    Attributes:
        origin: Its name.
        heard: When it was last heard of [s].
        seen: What it said that it has seen.
        present: Whether it is there.
        faults: Kinds of faults of it that were reported.
    """

    origin: str
    heard: float
    seen: dict[str, int] = field(default_factory=dict)
    present: bool = True
    faults: set[str] = field(default_factory=set)


class Presence:
    """All peers that were ever heard of."""

    def __init__(self) -> None:
        self.peers: dict[str, Peer] = {}
        self._last: dict[str, float] = {}  # by agent, when a start of it was heard of that is forgotten [s]

    def hear(self, origin: str, t: float) -> tuple[Peer, bool]:
        """A peer said something; and whether it has only now come, or come back."""
        peer = self.peers.get(origin)
        if peer is None:
            peer = self.peers[origin] = Peer(origin, t)
            return peer, True
        came, peer.present, peer.heard = not peer.present, True, t
        return peer, came

    def hear_of(self, origin: str, t: float) -> None:
        """Others told of a start: it is one that may come, and it wrote lately; whether it is there it says itself."""
        peer = self.peers.setdefault(origin, Peer(origin, t, present=False))
        peer.heard = max(peer.heard, t) if not peer.present else peer.heard

    def vanish(self, origin: str) -> bool:
        """A peer is gone, as it said itself or as the network noticed; whether it was there."""
        peer = self.peers.get(origin)
        was = peer is not None and peer.present
        if peer is not None:
            peer.present = False
        return was

    def overdue(self, t: float) -> list[str]:
        """Peers that have said nothing for too long."""
        return [p.origin for p in self.peers.values() if p.present and t - p.heard > ABSENT_AFTER]

    @property
    def starts(self) -> dict[str, str]:
        """By agent that is there, its newest start."""
        return {agent_of(p.origin): p.origin for p in sorted(self.peers.values(), key=lambda p: p.heard) if p.present}

    def unheard(self, t: float) -> dict[str, float]:
        """By agent that is not there, for how long nobody heard of it [s]."""
        last = dict(self._last)
        for peer in self.peers.values():
            agent = agent_of(peer.origin)
            last[agent] = max(last.get(agent, peer.heard), peer.heard)
        here = self.starts
        return {agent: t - heard for agent, heard in last.items() if agent not in here}

    def forget(self, t: float, after: float) -> list[str]:
        """Forget the starts that were gone for so long; which these were."""
        gone = [p for p in self.peers.values() if not p.present and t - p.heard > after]
        for peer in gone:
            del self.peers[peer.origin]
            agent = agent_of(peer.origin)
            self._last[agent] = max(peer.heard, self._last.pop(agent, peer.heard))
        while len(self._last) > AGENT_LIMIT:
            del self._last[next(iter(self._last))]
        return [peer.origin for peer in gone]

    def stable(self, mine: Mapping[str, int]) -> dict[str, int]:
        """Up to where every peer has seen each origin's writes; empty while one knows of writes that are not here."""
        known = [peer.seen for peer in self.peers.values()]
        if any(number > mine.get(origin, 0) for seen in known for origin, number in seen.items()):
            return {}
        return {origin: min([number, *(seen.get(origin, 0) for seen in known)]) for origin, number in mine.items()}
