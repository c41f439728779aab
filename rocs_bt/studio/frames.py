"""Messages between a run and the process of its live page: length-prefixed MessagePack frames."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_
from typing import IO, Any, TypeVar

import msgspec

from ..event import Event
from ..record import codec

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


class Answer(msgspec.Struct, frozen=True):
    """Reply of the page's process: its port, or the reason why it cannot serve the page."""

    port: int = 0
    error: str = ""


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
    return stream.read(int.from_bytes(length, "little")) if len(length) == 4 else None


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
