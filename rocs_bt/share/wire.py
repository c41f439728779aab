"""Wire format of the messages between peers. A frame is one encoded message with its authentication code."""

from __future__ import annotations

import hashlib
import hmac
from typing import TypeAlias

import msgspec

from .replica import Entry

FRAME_LIMIT = 65536
"""Maximum size of a frame [bytes]; longer ones are dropped unread."""

CHUNK = 24576
"""Target size of the entries in one message [bytes]; more entries are sent in several parts."""

_SEAL = 16  # [bytes]


class Heartbeat(msgspec.Struct, frozen=True, tag="beat", array_like=True):
    """Periodic message that shows the presence of its sender.

    `seen` contains the number of the newest write that the sender has seen, by origin. `sum` is the checksum of its
    replica, and `scope` the digest of its scope. `time` is the sender's calendar time [s], which includes the
    correction `ahead` [s].
    """

    seen: dict[str, int]
    sum: int
    scope: str
    time: float
    ahead: float


class Delta(msgspec.Struct, frozen=True, tag="delta", array_like=True):
    """Message with shared entries, or one of the parts of a message that is too long for a frame.

    A receiver that had seen the writes up to `base` has seen the writes up to `upto` when all parts with the same
    `sync` have arrived. `base` and `upto` contain the number of the newest write of each origin. `ages` contains the
    age of each entry [s].
    """

    sync: int
    part: int
    parts: int
    scope: str
    base: dict[str, int]
    upto: dict[str, int]
    entries: list[Entry]
    ages: list[float]


class Request(msgspec.Struct, frozen=True, tag="want", array_like=True):
    """Request for entries that the sender lacks; `seen` is the newest write of each origin that it has seen."""

    seen: dict[str, int]


class Ack(msgspec.Struct, frozen=True, tag="have", array_like=True):
    """Acknowledgement that the sender has seen the receiver's writes up to `number`."""

    number: int


class TextMessage(msgspec.Struct, frozen=True, tag="say", array_like=True):
    """Text message to the receiver's agent."""

    number: int
    text: str


class TextAck(msgspec.Struct, frozen=True, tag="heard", array_like=True):
    """Acknowledgement of a text message, or the reason why it was rejected."""

    number: int
    problem: str


class Leave(msgspec.Struct, frozen=True, tag="bye", array_like=True):
    """Announcement that the sender leaves the network."""


Message: TypeAlias = Heartbeat | Delta | Request | Ack | TextMessage | TextAck | Leave

_ENCODER = msgspec.msgpack.Encoder()
_DECODER: msgspec.msgpack.Decoder[tuple[str, Message]] = msgspec.msgpack.Decoder(tuple[str, Message])
_OUTSIDE: msgspec.msgpack.Decoder[tuple[str, msgspec.Raw]] = msgspec.msgpack.Decoder(tuple[str, msgspec.Raw])


def encode(sender: str, message: Message, key: bytes) -> bytes:
    """Encode a message as a frame, authenticated with the group's secret `key`."""
    body = _ENCODER.encode((sender, message))
    return _seal(body, key) + body


def genuine(frame: bytes, key: bytes) -> bool:
    """Whether a frame was authenticated with the group's key; with an empty key, whether it is undamaged."""
    return len(frame) > _SEAL and hmac.compare_digest(frame[:_SEAL], _seal(frame[_SEAL:], key))


def decode(frame: bytes) -> tuple[str, Message] | None:
    """Sender and message of a genuine frame; None if it is malformed."""
    try:
        return _DECODER.decode(memoryview(frame)[_SEAL:])
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


def sender_of(frame: bytes) -> str | None:
    """Sender of a genuine frame, without decoding the message; None if it is malformed."""
    try:
        return _OUTSIDE.decode(memoryview(frame)[_SEAL:])[0]
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


def parts(entries: list[Entry]) -> list[list[Entry]]:
    """Split entries into portions that each fit into a frame; returns at least one portion, even without entries."""
    portions: list[list[Entry]] = [[]]
    size = 0
    for entry in entries:
        length = len(_ENCODER.encode(entry)) + 9  # with its age
        if size + length > CHUNK and portions[-1]:
            portions.append([])
            size = 0
        portions[-1].append(entry)
        size += length
    return portions


def fits(entry: Entry) -> bool:
    """Whether an entry fits into a frame on its own."""
    return len(_ENCODER.encode(entry)) < FRAME_LIMIT // 2


def _seal(body: bytes, key: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=_SEAL, key=key).digest()
