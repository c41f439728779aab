"""Messages between a run and the process of its page: length-prefixed MessagePack frames, in both directions."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import reduce
from operator import or_
from typing import IO, TYPE_CHECKING, Any, TypeVar

import msgspec

from ..event import Event
from ..record import RunHeader
from ..record.file import codec

if TYPE_CHECKING:
    from .feed import Feed

_KINDS = frozenset(codec.KINDS)
_ANY: Any = reduce(or_, codec.KINDS)
_ENCODE = msgspec.msgpack.Encoder(enc_hook=codec.plain).encode
_EVENTS: msgspec.msgpack.Decoder[list[Event]] = msgspec.msgpack.Decoder(list[_ANY])
T = TypeVar("T")


class Settings(msgspec.Struct, frozen=True):
    """First frame to the page's process: address to serve on, and the secret token of the page's URL."""

    host: str
    port: int
    token: str


class PageReply(msgspec.Struct, frozen=True):
    """Reply of the page's process: the URL of the page, or the reason why it cannot serve it."""

    url: str = ""
    error: str = ""


class Sender:
    """Writes frames from several threads; a closed pipe loses them."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._lock = threading.Lock()

    def send(self, frame: bytes) -> bool:
        """Send a frame; returns whether the other process may have got it."""
        try:
            with self._lock:
                self._stream.write(frame)
                self._stream.flush()
        except (OSError, ValueError):  # the other process has ended, or this one has closed the pipe
            return False
        return True


def receive(stream: IO[bytes], feed: Feed) -> None:
    """Pass a run to a feed, until its process has closed the stream or died."""
    if (header := read(stream)) is not None:
        feed.begin(decode(header, RunHeader))
    while (data := read(stream)) is not None:
        feed.take(decode_events(data))


def encode(value: object) -> bytes:
    """Encode a value as a frame."""
    data = _ENCODE(value)
    return len(data).to_bytes(4, "little") + data


def encode_events(events: Sequence[Event]) -> bytes:
    """Encode the events that the page shows as a frame, without events that cannot be encoded."""
    wanted = [event for event in events if type(event) in _KINDS]
    try:
        return encode(wanted)
    except codec.UNFIT:
        return encode([event for event in wanted if _fit(event)])


def read(stream: IO[bytes]) -> bytes | None:
    """Read the content of the next frame; None at the end of the stream."""
    length = stream.read(4)
    size = int.from_bytes(length, "little")
    data = stream.read(size) if len(length) == 4 else b""
    return data if len(length) == 4 and len(data) == size else None  # a process that died left a part of a frame


def decode(data: bytes, kind: type[T]) -> T:
    """Decode the content of a frame as a value."""
    return msgspec.msgpack.decode(data, type=kind)


def decode_events(data: bytes) -> list[Event]:
    """Decode the content of a frame as events."""
    return _EVENTS.decode(data)


def _fit(event: Event) -> bool:
    try:
        _ENCODE(event)
    except codec.UNFIT:
        return False
    return True
