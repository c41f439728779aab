"""Replica of shared knowledge: a map with writes that merge to the same result in any order and multiplicity.

Each write is an entry for one key, which denotes a node, an attribute or an edge. Of two entries for the same key, the
one with the later stamp wins (a last-writer-wins register: Shapiro et al., Conflict-free Replicated Data Types, 2011,
3.2). Stamps are hybrid logical clocks (Kulkarni et al., Logical Physical Clocks, 2014): a write is stamped later than
every write that its writer knew. A wrong clock can therefore decide only between concurrent writes. Losing entries are
deleted, so a replica does not grow with the number of writes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TypeAlias

import msgspec

Key: TypeAlias = tuple[str, ...]
"""What an entry is about: (node,) for the kind of a node, (node, kind, attribute) for an attribute, or
(source, relation, target, "") for an edge with its attributes."""

Simple: TypeAlias = bool | int | float | str | list[float] | None
Plain: TypeAlias = Simple | dict[str, Simple]
"""Shared form of a key's value; None if the node or edge does not exist or the attribute is unknown."""

STAMP_LIMIT = 2**56
"""Upper bound of a stamp [us]: the year 4253."""


STAMP_STEP = 2**20
"""Maximum lead of a stamp over the latest one seen [us], so that no peer can use up the range of stamps."""

ENTRY_LIMIT = 2**18
"""Maximum number of entries of a replica; a full replica refuses new keys from peers."""

NAMES_LIMIT = 12288
"""Maximum total size of all remembered origins [bytes]: twice that, and an entry, must fit into a frame."""


class Entry(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """One write of shared knowledge.

    Attributes:
        key: Written node, attribute or edge.
        value: New value; None removes the key.
        stamp: Hybrid logical clock of the writer [us].
        origin: Writer as `agent#start`; an agent has another origin after each start.
        number: Sequence number of the write among the writes of its origin, from 1.
    """

    key: Key
    value: Plain
    stamp: int
    origin: str
    number: int

    def after(self, other: Entry | None) -> bool:
        """Whether this entry wins over another entry for the same key."""
        return other is None or (self.stamp, self.origin) > (other.stamp, other.origin)

    @property
    def weight(self) -> int:
        """Hash that the entry adds to the checksum `Replica.sum`; 0 for a removal."""
        if self.value is None:
            return 0
        packed = msgspec.msgpack.encode((self.key, self.value, self.stamp, self.origin))
        return int.from_bytes(hashlib.blake2b(packed, digest_size=8).digest(), "big")


class Replica:
    """One agent's copy of the shared knowledge: the winning entry of each key, and which writes have been seen.

    Args:
        origin: Origin of the writes of this agent, `agent#start`; it must be new at every start, because a number must
            never denote two writes.
        calendar: Returns the time since an epoch that all peers share [s]; it may be wrong.

    Attributes:
        entries: Entries by key, including removals.
        since: Write time of each key's entry on the clock of this agent [s].
        seen: Number of the newest seen write, by origin. All earlier writes of the origin have been seen or superseded.
        sum: Checksum of the entries; replicas with different entries have equal checksums with a probability of 1 in
            2^64.
    """

    def __init__(self, origin: str, calendar: Callable[[], float]) -> None:
        self.origin = origin
        self.entries: dict[Key, Entry] = {}
        self.since: dict[Key, float] = {}
        self.seen: dict[str, int] = {}
        self.sum = 0
        self._calendar = calendar
        self._stamp = 0
        self._about: dict[str, dict[Key, None]] = {}
        self._names = 0  # [bytes] size of the origins in `seen`, as sent

    def value(self, key: Key) -> Plain:
        """Value of a key; None if the key has no entry or was removed."""
        entry = self.entries.get(key)
        return None if entry is None else entry.value

    def about(self, node: str) -> list[Key]:
        """Keys of a node, of its attributes and of all its edges, in order of arrival."""
        return list(self._about.get(node, ()))

    def write(self, key: Key, value: Plain, t: float, *, first: bool = False) -> Entry:
        """Write a value of this agent; returns the new entry.

        Args:
            key: Node, attribute or edge to write.
            value: New value; None to remove the key.
            t: Present time on the clock of this agent [s].
            first: Whether the value was known before the first contact with a peer; the write then loses against all
                later ones.
        """
        number = self.seen.get(self.origin, 0) + 1
        if first:
            stamp = number
        else:
            stamp = self._stamp = max(self._stamp + 1, min(int(self._calendar() * 1e6), STAMP_LIMIT // 2))
        entry = Entry(key, value, stamp, self.origin, number)
        self.seen[self.origin] = number
        if entry.after(self.entries.get(key)):
            self._put(entry, t)
        return entry

    def admits(self, entry: Entry) -> bool:
        """Whether an entry from a peer has a plausible time stamp, and there is room for it.

        A writer with a slow clock uses stamps slightly later than the latest stamp that it has seen. A stamp far beyond
        all seen ones is wrong. If it were accepted, the writes of other agents could soon find no later stamp.
        """
        if entry.stamp > max(self._stamp, STAMP_LIMIT // 2) + STAMP_STEP:
            return False
        return entry.key in self.entries or len(self.entries) < ENTRY_LIMIT

    def merge(self, entry: Entry, since: float) -> bool:
        """Merge an entry from a peer; True if the entry wins and replaces the present one of its key.

        Args:
            entry: Entry to merge.
            since: Time of the write on the clock of this agent [s].
        """
        self._stamp = max(self._stamp, entry.stamp)
        if not entry.after(self.entries.get(entry.key)):
            return False
        self._put(entry, since)
        return True

    def learn(self, seen: Mapping[str, int], here: Collection[str] = ()) -> list[str]:
        """Record writes as seen, because received or superseded; returns origins with writes that are new.

        If the names of the origins take too much space, the oldest absent origins are forgotten. Their entries stay,
        but peers may then send these again.
        """
        advanced = [origin for origin, number in seen.items() if number > self.seen.get(origin, 0)]
        for origin in advanced:
            self._names += 0 if origin in self.seen else _length(origin)
            self.seen[origin] = seen[origin]
        if self._names > NAMES_LIMIT:
            for origin in sorted(self.seen, key=lambda each: each in here):
                if self._names > NAMES_LIMIT and origin != self.origin:
                    del self.seen[origin]
                    self._names -= _length(origin)
        return advanced

    def lacks(self, seen: Mapping[str, int]) -> bool:
        """Whether a peer has seen a write that this replica lacks, given its newest seen write by origin."""
        return any(number > self.seen.get(origin, 0) for origin, number in seen.items())

    def missing(self, seen: Mapping[str, int]) -> list[Entry]:
        """Entries that a peer may lack, given its newest seen write by origin, in the order of stamps."""
        found = [entry for entry in self.entries.values() if entry.number > seen.get(entry.origin, 0)]
        return sorted(found, key=lambda entry: (entry.stamp, entry.origin, entry.number))

    def prune(self, stable: Mapping[str, int]) -> int:
        """Delete the entries of removals that every peer has seen; returns the number of deleted entries.

        A removal must stay until then: a peer that has not seen it would send the old value, which would win again.
        """
        gone = [k for k, e in self.entries.items() if e.value is None and e.number <= stable.get(e.origin, 0)]
        for key in gone:
            del self.entries[key], self.since[key]
            for node in nodes_of(key):
                del self._about[node][key]
                if not self._about[node]:
                    del self._about[node]
        return len(gone)

    @property
    def live(self) -> dict[Key, Plain]:
        """All values by key, without removed keys."""
        return {key: entry.value for key, entry in sorted(self.entries.items()) if entry.value is not None}

    def _put(self, entry: Entry, since: float) -> None:
        old = self.entries.get(entry.key)
        self.sum = (self.sum + entry.weight - (0 if old is None else old.weight)) % 2**64
        if old is None:
            for node in nodes_of(entry.key):
                self._about.setdefault(node, {})[entry.key] = None
        self.entries[entry.key] = entry
        self.since[entry.key] = since


def _length(origin: str) -> int:
    return len(origin.encode()) + 12  # with its number


def nodes_of(key: Key) -> Iterable[str]:
    """Nodes that a key is about: one, or both ends of an edge."""
    return dict.fromkeys((key[0], key[2])) if len(key) == 4 else key[:1]
