"""What peers send each other, as bytes: sealed with the group's key, and bounded in size."""

from __future__ import annotations

import hashlib
import hmac
from typing import TypeAlias

import msgspec

from .replica import Entry

FRAME_LIMIT = 65536
"""[bytes] A longer frame is not even looked at."""

CHUNK = 24576
"""[bytes] How much of a replica goes into one frame, as far as its entries can be parted."""

_SEAL = 16  # [bytes]


class Heartbeat(msgspec.Struct, frozen=True, tag="beat", array_like=True):
    """I am here, and have seen this; `sum` and `scope` tell whether that is all.

    `time` is the sender's calendar [s], `ahead` how far it was corrected [s].
    """

    seen: dict[str, int]
    sum: int
    scope: str
    time: float
    ahead: float


class Delta(msgspec.Struct, frozen=True, tag="delta", array_like=True):
    """Entries, each with its age [s]; with all parts of one `sync`, who had seen `base` has seen `upto`."""

    sync: int
    part: int
    parts: int
    scope: str
    base: dict[str, int]
    upto: dict[str, int]
    entries: list[Entry]
    ages: list[float]


class Request(msgspec.Struct, frozen=True, tag="want", array_like=True):
    """Send me what I have not seen; with an empty `seen`, everything."""

    seen: dict[str, int]


class Ack(msgspec.Struct, frozen=True, tag="have", array_like=True):
    """I hold your writes up to this one."""

    number: int


class TextMessage(msgspec.Struct, frozen=True, tag="say", array_like=True):
    """A message for the robot's mind."""

    number: int
    text: str


class TextAck(msgspec.Struct, frozen=True, tag="heard", array_like=True):
    """Your message arrived; or why it could not be taken."""

    number: int
    problem: str


class Leave(msgspec.Struct, frozen=True, tag="bye", array_like=True):
    """I leave."""


Message: TypeAlias = Heartbeat | Delta | Request | Ack | TextMessage | TextAck | Leave

_ENCODER = msgspec.msgpack.Encoder()
_DECODER: msgspec.msgpack.Decoder[tuple[str, Message]] = msgspec.msgpack.Decoder(tuple[str, Message])
_OUTSIDE: msgspec.msgpack.Decoder[tuple[str, msgspec.Raw]] = msgspec.msgpack.Decoder(tuple[str, msgspec.Raw])


def encode(sender: str, message: Message, key: bytes) -> bytes:
    """A frame."""
    body = _ENCODER.encode((sender, message))
    return _seal(body, key) + body


def genuine(frame: bytes, key: bytes) -> bool:
    """Whether a frame was sealed with the group's key; with an empty one, whether it is whole."""
    return len(frame) > _SEAL and hmac.compare_digest(frame[:_SEAL], _seal(frame[_SEAL:], key))


def decode(frame: bytes) -> tuple[str, Message] | None:
    """Sender and message of a genuine frame; None where it makes no sense."""
    try:
        return _DECODER.decode(memoryview(frame)[_SEAL:])
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


def sender_of(frame: bytes) -> str | None:
    """The sender of a genuine frame, without what it says; None where there is none."""
    try:
        return _OUTSIDE.decode(memoryview(frame)[_SEAL:])[0]
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


def parts(entries: list[Entry]) -> list[list[Entry]]:
    """Entries in portions that fit into frames; one portion at least, even of none."""
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
    """Whether an entry fits into a frame by itself."""
    return len(_ENCODER.encode(entry)) < FRAME_LIMIT // 2


def _seal(body: bytes, key: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=_SEAL, key=key).digest()
