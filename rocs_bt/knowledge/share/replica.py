"""A replica of shared knowledge: a map whose writes merge to the same, in whatever order and how often they arrive.

Each write is one entry under one key, and of two entries under a key the one with the later stamp stays (a last writer
wins register: Shapiro et al., Conflict-free Replicated Data Types, 2011, 3.2). Stamps are hybrid logical clocks
(Kulkarni et al., Logical Physical Clocks, 2014): a write is stamped later than every write that its writer knew, so a
clock that is wrong can only decide between writes of which neither knew of the other. What is superseded is forgotten:
a replica grows with what is known and what was removed of late, never with how often it was written.
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
"""What is shared of a value; None for what is not there, or not known any more."""

STAMP_LIMIT = 2**56
"""[us] A stamp beyond this, in the year 4253, is no stamp."""


STAMP_STEP = 2**20
"""[us] How far ahead of all that was seen a stamp may be that no calendar gives: nobody can use time up."""

ENTRY_LIMIT = 2**18
"""Entries of a replica, beyond which it takes no more from peers under keys that it has not."""

NAMES_LIMIT = 12288
"""[bytes] For the names of all starts that ever wrote: twice that, beside an entry, must fit into a frame."""


class Entry(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """One write.

    Attributes:
        key: What was written.
        value: Its value; None removes it.
        stamp: The writer's hybrid logical clock [us].
        origin: The writer, `agent#start`: another one at each of its starts.
        number: How many writes the origin had made with this one.
    """

    key: Key
    value: Plain
    stamp: int
    origin: str
    number: int

    def after(self, other: Entry | None) -> bool:
        """Whether this one stays and the other goes."""
        return other is None or (self.stamp, self.origin) > (other.stamp, other.origin)

    @property
    def weight(self) -> int:
        """What it adds to the sum by which replicas are compared; nothing where it removes."""
        if self.value is None:
            return 0
        packed = msgspec.msgpack.encode((self.key, self.value, self.stamp, self.origin))
        return int.from_bytes(hashlib.blake2b(packed, digest_size=8).digest(), "big")


class Replica:
    """All entries that stay, and which writes were seen.

    Args:
        origin: Who writes here; new at every start, for a number must never stand for two writes.
        calendar: The time since any origin that all peers share [s]; it may be wrong.

    Attributes:
        entries: By key, what was removed too.
        since: By key, when its entry was written, by the clock of whoever holds the replica [s].
        seen: By origin, up to which number its writes were seen, here or through others.
        sum: Equal for equal contents, and for nothing else but by an accident of 1 in 2^64.
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
        self._names = 0  # [bytes] of what is seen, as it is sent

    def value(self, key: Key) -> Plain:
        """What stands under a key; None for nothing."""
        entry = self.entries.get(key)
        return None if entry is None else entry.value

    def about(self, node: str) -> list[Key]:
        """The keys of a node's attributes, and of all edges from or to it, in the order in which they came."""
        return list(self._about.get(node, ()))

    def write(self, key: Key, value: Plain, t: float, *, first: bool = False) -> Entry:
        """Write.

        Args:
            key: Where.
            value: What; None to remove it.
            t: Now, by the holder's clock [s].
            first: What its holder knew before it met anybody, and so gives way to all that anybody wrote since.
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
        """Whether there is room for an entry that came, and time after it.

        A stamp that no calendar gives comes of counting on from others. One that is far ahead of all that was seen
        comes of nothing: if it were taken, no later stamp would be left for anybody.
        """
        if entry.stamp > max(self._stamp, STAMP_LIMIT // 2) + STAMP_STEP:
            return False
        return entry.key in self.entries or len(self.entries) < ENTRY_LIMIT

    def merge(self, entry: Entry, since: float) -> bool:
        """Take an entry that came; True where it stays."""
        self._stamp = max(self._stamp, entry.stamp)
        if not entry.after(self.entries.get(entry.key)):
            return False
        self._put(entry, since)
        return True

    def learn(self, seen: Mapping[str, int], here: Collection[str] = ()) -> list[str]:
        """All of these writes were seen, or were superseded by others that were.

        When there are too many starts the oldest are forgotten that are not here: what they wrote stays, and may be
        sent once more than it need be.

        Returns:
            The starts of which there is news.
        """
        news = [origin for origin, number in seen.items() if number > self.seen.get(origin, 0)]
        for origin in news:
            self._names += 0 if origin in self.seen else _length(origin)
            self.seen[origin] = seen[origin]
        if self._names > NAMES_LIMIT:
            for origin in sorted(self.seen, key=lambda each: each in here):
                if self._names > NAMES_LIMIT and origin != self.origin:
                    del self.seen[origin]
                    self._names -= _length(origin)
        return news

    def lacks(self, seen: Mapping[str, int]) -> bool:
        """Whether somebody who has seen this has seen a write that was not seen here."""
        return any(number > self.seen.get(origin, 0) for origin, number in seen.items())

    def missing(self, seen: Mapping[str, int]) -> list[Entry]:
        """The entries that somebody who has seen this may not have, in the order of their stamps."""
        found = [entry for entry in self.entries.values() if entry.number > seen.get(entry.origin, 0)]
        return sorted(found, key=lambda entry: (entry.stamp, entry.origin, entry.number))

    def prune(self, stable: Mapping[str, int]) -> int:
        """Forget what was removed by writes that everybody has seen; how many these were."""
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
        """All that is known, by key."""
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
    """The nodes that a key is about: one, or the two ends of an edge."""
    return dict.fromkeys((key[0], key[2])) if len(key) == 4 else key[:1]
