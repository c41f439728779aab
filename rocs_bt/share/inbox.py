"""Inbox: queue of frames (encoded messages) received from peers; rejects invalid and excess frames."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass

from .scope import is_origin
from .wire import FRAME_LIMIT, Delta, Message, decode, genuine, sender_of

PER_SENDER = 256
"""Maximum number of waiting frames of one sender."""

PER_SENDER_BYTES = 2**22
"""Maximum size of the waiting frames of one sender [bytes]."""

WAITING_BYTES = 2**25
"""Maximum size of all waiting frames [bytes]."""

SENDERS = 256
"""Maximum number of senders with waiting frames."""


@dataclass
class Counts:
    """Numbers of frames and writes since the start of sharing. A frame is one encoded message.

    Attributes:
        frames: Received frames, including rejected ones.
        oversized: Frames rejected because they exceed the maximum size.
        unauthenticated: Frames rejected because they lack the group's authentication.
        malformed: Frames rejected because their content is invalid.
        flooded: Frames dropped because too many were waiting.
        refused: Writes of peers refused because of the schema, a private node or a size limit.
        clashed: Writes of peers that were not applied because they conflict with the agent's graph.
        untold: Writes of this agent that were not sent because they are too large.
        written: Writes of this agent that were sent.
        merged: Writes of peers that were merged.
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


class FrameQueue:
    """Queue of received frames, filled by any thread and read by one; a flooding sender loses only its own frames."""

    def __init__(self, key: bytes, counts: Counts, wake: Callable[[], None] = lambda: None) -> None:
        self._key = key
        self._counts = counts
        self._wake = wake
        self._lock = threading.Lock()
        self._waiting: dict[str, deque[bytes]] = {}
        self._bytes: dict[str, int] = {}

    def put(self, frame: bytes) -> None:
        """Check and queue a received frame; decoding is left to `take`, so that a flood of frames costs little."""
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
        """Remove and decode waiting messages, one of each sender in turn; returns pairs of sender and message.

        `most` limits, approximately, the number of messages plus shared entries in them.
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
        """Whether frames are waiting."""
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
                self._waiting[sender] = queue  # behind the other senders
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
            if queue and (len(queue) >= PER_SENDER or not room):  # the first frame of a sender always has room
                self._counts.flooded += 1
                return
            queue.append(frame)
            self._bytes[sender] = size
        self._wake()
