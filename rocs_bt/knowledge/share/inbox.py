"""The door for what comes from outside: nothing passes that is too long, not sealed, senseless, or too much."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass

from .scope import is_origin
from .wire import FRAME_LIMIT, Delta, Message, decode, genuine, sender_of

PER_SENDER = 256
"""Frames of one sender that wait at most."""

PER_SENDER_BYTES = 2**22
"""[bytes] For these."""

WAITING_BYTES = 2**25
"""[bytes] For all that wait."""

SENDERS = 256
"""Senders at most."""


@dataclass
class Counts:
    """What was turned away, and how much work there was; all count since the start.

    Attributes:
        frames: Frames that came.
        oversized: Frames that were too long.
        unauthenticated: Frames without the group's seal.
        malformed: Frames that make no sense.
        flooded: Frames beyond what one sender may have waiting.
        refused: Writes of peers that the schema, or what is private, does not allow, or for which there is no room;
            nothing of them is kept.
        clashed: Writes of peers that this graph cannot hold beside what it holds.
        untold: Own writes that are too large to be told.
        written: Own writes that were told.
        merged: Writes of peers that were taken.
    """

    frames: int = 0
    oversized: int = 0
    unauthenticated: int = 0
    malformed: int = 0
    flooded: int = 0
    refused: int = 0
    clashed: int = 0
    untold: int = 0
    written: int = 0
    merged: int = 0

    def as_dict(self) -> dict[str, int]:
        """The counts by name."""
        return asdict(self)


class Inbox:
    """Takes frames on any thread, and gives messages to one; a sender that floods crowds out itself alone.

    Args:
        key: The group's.
        counts: What was turned away.
        wake: Called when something came.
    """

    def __init__(self, key: bytes, counts: Counts, wake: Callable[[], None] = lambda: None) -> None:
        self._key = key
        self._counts = counts
        self._wake = wake
        self._lock = threading.Lock()
        self._waiting: dict[str, deque[bytes]] = {}
        self._bytes: dict[str, int] = {}

    def put(self, frame: bytes) -> None:
        """Take a frame, or turn it away and count it; it is read when it is taken, so that a flood costs little."""
        counts = self._counts
        counts.frames += 1
        if len(frame) > FRAME_LIMIT:
            counts.oversized += 1
        elif not genuine(frame, self._key):
            counts.unauthenticated += 1
        elif (sender := sender_of(frame)) is None or not is_origin(sender):
            counts.malformed += 1
        else:
            self._admit(sender, frame)

    def take(self, most: int) -> list[tuple[str, Message]]:
        """The messages that wait, each with its sender: in turn, one of each, until they weigh so much.

        Each weighs 1, and one with entries so much more as it has of them.
        """
        found: list[tuple[str, Message]] = []
        while most > 0 and (frame := self._next()) is not None:
            most -= 1
            if (decoded := decode(frame)) is None:
                self._counts.malformed += 1
                continue
            found.append(decoded)
            most -= len(decoded[1].entries) if isinstance(decoded[1], Delta) else 0
        return found

    @property
    def pending(self) -> bool:
        """Whether something waits."""
        return bool(self._waiting)

    def _next(self) -> bytes | None:
        with self._lock:
            if not self._waiting:
                return None
            sender = next(iter(self._waiting))
            queue = self._waiting.pop(sender)
            frame = queue.popleft()
            self._bytes[sender] -= len(frame)
            if queue:
                self._waiting[sender] = queue  # behind the others
            else:
                del self._bytes[sender]
            return frame

    def _admit(self, sender: str, frame: bytes) -> None:
        with self._lock:
            queue = self._waiting.get(sender)
            if queue is None:
                if len(self._waiting) >= SENDERS:
                    self._counts.flooded += 1
                    return
                queue, self._bytes[sender] = self._waiting.setdefault(sender, deque()), 0
            size = self._bytes[sender] + len(frame)
            room = size <= PER_SENDER_BYTES and sum(self._bytes.values()) + len(frame) <= WAITING_BYTES
            if queue and (len(queue) >= PER_SENDER or not room):  # the first of anybody has room
                self._counts.flooded += 1
                return
            queue.append(frame)
            self._bytes[sender] = size
        self._wake()
