"""Events as JSON and back, exactly; the topic and the schema of each kind.

JSON has no NaN and no infinity: msgspec writes null. Where an event holds such a number, its message gets one more
key, `non_finite`: a list with the place of each, and its eight bytes in hexadecimal, for a NaN has a sign and more. So
viewers see plain JSON, and a reader gets the event back to the bit.
"""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, reduce
from typing import Any, cast

import msgspec
import numpy as np

from .. import event as ev
from ..errors import RecordingError
from ..event import Event
from ..nesting import check_nesting

#: Every kind of event that can be read back.
KINDS: tuple[type[Event], ...] = tuple(
    kind for kind in vars(ev).values() if isinstance(kind, type) and issubclass(kind, Event) and kind is not Event
)
# A kind that is not here goes to a topic of its class's name.
TOPICS: dict[type[Event], str] = {
    ev.SensorRead: "sensors",
    ev.SensorFailed: "sensor_failures",
    ev.SignalsWritten: "signals",
    ev.Change: "changes",
    ev.KnowledgeChanged: "knowledge",
    ev.RuleChanged: "rules",
    ev.NodeTicked: "tree",
    ev.SubtreeSwapped: "swaps",
    ev.Replanned: "replans",
    ev.TicketChanged: "tickets",
    ev.AtomicStarted: "atomic_actions",
    ev.ActuatorCommanded: "commands",
    ev.Followed: "follower",
    ev.BlockFailed: "blocks",
    ev.ContentRaised: "exceptions",
    ev.BodyMoved: "poses",
    ev.Touched: "contacts",
    ev.Judged: "outcome",
}
SCHEMA_PREFIX = "rocs_bt."
#: All that encoding can raise for an event that holds what an event must not.
UNFIT = (TypeError, ValueError, OverflowError, RecursionError, struct.error)
_DOUBLE = struct.Struct(">d")
_WHOLE = frozenset((str, bytes, int, bool, type(None)))  # what can hold no NaN


def topic_of(kind: type[Event], agent: str) -> str:
    """The topic of a kind of event: `/R2/tickets`, or `/world/poses` where it has no agent."""
    return f"/{agent or 'world'}/{TOPICS.get(kind, kind.__name__)}"


@cache
def schema_of(kind: type[Event]) -> bytes:
    """The JSON schema of a kind of event: an object at its root, as viewers want it."""
    (schema,), components = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
    schema = components.pop(kind.__name__)
    schema["properties"]["non_finite"] = {"type": "array", "items": {"type": "array"}}
    return msgspec.json.encode({**schema, "$defs": components} if components else schema)


def plain(value: Any) -> Any:
    """What msgspec cannot encode, as something that it can: numpy's numbers and arrays, and views of mappings."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is not data that an event may hold")


_ENCODER = msgspec.json.Encoder(enc_hook=plain)
_ENCODE, _LINES = _ENCODER.encode, _ENCODER.encode_lines
_ANY: Any = reduce(operator.or_, KINDS)
_DECODE = msgspec.json.Decoder(_ANY).decode


def encode(event: Event) -> bytes:
    """An event as JSON.

    Raises:
        TypeError: It holds something that is not data.
        ValueError: It holds text that is not Unicode, or the like.
    """
    data = _ENCODE(event)
    # Most nulls are a None; only what is no finite number needs its bits beside it.
    return _exact(event) if b"null" in data and not _sound(event) else data


def encode_all(events: Sequence[Event]) -> list[bytes | None]:
    """Many events in one go, which is faster; None for each that must be encoded by itself."""
    try:
        lines = _LINES(events).split(b"\n")
    except UNFIT:  # one of them; `encode` tells which
        return [None] * len(events)
    lines.pop()  # what comes after the last line's end
    return [None if b"null" in line and not _sound(event) else line for line, event in zip(lines, events, strict=True)]


def decode(data: bytes) -> Event:
    """The event that `encode` made JSON of.

    Raises:
        RecordingError: It is no such message.
    """
    try:
        check_nesting(data)
        if b'"non_finite"' not in data:
            return cast(Event, _DECODE(data))
        fields = msgspec.json.decode(data)
        for *where, last, bits in fields.pop("non_finite", ()):
            reduce(lambda at, key: at[key], where, fields)[last] = _DOUBLE.unpack(bytes.fromhex(bits))[0]
        return cast(Event, msgspec.convert(fields, _ANY))
    except (msgspec.DecodeError, msgspec.ValidationError, LookupError, TypeError, ValueError, struct.error) as error:
        raise RecordingError(f"a message cannot be read back: {error}; it begins with {data[:80]!r}.") from error


def _sound(event: Event) -> bool:
    """Whether no NaN and no infinity is in an event, so that each null in its JSON is a None."""
    return _finite(getattr(event, name) for name in event.__struct_fields__)


def _finite(values: Iterable[Any]) -> bool:
    """Whether no NaN and no infinity is in any of them; False too where only a closer look can tell."""
    for value in values:
        kind = type(value)
        if kind is float:
            if not math.isfinite(value):
                return False
        elif kind is list or kind is tuple:
            if not _finite(value):
                return False
        elif kind is dict:
            if not _finite(value.values()):
                return False
        elif kind not in _WHOLE:
            return False
    return True


def _exact(event: Event) -> bytes:
    fields = msgspec.to_builtins(event, enc_hook=plain)
    places = list(_non_finite(fields, ()))
    return msgspec.json.encode({**fields, "non_finite": places} if places else fields)


def _non_finite(value: Any, where: tuple[Any, ...]) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        yield [*where, _DOUBLE.pack(value).hex()]
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _non_finite(inner, (*where, key))
    elif isinstance(value, (list, tuple)):
        for index, inner in enumerate(value):
            yield from _non_finite(inner, (*where, index))
