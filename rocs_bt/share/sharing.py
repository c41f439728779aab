"""Sharing: the block that synchronises an agent's knowledge with that of its peers (paper, 4.2).

Sharing runs in turns. In each turn it publishes changes of the agent's graph, merges changes of peers, answers requests
and sends heartbeats. A turn never blocks and its work is bounded, so it does not delay planning or control. A heartbeat
lists the writes that its sender has seen; an agent that lacks some of them requests them.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from ..event import PeerAppeared, PeerVanished
from ..knowledge.knowledge import Knowledge
from .group_clock import GroupClock, PeerFaults
from .inbox import Counts, FrameQueue
from .messenger import GroupMessenger
from .mirror import Mirror
from .network import Network
from .presence import BEAT_PERIOD, Presence
from .replica import Entry, Key, Plain, Replica
from .scope import PEER, SharingScope, agent_of, is_origin
from .wire import Ack, Delta, Heartbeat, Leave, Message, Request, TextAck, TextMessage, encode, parts

TURN_IN = 2000
"""Approximate maximum number of received messages, plus entries in them, that a turn processes."""

TURN_OUT = 64
"""Maximum number of frames sent in a turn."""

TURN_DELTAS = 8
"""Maximum number of frames with entries sent in a turn, so that receivers keep up."""

TURN_CHANGES = 2000
"""Maximum number of graph changes published in a turn."""

PEERS = 1024
"""Maximum number of remembered peers."""

SYNCS = 256
"""Maximum number of multi-part answers received at the same time."""

PARTS = 4096
"""Maximum number of parts of one answer."""

RETRY_AFTER = 0.3
"""Time after which missing writes are requested again [s]."""

PRUNE = 10.0
"""Time between two prunings [s]."""

MEMORY = 3600.0
"""Time for which an absent peer is remembered, and removals that it has not seen are kept [s]."""


@dataclass(frozen=True)
class Ageing:
    """Expiry of the knowledge from vanished peers.

    Attributes:
        state: Time without a message after which the pose and motion of a vanished robot count as unknown [s].
        rest: Time without a message after which everything else that the robot shared is dropped [s].
    """

    state: float = 3.0
    rest: float = math.inf


class Sharing:
    """Sharing block of one agent.

    Args:
        knowledge: Knowledge of the agent.
        scope: Shared part of the graph.
        network: Network of the peers.
        origin: `agent#start`; unique for each start of the agent.
        calendar: Returns the time since an epoch that all peers share [s]; it may be wrong, and is called once.
        key: Secret of the group, which authenticates messages.
        ageing: Expiry of the knowledge from vanished peers.
        gap: Minimum time between two turns [s].
    """

    def __init__(
        self,
        knowledge: Knowledge,
        scope: SharingScope,
        network: Network,
        *,
        origin: str,
        calendar: Callable[[], float],
        key: bytes = b"",
        ageing: Ageing = Ageing(),
        gap: float = 0.02,
    ) -> None:
        self.counts = Counts()
        self.clock = GroupClock(calendar, knowledge.graph.clock)
        self.replica = Replica(origin, self.clock.now)
        self.awake = threading.Event()
        self._gap = gap
        self.presence = Presence()
        self._faults = PeerFaults(knowledge.agent, self.presence, self.clock, knowledge.sink)
        self.messenger = GroupMessenger(knowledge.agent, lambda: self.presence.starts)
        self._agent = knowledge.agent
        self._scope = scope
        self._sink = knowledge.sink
        self._key = key
        self._ageing = ageing
        self._mirror = Mirror(knowledge, self.replica, scope, self.counts, self.awake.set)
        self._inbox = FrameQueue(key, self.counts, self.awake.set)
        self._lost: deque[str] = deque()
        self._out: deque[tuple[str | None, Message]] = deque()
        self._syncs = 0
        self._parts: dict[tuple[str, int], set[int]] = {}
        self._requested: tuple[str, float] = ("", -math.inf)
        self._acks_due: dict[str, int] = {}  # by origin, number up to which its writes are to be acknowledged
        self._acked: dict[str, int] = {}  # by peer, number up to which it has acknowledged our writes
        self._beat_at = self._pruned_at = self._ran_at = -math.inf
        self._first = True
        self._link = network.join(origin, self._inbox.put, self._lost.append)

    # -- interface --------------------------------------------------------------------------------------------------

    @property
    def peers(self) -> list[str]:
        """The other agents that are present."""
        return self.messenger.others()

    @property
    def written(self) -> int:
        """Number of writes published since the start."""
        return self.replica.seen.get(self.replica.origin, 0)

    @property
    def acknowledged(self) -> int:
        """Number of writes of this agent that all present peers have received; 0 without peers."""
        here = [p for p in list(self.presence.peers.values()) if p.present]  # another thread may add a peer meanwhile
        held = (max(self._acked.get(p.origin, 0), p.seen.get(self.replica.origin, 0)) for p in here)
        return min(self.written, min(held, default=0))

    def statistics(self) -> dict[str, float]:
        """Statistics for summary.json: all counts, the acknowledged writes, and the correction of the clock [s]."""
        return {**self.counts.as_dict(), "acknowledged": self.acknowledged, "clock_ahead": round(self.clock.ahead, 3)}

    @property
    def pending(self) -> bool:
        """Whether there is anything to publish, send or merge."""
        return self._mirror.pending or self._inbox.pending or bool(self._out)

    @property
    def due_at(self) -> float:
        """Earliest time of the next turn [s]."""
        return self._ran_at + self._gap

    def due(self, t: float) -> bool:
        """Whether a turn may run at time t [s]."""
        return t >= self.due_at - 5e-7

    def run(self, t: float) -> None:
        """Run one turn at time t [s]."""
        self._ran_at = t
        self.awake.clear()
        self._link.poll()
        self._mirror.publish_state(t)
        self._publish(t)
        changed: dict[Key, Plain] = {}
        for sender, message in self._inbox.take(TURN_IN):
            self._take(sender, message, t, changed)
        if changed:
            self._mirror.apply(changed, t)
        self._check_peers(t)
        for peer, say in self.messenger.outgoing(t, self.presence.starts):
            self._out.append((peer, say))
        self._finish(t)

    def halt(self, t: float) -> None:
        """Publish that the robot stops at time t [s], because its agent has ended."""
        self._mirror.publish_state(t, halted=True)
        self._publish(t)
        self._finish(t)

    def close(self) -> None:
        """Announce the departure and leave the network."""
        self._mirror.close()
        self._link.send(encode(self.replica.origin, Leave(), self._key))
        self._link.close()

    # -- publishing -------------------------------------------------------------------------------------------------

    def _publish(self, t: float) -> None:
        if self._busy(4):
            return  # when published later, several changes of a value become one write
        base = self.written
        entries = self._mirror.collect(t, TURN_CHANGES, first=self._first)
        self._first = False
        if entries:
            me = self.replica.origin
            self._send_entries(None, entries, {me: base}, {me: self.written}, t)

    def _send_entries(
        self, to: str | None, entries: list[Entry], base: dict[str, int], upto: dict[str, int], t: float
    ) -> None:
        self._syncs += 1
        portions, since = parts(entries), self.replica.since
        for index, portion in enumerate(portions):
            ages = [round(max(0.0, t - since.get(entry.key, t)), 4) for entry in portion]
            delta = Delta(self._syncs, index, len(portions), self._scope.digest, base, upto, portion, ages)
            self._out.append((to, delta))

    def _finish(self, t: float) -> None:
        """Send a heartbeat if it is due, and the waiting messages within the limits of a turn."""
        if t >= self._beat_at + BEAT_PERIOD:
            self._beat_at = t
            self._out.append((None, self._beat()))
        for origin, number in self._acks_due.items():
            self._out.append((origin, Ack(number)))
        self._acks_due.clear()
        deltas = 0
        for _ in range(min(TURN_OUT, len(self._out))):
            deltas += isinstance(self._out[0][1], Delta)
            if deltas > TURN_DELTAS:
                break
            to, message = self._out.popleft()
            self._link.send(encode(self.replica.origin, message, self._key), to)
        if self.pending:
            self.awake.set()

    def _busy(self, turns: int) -> bool:
        """Whether the waiting messages need more than a number of turns."""
        return len(self._out) > turns * TURN_OUT

    def _beat(self) -> Heartbeat:
        seen, clock = dict(self.replica.seen), self.clock
        return Heartbeat(seen, self.replica.sum, self._scope.digest, clock.now(), clock.ahead)

    # -- receiving --------------------------------------------------------------------------------------------------

    def _take(self, sender: str, message: Message, t: float, changed: dict[Key, Plain]) -> None:
        if agent_of(sender) == self._agent and sender == self.replica.origin:
            return  # an echo of our own message
        if isinstance(message, Leave):
            self._vanished(sender, t)
            return
        if sender not in self.presence.peers and len(self.presence.peers) >= PEERS:
            self.counts.flooded += 1
            return
        peer, appeared = self.presence.record_message(sender, t)
        if appeared:
            self._sink.emit(PeerAppeared(t=t, agent=self._agent, peer=agent_of(sender), start=sender))
            if not self._busy(2):
                self._out.append((sender, self._beat()))
        match message:
            case Heartbeat():
                peer.seen = message.seen
                self.counts.malformed += not self._faults.check_clock(sender, message, t)
                self._compare(sender, message, t)
            case Delta():
                self._merge(sender, message, t, changed)
            case Request():
                self._answer(sender, message, t)
            case Ack():
                self._acked[sender] = max(self._acked.get(sender, 0), message.number)
            case TextMessage() if self._busy(2):
                self.counts.flooded += 1  # the sender repeats it
            case TextMessage():
                self._out.append((sender, self.messenger.receive(sender, message)))
            case TextAck():
                self.messenger.acknowledge(sender, message)

    def _compare(self, sender: str, beat: Heartbeat, t: float) -> None:
        """Request the writes that a peer has and this agent lacks; all entries if only the checksums differ."""
        asked, at = self._requested
        if asked and t < at + RETRY_AFTER:
            return
        mine = self.replica
        if mine.lacks(beat.seen):
            self._request(sender, dict(mine.seen), t)
        elif beat.scope == self._scope.digest and beat.seen == mine.seen and beat.sum != mine.sum:
            self._request(sender, {}, t)

    def _request(self, peer: str, seen: dict[str, int], t: float) -> None:
        self._requested = (peer, t)
        self._out.append((peer, Request(seen)))

    def _answer(self, sender: str, want: Request, t: float) -> None:
        if self._busy(1):
            return  # still busy with earlier answers; the peer requests again
        mine = self.replica.seen
        base = {origin: min(number, mine[origin]) for origin, number in want.seen.items() if origin in mine}
        self._send_entries(sender, self.replica.missing(want.seen), base, dict(self.replica.seen), t)

    def _merge(self, sender: str, delta: Delta, t: float, changed: dict[Key, Plain]) -> None:
        if len(delta.ages) != len(delta.entries) or not 0 <= delta.part < delta.parts <= PARTS:
            self.counts.malformed += 1
            return
        for entry, age in zip(delta.entries, delta.ages, strict=True):
            if problem := self._problem(entry, age):
                self.counts.refused += 1
                self._faults.refused(sender, problem, t)
                continue
            before = self._mirror.visible(entry.key)
            if self.replica.merge(entry, t - max(0.0, age)):
                self.counts.merged += 1
                changed.setdefault(entry.key, before)
                self._note_reporter(entry)
        if self._requested[0] == sender:
            self._requested = (sender, t)  # the answer is in progress
        self._learn(sender, delta, t)

    def _problem(self, entry: Entry, age: float) -> str:
        """Reason to refuse an entry of a peer; empty if it is acceptable."""
        if problem := self._scope.refuses(entry):
            return problem
        if not math.isfinite(age):
            return f"the age {age:g} s is not finite"
        return "" if self.replica.admits(entry) else "the replica is full, or the stamp is too far ahead"

    def _learn(self, sender: str, delta: Delta, t: float) -> None:
        """Count the writes of a message as seen once all its parts have arrived.

        Writes of third agents count only if the sender has the same scope, because it may have refused some of them.
        """
        parts_seen = self._parts.setdefault((sender, delta.sync), set())
        parts_seen.add(delta.part)
        if len(self._parts) > SYNCS:  # a part of the oldest answer was lost; a heartbeat will cause a new request
            del self._parts[next(iter(self._parts))]
        if len(parts_seen) < delta.parts:
            return
        self._parts.pop((sender, delta.sync), None)
        if self._requested[0] == sender:
            self._requested = ("", t)
        if self.replica.lacks(delta.base):
            if not self._requested[0]:
                self._request(sender, dict(self.replica.seen), t)
            return
        same = delta.scope == self._scope.digest
        me, here = self.replica.origin, self.presence.starts.values()
        upto = {o: n for o, n in delta.upto.items() if (same or o == sender) and o != me and is_origin(o)}
        for origin in self.replica.learn(upto, set(here)):
            if len(self.presence.peers) < PEERS:
                self.presence.record_mention(origin, t)
        if sender in self.replica.seen:
            self._acks_due[sender] = self.replica.seen[sender]

    def _note_reporter(self, entry: Entry) -> None:
        """Record the writer of an entry as self-reporting if the entry is about its own node."""
        agent = agent_of(entry.origin)
        if agent != self._agent and entry.key[0] == agent and entry.key[1:2] in ((), (PEER,)):
            self._mirror.self_reporting[agent] = None

    # -- peers ------------------------------------------------------------------------------------------------------

    def _check_peers(self, t: float) -> None:
        while self._lost:
            self._vanished(self._lost.popleft(), t)
        for origin in self.presence.overdue(t):
            self._vanished(origin, t)
        silence = self.presence.silence(t)
        silence.pop(self._agent, None)
        silent = {agent for agent, age in silence.items() if age > self._ageing.state}
        self._mirror.age(silent, {agent for agent, age in silence.items() if age > self._ageing.rest}, t)
        if t >= self._pruned_at + PRUNE:
            self._pruned_at = t
            for origin in self.presence.forget(t, MEMORY):
                self._acked.pop(origin, None)
                self.messenger.forget(origin)
            for key in [key for key in self._parts if key[0] not in self.presence.peers]:
                del self._parts[key]
            self.replica.prune(self.presence.stable(self.replica.seen))

    def _vanished(self, origin: str, t: float) -> None:
        if self.presence.record_departure(origin):
            if self._requested[0] == origin:
                self._requested = ("", t)
            self._sink.emit(PeerVanished(t=t, agent=self._agent, peer=agent_of(origin), start=origin))
