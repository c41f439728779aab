"""Replica of shared knowledge: a map whose writes merge to the same result in any order and multiplicity.

Each write is one entry under one key; of two entries under a key the one with the later stamp wins (a last-writer-wins
register: Shapiro et al., Conflict-free Replicated Data Types, 2011, 3.2). Stamps are hybrid logical clocks (Kulkarni et
al., Logical Physical Clocks, 2014): a write is stamped later than every write that its writer knew, so a wrong clock
can decide only between concurrent writes. Superseded entries are deleted: the size of a replica depends on what is
known and was recently removed, not on the number of writes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TypeAlias

import msgspec

Key: TypeAlias = tuple[str, ...]
"""(node,) for its kind; (node, kind, attribute); (source, relation, target, "") for an edge and its attributes."""

Simple: TypeAlias = bool | int | float | str | list[float] | None
Plain: TypeAlias = Simple | dict[str, Simple]
"""Shared form of a value; None if it does not exist or is no longer known."""

STAMP_LIMIT = 2**56
"""Upper bound of a stamp [us]: the year 4253."""


STAMP_STEP = 2**20
"""Maximum lead of a stamp over the latest seen or plausible one [us], so that no peer can exhaust the stamps."""

ENTRY_LIMIT = 2**18
"""Maximum number of entries; beyond it a replica accepts no new keys from peers."""

NAMES_LIMIT = 12288
"""Maximum total size of the names of all starts [bytes]: twice that, and an entry, must fit into a frame."""


class Entry(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """One write.

    Attributes:
        key: Key that was written.
        value: Value; None removes the key.
        stamp: Hybrid logical clock of the writer [us].
        origin: Writer as `agent#start`; it differs at each start of the agent.
        number: Sequence number of the write at its origin, from 1.
    """

    key: Key
    value: Plain
    stamp: int
    origin: str
    number: int

    def after(self, other: Entry | None) -> bool:
        """Whether this entry wins over another."""
        return other is None or (self.stamp, self.origin) > (other.stamp, other.origin)

    @property
    def weight(self) -> int:
        """Contribution to the sum by which replicas are compared; 0 for a removal."""
        if self.value is None:
            return 0
        packed = msgspec.msgpack.encode((self.key, self.value, self.stamp, self.origin))
        return int.from_bytes(hashlib.blake2b(packed, digest_size=8).digest(), "big")


class Replica:
    """The winning entries, and which writes have been seen.

    Args:
        origin: Name of the writer here; new at every start, because a number must never denote two writes.
        calendar: Time since an epoch that all peers share [s]; it may be wrong.

    Attributes:
        entries: Entries by key, including removals.
        since: Write time of each key's entry on the holder's clock [s].
        seen: Number up to which each origin's writes have been seen, directly or through others.
        sum: Checksum of the contents; different contents have the same one with a probability of 1 in 2^64.
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
        self._names = 0  # [bytes] size of the names in `seen`, as sent

    def value(self, key: Key) -> Plain:
        """The value of a key; None if there is none."""
        entry = self.entries.get(key)
        return None if entry is None else entry.value

    def about(self, node: str) -> list[Key]:
        """The keys of a node's attributes and of all its edges, in order of arrival."""
        return list(self._about.get(node, ()))

    def write(self, key: Key, value: Plain, t: float, *, first: bool = False) -> Entry:
        """Write a value.

        Args:
            key: Key.
            value: Value; None to remove the key.
            t: Present time on the holder's clock [s].
            first: Whether it was known before the first contact with a peer; it then loses against any other write.
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

        A writer with a slow clock uses stamps slightly later than the latest one it has seen. A stamp far beyond all
        seen ones is wrong; if it were accepted, no other writer could use a later one.
        """
        if entry.stamp > max(self._stamp, STAMP_LIMIT // 2) + STAMP_STEP:
            return False
        return entry.key in self.entries or len(self.entries) < ENTRY_LIMIT

    def merge(self, entry: Entry, since: float) -> bool:
        """Merge an entry from a peer; True if it is later than the present entry of its key and replaces it."""
        self._stamp = max(self._stamp, entry.stamp)
        if not entry.after(self.entries.get(entry.key)):
            return False
        self._put(entry, since)
        return True

    def learn(self, seen: Mapping[str, int], here: Collection[str] = ()) -> list[str]:
        """Record writes as seen, each because it was received or because a later write has superseded it.

        If there are too many origins, the oldest absent ones are forgotten: their entries stay, and may be sent once
        more than necessary.

        Returns:
            Origins with writes that had not been seen.
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
        """Whether a peer has seen a write that is missing here.

        Args:
            seen: Number of the newest write that the peer has seen, by origin.
        """
        return any(number > self.seen.get(origin, 0) for origin, number in seen.items())

    def missing(self, seen: Mapping[str, int]) -> list[Entry]:
        """Entries that a peer may lack, in the order of their stamps.

        Args:
            seen: Number of the newest write that the peer has seen, by origin.
        """
        found = [entry for entry in self.entries.values() if entry.number > seen.get(entry.origin, 0)]
        return sorted(found, key=lambda entry: (entry.stamp, entry.origin, entry.number))

    def prune(self, stable: Mapping[str, int]) -> int:
        """Delete the records of removals that every peer has seen; returns the number of deleted records."""
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
        """All present values, by key."""
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
    """The nodes of a key: one, or the two ends of an edge."""
    return dict.fromkeys((key[0], key[2])) if len(key) == 4 else key[:1]
